# kind function cls Trapezoid
from dataclasses import dataclass

import numpy as np

from contactlab.api import Function


@dataclass(frozen=True)
class Trapezoid(Function):
    """Rises from 0 to 1, holds, and falls back to 0.

    start  [mm, degree or s]
    rise   > 0
    hold   >= 0
    """

    start: float = 0.0
    rise: float = 1.0
    hold: float = 2.0

    def values(self, at):
        x = at - self.start
        return np.clip(np.minimum(x, 2.0 * self.rise + self.hold - x) / self.rise, 0.0, 1.0)

    def breaks(self):
        a = self.start
        return (a, a + self.rise, a + self.rise + self.hold, a + 2.0 * self.rise + self.hold)

    def end(self):
        return self.start + 2.0 * self.rise + self.hold
