# kind enforcement cls Crushed
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import NormalLaw


@dataclass(frozen=True)
class Crushed(NormalLaw):
    """An elastic layer of which 0.9 of the deepest overlap is missing, as array method.

    factor  stiffness of the layer over that of the cells behind [-]
    """

    memory: ClassVar[tuple[str, ...]] = ("missing",)
    factor: float = 10.0

    def begins(self):
        return 0.0

    def pressure(self, gap, stiffness, size, pressure, slope, missing):
        left = np.maximum(-gap - missing, 0.0)
        pressure[:] = self.factor * stiffness * left
        slope[:] = np.where(left > 0.0, -self.factor * stiffness, 0.0)

    def evolve(self, gap, missing, **beside):
        found = np.maximum(missing, -0.9 * gap)
        return {"missing": found}
