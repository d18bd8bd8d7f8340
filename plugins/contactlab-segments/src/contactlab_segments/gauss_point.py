"""Gauss-point-to-segment contact (Fischer & Wriggers 2005): integrals over the slave, by points.

Contact holds in the mean, as in a mortar method: with N_j the hats of the slave's nodes,

    g_j = sum over points q of  w_q N_j(x_q) (x_q - y_q) . n_j  >= 0,

where each Gauss point x_q of a slave segment has a foot y_q on the master, the closest point, whatever segment that is
on. No overlap of segments is looked for: the sum takes the place of the integral, which is what makes the method cheap
and simple. The cost: if a node of the master lies between two points the integrand has a kink that the sum does not
know, so a patch test fails by the error of the rule, of the order of the square of the segments over the number of
points. The error affects forces along the slave; resultants and moments of both sides balance exactly.

Pressures are linear between nodes and the force of a point is w_q p(x_q) n, so multipliers and penalties work alike.
With a condition, or a penalty, of its own at each point there would be more conditions than a slave node can follow:
exact multipliers would be indeterminate, and stiff penalties lock.

With `passes = 2` neither side is the slave (two half passes, Sauer & De Lorenzis 2013, 2015). Each point of either side
presses by a law of its own gap, and the force acts on the side of the point alone:

    f_i = sum over the points of that side of  w_q N_i(x_q) p(g_q) n_q,    g_q = (x_q - y_q) . n_q.

So a uniform gap gives both sides the consistent forces of a uniform pressure, whatever the meshes. Opposite forces of
both sides are not enforced: they follow as far as the meshes resolve the gap (docs/theory/surfaces.md).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from contactlab.api import ContactAlgorithm, PointContact, formula


@dataclass(frozen=True)
class GaussPoint(PointContact):
    """Three Gauss points of each slave segment stay outside the nearest master segment in the mean of each node.

    passes  1; or 2, for pressure laws: each side is slave in a pass of its own and takes the forces of that alone
    """

    passes: int = 1

    points: ClassVar[int] = 3
    passes_patch_test: ClassVar[bool] = False
    keeps_energy: ClassVar[bool] = True

    def __post_init__(self) -> None:
        if self.passes not in (1, 2):
            raise ValueError(f"passes: got {self.passes}, allowed: 1 or 2")

    def half_pass(self) -> ContactAlgorithm | None:
        """Points that press one by one, if neither side is the slave alone."""
        return GaussPointPass() if self.passes == 2 else None

    @formula
    def foot(x: Any, master: Any) -> Any:
        """The closest point of the segment's line."""
        edge = master.edge()
        return ((x.at - master.start) @ edge) / (edge @ edge)


@dataclass(frozen=True)
class GaussPointPass(PointContact):
    """Half pass: each of three Gauss points presses by its own gap, and on its own side alone."""

    points_press: ClassVar[bool] = True
    points: ClassVar[int] = 3
    passes_patch_test: ClassVar[bool] = False

    @formula
    def foot(x: Any, master: Any) -> Any:
        """The closest point of the segment's line."""
        edge = master.edge()
        return ((x.at - master.start) @ edge) / (edge @ edge)
