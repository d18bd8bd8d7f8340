# kind enforcement cls Rough
from dataclasses import dataclass
from typing import ClassVar

from contactlab.api import NormalLaw, formula


@dataclass(frozen=True)
class Rough(NormalLaw):
    """Rough surfaces: p = stiffness ((open - gap)+)^m / open^(m - 1).

    open      gap at which asperities touch [mm]
    exponent  m [-]
    """

    pressure_before_contact: ClassVar[bool] = True
    length_scale: ClassVar[str] = "open"
    open: float = 0.02
    exponent: float = 2.5

    @formula
    def pressure(gap, stiffness, p):
        x = max(0.0, p.open - gap) / p.open
        return stiffness * p.open * x**p.exponent

    def begins(self):
        return self.open
