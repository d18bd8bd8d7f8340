# kind function cls Saw
from dataclasses import dataclass

import numpy as np

from contactlab.api import Function


@dataclass(frozen=True)
class Saw(Function):
    """A saw tooth of `count` teeth, then nothing.

    period  [mm, degree or s]
    count   teeth
    """

    period: float = 2.0
    count: int = 5

    def values(self, at):
        x = at / self.period
        return np.where((x >= 0.0) & (x < self.count), x - np.floor(x), 0.0)

    def breaks(self):
        return tuple(self.period * k for k in range(self.count + 1))

    def end(self):
        return self.period * self.count
