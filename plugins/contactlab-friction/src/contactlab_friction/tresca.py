"""Tresca friction."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from contactlab.api import FrictionBound, FrictionLaw


@dataclass(frozen=True)
class Tresca(FrictionLaw):
    """Tangential stress bounded by a given slip stress (Baillet & Sassi 2005, 5.2).

    stress  slip stress s [MPa], above 0
    where   "closed": only where pressed; "everywhere": on all of the surface in reach, open or not, as
            the problem with a given bound is stated
    ramp    "closed" lets the bound grow with the pressure, min(s, ramp p): without a ramp no set of closed
            nodes is consistent at the edge of contact on most meshes
    """

    stress: float
    where: Literal["closed", "everywhere"] = "closed"
    ramp: float = 5.0

    def __post_init__(self) -> None:
        if not 0.0 < self.stress < math.inf:
            raise ValueError(f"stress: got {self.stress}, allowed: a slip stress > 0 [MPa]")
        if not self.ramp > 0.0:
            raise ValueError(f"ramp: got {self.ramp}, allowed: a factor > 0 (5 is usual)")

    def bound(self) -> FrictionBound:
        """s times the length that a node stands for, capped by the pressure if only closed nodes rub."""
        cap = math.inf if self.where == "everywhere" else self.ramp
        return FrictionBound(coefficient=0.0, adhesion=self.stress, cap=cap)
