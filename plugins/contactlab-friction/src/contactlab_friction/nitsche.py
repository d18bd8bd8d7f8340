"""Contact without multipliers by Nitsche's method: the pressure is that of the slave's own stress, held by the gap."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from contactlab.api import NormalLaw, formula

SMALLEST = 1.0  # gamma: a quarter of what a cell's edge may have of stress beside its energy


@dataclass(frozen=True)
class Nitsche(NormalLaw):
    """Pressure [-(sigma + gamma g)]_+ of the normal stress sigma of the slave's cells and the gap g.

    The incomplete variant (Chouly, Hild & Renard 2015, theta = 0): consistent, so that a gap is as small as the mesh
    allows whatever gamma is, and no multiplier is an unknown.

    gamma  stiffness of the gap over that of the cells behind the slave, dilatational modulus over depth [-]
    """

    needs: ClassVar[tuple[str, ...]] = ("traction",)

    gamma: float = 10.0

    def __post_init__(self) -> None:
        if not SMALLEST <= self.gamma < math.inf:
            raise ValueError(
                f"gamma: got {self.gamma}, allowed: {SMALLEST:g} and above; smaller ones let surfaces pass into each "
                "other without a sign of it (docs/theory/nitsche.md)"
            )

    @formula
    def pressure(gap: Any, traction: Any, stiffness: float, p: Any) -> Any:
        """What the stress says, and more where surfaces overlap."""
        return max(0.0, -traction - p.gamma * stiffness * gap)
