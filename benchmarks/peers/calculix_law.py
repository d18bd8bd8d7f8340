"""CalculiX' neo-Hookean law for contactlab: `contactlab run ... --with benchmarks/peers/calculix_law.py`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import Floats, Kinematics, Material
from contactlab.api.plugin import Part, hookimpl


@dataclass(frozen=True)
class NeoHooke(Material):
    """W = mu/2 (tr b J^-2/3 - 3) + K/2 (J - 1)^2, plane strain.

    young    Young's modulus at small strain [MPa]
    poisson  Poisson's ratio at small strain
    density  of the undeformed body [t/mm3]
    """

    young: float
    poisson: float
    density: float

    kinematics: ClassVar[Kinematics] = "finite"
    has_energy: ClassVar[bool] = True

    def moduli(self) -> tuple[float, float]:
        """Shear and bulk modulus [MPa]."""
        return 0.5 * self.young / (1.0 + self.poisson), self.young / (3.0 * (1.0 - 2.0 * self.poisson))

    def wave_speeds(self) -> tuple[float, float]:
        """At small strain [mm/s]."""
        shear, bulk = self.moduli()
        return float(np.sqrt((bulk + 4.0 * shear / 3.0) / self.density)), float(np.sqrt(shear / self.density))

    @staticmethod
    def deformation(gradient: Floats) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        """xx, yy, xy of b = F F^T, J^-2/3 and J, from F^-1."""
        xx, xy, yx, yy = gradient
        jacobian = 1.0 / (xx * yy - xy * yx)
        squared = jacobian * jacobian
        return (
            squared * (yy**2 + xy**2), squared * (xx**2 + yx**2), -squared * (yy * yx + xy * xx),
            np.cbrt(squared) ** -1.0, jacobian,
        )  # fmt: skip

    def stress(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        """sigma = mu J^-5/3 dev b + K (J - 1) I."""
        shear, bulk = self.moduli()
        b_xx, b_yy, b_xy, scale, jacobian = self.deformation(gradient)
        third, factor = (b_xx + b_yy + 1.0) / 3.0, shear * scale / jacobian
        pressure = bulk * (jacobian - 1.0)
        stress[0] = factor * (b_xx - third) + pressure
        stress[1] = factor * (b_yy - third) + pressure
        stress[2] = factor * (1.0 - third) + pressure
        stress[3] = factor * b_xy

    def energy(self, gradient: Floats, history: Floats, energy: Floats) -> None:
        """W/J."""
        shear, bulk = self.moduli()
        b_xx, b_yy, _, scale, jacobian = self.deformation(gradient)
        stored = 0.5 * shear * (scale * (b_xx + b_yy + 1.0) - 3.0) + 0.5 * bulk * (jacobian - 1.0) ** 2
        energy[:] = stored / jacobian


@hookimpl
def contactlab_parts() -> list[Part]:
    """The law alone."""
    return [Part("material", "calculix-neo-hooke", "calculix_law:NeoHooke", "CalculiX' neo-Hookean law")]
