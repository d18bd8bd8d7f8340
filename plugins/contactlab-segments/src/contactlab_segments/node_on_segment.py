"""Node-on-segment contact, one pass (Hallquist, Goudreau & Benson 1985): no slave node may be inside the master.

The master is a chain of segments. Each slave node x has a foot y, the closest point of the master, and a gap along the
normal n of the master there,

    g = (x - y) . n >= 0,    y = a + eta (b - a),    eta = (x - a) . (b - a) / |b - a|^2,

and if the gap is zero a pressure p may act: l p n on the node and -l p n on the master, shared between the ends of
the segment as 1 - eta and eta, with l the length of slave that the node stands for. Forces and moments balance, and
since the foot is the closest point neither its motion along the segment nor the turning of n changes g to first order:
conditions of frictionless contact need no more than n and the shares.

Each node has a condition of its own, which makes the method simple, cheap and local. The cost: forces of a uniform
pressure are not consistent with its elements, so that a patch test fails where meshes do not match, and what the
master has between two slave nodes is not seen. So corners of the master are also held from outside the slave's
segments.
The core has all that a chain of segments is not by itself: which segment is the nearest and when another takes over,
vertices between segments, where there is no foot, concave corners, where there are two, corners, and the parabolas of
quadratic edges (docs/theory/surfaces.md).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from contactlab.api import PointContact, formula


@dataclass(frozen=True)
class NodeOnSegment(PointContact):
    """Slave nodes stay outside the nearest master segment, or the parabola of a quadratic edge."""

    points: ClassVar[int] = 0
    passes_patch_test: ClassVar[bool] = False
    keeps_energy: ClassVar[bool] = True
    closest_points: ClassVar[bool] = True

    @formula
    def foot(x: Any, master: Any) -> Any:
        """The closest point of the segment's line."""
        edge = master.edge()
        return ((x.at - master.start) @ edge) / (edge @ edge)
