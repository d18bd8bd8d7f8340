"""Gauss-point-to-segment contact, one pass (Fischer & Wriggers 2005): integrals over the slave, by points.

Contact holds in the mean, as in a mortar method: with N_j the hats of the slave's nodes,

    g_j = sum over points q of  w_q N_j(x_q) (x_q - y_q) . n_j  >= 0,

where each Gauss point x_q of a slave segment has a foot y_q on the master, the closest point, whatever segment that is
on. No overlap of segments is looked for: the sum takes the place of the integral, which is what makes the method cheap
and simple. The price: where a node of the master lies between two points the integrand has a kink that the sum does not
know, so a patch test fails by the error of the rule, of the order of the square of the segments over the number of
points. The error is that of forces along the slave; resultants and moments of both sides balance exactly.

Pressures are linear between nodes and the force of a point is w_q p(x_q) n, so multipliers and penalties work alike.
With a condition, or a penalty, of its own at each point there would be more conditions than a slave node can follow:
exact multipliers would be indeterminate, and stiff penalties lock.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from contactlab.api import PointContact, formula


@dataclass(frozen=True)
class GaussPoint(PointContact):
    """Three Gauss points of each slave segment stay outside the nearest master segment in the mean of each node."""

    points: ClassVar[int] = 3
    passes_patch_test: ClassVar[bool] = False
    keeps_energy: ClassVar[bool] = True

    @formula
    def foot(x: Any, master: Any) -> Any:
        """The closest point of the segment's line."""
        edge = master.edge()
        return ((x.at - master.start) @ edge) / (edge @ edge)
