# kind material cls Plain
"""A compressible neo-Hookean law, in plain NumPy, component by component."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import XX, XY, YY, ZZ, Floats, Kinematics, Material


@dataclass(frozen=True)
class Plain(Material):
    """Stored energy mu/2 (tr b - 3 - 2 ln J) + lambda/2 (J - 1)^2 per undeformed volume.

    young    [MPa] of small strains
    poisson  [-] of small strains
    density  [t/mm3]
    """

    young: float
    poisson: float
    density: float
    kinematics: ClassVar[Kinematics] = "finite"  # `gradient` is dX/dx: rows xx, xy, yx, yy
    has_energy: ClassVar[bool] = True

    def __post_init__(self) -> None:
        if not (self.young > 0.0 and 0.0 <= self.poisson < 0.5):
            raise ValueError(f"young, poisson: got {self.young}, {self.poisson}, allowed: > 0 and 0 <= poisson < 0.5")

    def moduli(self) -> tuple[float, float]:
        """mu and lambda [MPa]."""
        shear = 0.5 * self.young / (1.0 + self.poisson)
        return shear, 2.0 * shear * self.poisson / (1.0 - 2.0 * self.poisson)

    def wave_speeds(self) -> tuple[float, float]:
        shear, lame = self.moduli()
        return float(np.sqrt((lame + 2.0 * shear) / self.density)), float(np.sqrt(shear / self.density))

    @staticmethod
    def deformation(gradient: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """b = F F^T in the plane, rows xx, yy, xy, and J, from F^-1."""
        xx, xy, yx, yy = gradient
        jacobian = 1.0 / (xx * yy - xy * yx)
        squared = jacobian * jacobian
        return squared * (yy**2 + xy**2), squared * (xx**2 + yx**2), -squared * (yy * yx + xy * xx), jacobian

    def stress(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        shear, lame = self.moduli()
        b_xx, b_yy, b_xy, jacobian = self.deformation(gradient)
        pressure = lame * (jacobian - 1.0)
        stress[XX] = shear * (b_xx - 1.0) / jacobian + pressure
        stress[YY] = shear * (b_yy - 1.0) / jacobian + pressure
        stress[ZZ] = pressure
        stress[XY] = shear * b_xy / jacobian

    def energy(self, gradient: Floats, history: Floats, energy: Floats) -> None:
        shear, lame = self.moduli()
        b_xx, b_yy, _, jacobian = self.deformation(gradient)
        isochoric = 0.5 * shear * (b_xx + b_yy - 2.0 - 2.0 * np.log(jacobian))
        energy[:] = (isochoric + 0.5 * lame * (jacobian - 1.0) ** 2) / jacobian
