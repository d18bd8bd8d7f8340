# kind friction cls Wear
from dataclasses import dataclass

import numpy as np

from contactlab.api import FrictionBound, FrictionLaw


@dataclass(frozen=True)
class Wear(FrictionLaw):
    """A coating wears off: the coefficient rises from `new` to `worn` over a slid length.

    new     [-]
    worn    [-]
    length  [mm]
    """

    new: float = 0.1
    worn: float = 0.4
    length: float = 5.0
    needs = ("slip_rate", "dt")
    memory = ("slid",)

    def bound(self, slip_rate, dt, slid):
        mu = self.worn + (self.new - self.worn) * np.exp(-(slid + np.abs(slip_rate) * dt) / self.length)
        return FrictionBound(mu, 0.0, 0.0)

    def evolve(self, slip_rate, dt, slid):
        return {"slid": slid + np.abs(slip_rate) * dt}
