# kind material cls Damage
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import XX, XY, YY, ZZ, Material


@dataclass(frozen=True)
class Damage(Material):
    """Isotropic damage of small strains: sigma = (1 - D) C e, D = most (1 - exp(-(r - r0)/width)), r the energy norm.

    young    [MPa]
    poisson  [-]
    density  [t/mm3]
    first    strain energy at which damage begins [mJ/mm3]
    width    of its growth [mJ/mm3]
    most     D far beyond [-]
    """

    young: float = 1000.0
    poisson: float = 0.2
    density: float = 1e-9
    first: float = 0.05
    width: float = 2.0
    most: float = 0.5
    kinematics: ClassVar[str] = "small"
    history_size: ClassVar[int] = 2
    history_names: ClassVar[tuple[str, ...]] = ("largest", "lost")
    has_energy: ClassVar[bool] = True

    def moduli(self):
        shear = 0.5 * self.young / (1.0 + self.poisson)
        return shear, 2.0 * shear * self.poisson / (1.0 - 2.0 * self.poisson)

    def wave_speeds(self):
        shear, lame = self.moduli()
        return float(np.sqrt((lame + 2.0 * shear) / self.density)), float(np.sqrt(shear / self.density))

    def damage(self, largest):
        return self.most * -np.expm1(-np.maximum(largest - self.first, 0.0) / self.width)

    def lost(self, largest):
        """Integral of r dD/dr."""
        x = np.maximum(largest - self.first, 0.0) / self.width
        return self.most * ((self.first + self.width) * -np.expm1(-x) - self.width * x * np.exp(-x))

    def sound(self, gradient):
        shear, lame = self.moduli()
        xx, xy, yx, yy = gradient
        cross = 0.5 * (xy + yx)
        trace = xx + yy
        energy = 0.5 * lame * trace**2 + shear * (xx**2 + yy**2 + 2.0 * cross**2)
        return energy, (
            lame * trace + 2.0 * shear * xx,
            lame * trace + 2.0 * shear * yy,
            lame * trace,
            2.0 * shear * cross,
        )

    def stress(self, gradient, history, dt, stress, new_history):
        energy, sound = self.sound(gradient)
        largest = np.maximum(history[0], energy)
        keep = 1.0 - self.damage(largest)
        for row, value in zip((XX, YY, ZZ, XY), sound, strict=True):
            stress[row] = keep * value
        new_history[0] = largest
        new_history[1] = self.lost(largest)

    def energy(self, gradient, history, energy):
        energy[:] = (1.0 - self.damage(history[0])) * self.sound(gradient)[0]

    def dissipation(self, gradient, history, dissipation):
        dissipation[:] = history[1]
