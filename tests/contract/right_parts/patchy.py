# kind friction cls Patchy
from dataclasses import dataclass

import numpy as np

from contactlab.api import FrictionBound, FrictionLaw


@dataclass(frozen=True)
class Patchy(FrictionLaw):
    """Ice from `first` on along x, which forms over a time.

    mu     without ice [-]
    ice    with ice [-]
    first  where it begins [mm]
    width  of the passage [mm]
    time_constant  [s]
    """

    mu: float = 0.5
    ice: float = 0.05
    first: float = 1.0
    width: float = 0.5
    time_constant: float = 0.1
    needs = ("position", "time")

    def bound(self, position, time):
        share = 0.5 + 0.5 * np.tanh((position[:, 0] - self.first) / self.width)
        share = share * -np.expm1(-time / self.time_constant)
        return FrictionBound(self.mu + (self.ice - self.mu) * share, 0.0, 0.0)
