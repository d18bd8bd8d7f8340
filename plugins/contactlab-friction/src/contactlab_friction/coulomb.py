"""Coulomb friction."""

from __future__ import annotations

from dataclasses import dataclass

from contactlab.api import FrictionBound, FrictionLaw


@dataclass(frozen=True)
class Coulomb(FrictionLaw):
    """|y_t| <= mu y_n on nodal forces y = G1 Lambda (Baillet & Sassi 2005, [29] with the force as bound).

    mu  coefficient of friction [-], at least 0
    """

    mu: float

    def __post_init__(self) -> None:
        if not 0.0 <= self.mu < float("inf"):
            raise ValueError(f"mu: got {self.mu}, allowed: a coefficient of at least 0")

    def bound(self) -> FrictionBound:
        """Proportional to the normal force alone."""
        return FrictionBound(coefficient=self.mu, adhesion=0.0, cap=0.0)
