# kind friction cls Squeezed
from dataclasses import dataclass

import numpy as np

from contactlab.api import FrictionBound, FrictionLaw


@dataclass(frozen=True)
class Squeezed(FrictionLaw):
    """Coefficient that falls with the pressure: mu (1 + p/scale)^(-1/3).

    mu     [-]
    scale  [MPa]
    """

    mu: float = 0.3
    scale: float = 50.0
    needs = ("pressure",)

    def bound(self, pressure):
        return FrictionBound(self.mu * (1.0 + np.maximum(pressure, 0.0) / self.scale) ** (-1.0 / 3.0), 0.0, 0.0)
