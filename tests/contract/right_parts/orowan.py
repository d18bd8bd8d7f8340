# kind friction cls Orowan
from dataclasses import dataclass

from contactlab.api import FrictionBound, FrictionLaw


@dataclass(frozen=True)
class Orowan(FrictionLaw):
    """Coulomb up to the shear that the softer body yields at: min(mu p, limit).

    mu     [-]
    limit  [MPa]
    """

    mu: float = 0.2
    limit: float = 80.0

    def bound(self):
        return FrictionBound(coefficient=0.0, adhesion=self.limit, cap=self.mu)
