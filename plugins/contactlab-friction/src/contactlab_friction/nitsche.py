"""Contact without multipliers by Nitsche's method: the slave's own stress is the pressure, corrected by the gap."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from contactlab.api import NormalLaw, formula

STRESS = 9.0  # square of the edge stress of a q2 cell over its energy, at most; 4 of q1


@dataclass(frozen=True)
class Nitsche(NormalLaw):
    """Pressure [-(sigma + gamma g)]_+ of the normal stress sigma of the slave's cells and the gap g.

    Chouly, Hild & Renard (2015): consistent, so that a gap is as small as the mesh allows whatever gamma is, and no
    multiplier is an unknown. The terms -theta/gamma (sigma + p) of virtual stresses make it symmetric or stable.

    gamma  stiffness of the gap over the stiffness of the cells behind the slave, dilatational modulus over depth [-]
    theta  variant: 0 incomplete, 1 symmetric, -1 skew-symmetric; gamma is at least 9 (1 + theta)^2 / 4
    """

    needs: ClassVar[tuple[str, ...]] = ("traction",)

    gamma: float = 10.0
    theta: int = 0

    def __post_init__(self) -> None:
        if self.theta not in (-1, 0, 1):
            raise ValueError(f"theta: got {self.theta}, allowed: 0, 1 or -1")
        smallest = STRESS * (1 + self.theta) ** 2 / 4.0
        if smallest <= self.gamma < math.inf and self.gamma > 0.0:
            return
        reason = "with less, surfaces may pass into each other while iterations converge (docs/theory/nitsche.md); "
        allowed = f"{smallest:g} and above with theta = {self.theta}; {reason}try theta = -1" if smallest else "above 0"
        raise ValueError(f"gamma: got {self.gamma}, allowed: {allowed}")

    @formula
    def pressure(gap: Any, traction: Any, stiffness: float, p: Any) -> Any:
        """Pressure of the stress, and more where surfaces overlap."""
        return max(0.0, -traction - p.gamma * stiffness * gap)

    @formula
    def adjoint(pressure: Any, traction: Any, stiffness: float, p: Any) -> Any:
        """Return minus theta times the gap in contact."""
        return p.theta * (pressure + traction) / (p.gamma * stiffness)
