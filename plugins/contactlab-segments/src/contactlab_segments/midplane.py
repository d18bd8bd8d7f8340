"""Contact without slave and master, on the common line of two sides, by a penalty.

Two segments that face each other have a mean line, the bisector of their directions. Points of both are matched across
it, and the overlap of matched points, -g, has the energy

    E = 1/2 (integral over one side + integral over the other)  of  k/2 <-g>^2 dS,    p = k <-g>.

The sides enter alike: forces do not change when slave and master are exchanged. Integrals are split where segments
end, so that a uniform overlap is a uniform pressure on both sides, whatever the meshes. There are no multipliers and
no inf-sup condition: surfaces overlap by p / k. Theory: docs/theory/midplane.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import SegmentPotential, formula


@dataclass(frozen=True)
class Midplane(SegmentPotential):
    """Both sides press where they overlap, on the line between them; neither is the slave.

    stiffness  [-] pressure per overlap, over the stiffness of the cells behind: surfaces overlap by p h / (stiffness M)
               for each side, with the depth h of its cells and their dilatational modulus M
    """

    stiffness: float = 30.0

    passes_patch_test: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 < self.stiffness < np.inf:
            raise ValueError(f"stiffness: got {self.stiffness}, allowed: above 0, finite")

    @formula
    def normal(own: Any, other: Any) -> Any:
        """Return the normal of the bisector of both directions."""
        return (own.edge().unit() + other.edge().unit()).unit().turned()

    @formula
    def overlap(own: Any, other: Any) -> Any:
        """Return the part of `own` between the feet of the other's ends."""
        return own.opposite(other)

    @formula
    def energy(gap: Any, stiffness: Any, p: Any) -> Any:
        """Return k/2 g^2, with k from the cells of both sides."""
        return 0.5 * p.stiffness * stiffness * gap * gap
