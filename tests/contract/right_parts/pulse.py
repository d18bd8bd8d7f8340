# kind effect cls Pulse
import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import Effect


@dataclass(frozen=True)
class Pulse(Effect):
    """A half sine of force, spread over edge sets by length.

    on        edge sets
    force     [N] at its peak
    begin     [s]
    duration  [s]
    """

    on: tuple[str, ...]
    force: tuple[float, float] = (0.0, -1.0)
    begin: float = 1e-4
    duration: float = 1e-3
    vectors: ClassVar[tuple[str, ...]] = ("force",)
    conservative: ClassVar[bool] = True

    def times(self):
        return (self.begin, self.begin + self.duration)

    def bind(self, view):
        nodes, shares = view.shares(self.on)
        each = np.outer(shares, self.force)

        def add(time, force):
            s = (time - self.begin) / self.duration
            if 0.0 < s < 1.0:
                force[nodes] += math.sin(math.pi * s) * each

        return add
