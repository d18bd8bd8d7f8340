# kind enforcement cls Film
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import NormalLaw


@dataclass(frozen=True)
class Film(NormalLaw):
    """A film between the surfaces: p0 (u + u^2 + u^3) with u = 1 - gap/h, as an array method.

    film   h, thickness of the film [mm]
    p0     [MPa]
    """

    pressure_before_contact: ClassVar[bool] = True
    length_scale: ClassVar[str] = "film"
    film: float = 0.05
    p0: float = 3.0

    def pressure(self, gap, stiffness, size, pressure, slope):
        u = np.maximum(1.0 - gap / self.film, 0.0)
        pressure[:] = self.p0 * (u + u**2 + u**3)
        slope[:] = np.where(u > 0.0, -self.p0 * (1.0 + 2.0 * u + 3.0 * u**2) / self.film, 0.0)

    def begins(self):
        return self.film

    def energy(self, gap, stiffness, size):
        u = np.maximum(1.0 - gap / self.film, 0.0)
        return self.p0 * self.film * (u**2 / 2.0 + u**3 / 3.0 + u**4 / 4.0)
