"""Contact without slave and master, on the common line of two chains of segments, by a penalty.

Two segments that face each other have a mean line, the bisector of their directions. Points of both are matched across
it, and the overlap of matched points, -g, has the energy

    E = 1/2 (integral over one side + integral over the other)  of  k/2 <-g>^2 ds,    p = k <-g>,

with undeformed lengths ds. Nothing in it tells the sides apart: forces do not change when slave and master are
exchanged. Integrals are split where segments end. So they are exact, and a uniform overlap is a uniform pressure on
both sides, whatever the meshes. Forces are the derivatives of the energy. There are no multipliers, so there is no
inf-sup condition: surfaces overlap by p / k. Theory: docs/theory/midplane.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Floats, Ints, Potential, PotentialView, Pressures
from contactlab_segments.midplane_kernels import press, rub, stiffen
from contactlab_segments.midplane_nodes import assembled, gathered, polygon

TAKEN, SHORTEST = 0.1, 1e-3  # of a segment: overlaps that corrections may bring; of a correction
DEEPEST = 2.0  # of the longest segment: deeper overlaps are the far side of a thin body


@dataclass(frozen=True)
class Midplane(Potential):
    """Both sides press where they overlap, on the line between them; neither is the slave.

    stiffness  [-] pressure per overlap, over the stiffness of the cells behind: surfaces overlap by p h / (stiffness M)
               for each side, with the depth h of its cells and their dilatational modulus M
    slip       [-] slip of a step, over the shortest undeformed segment, up to which friction grows to its bound
    """

    stiffness: float = 30.0
    slip: float = 5e-4

    passes_patch_test: ClassVar[bool] = True
    rubs: ClassVar[bool] = True

    def __post_init__(self) -> None:
        for name in ("stiffness", "slip"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise ValueError(f"{name}: got {getattr(self, name)}, allowed: above 0, finite")

    def energy(self, view: PotentialView, positions: Floats) -> float:
        """Energy of the overlaps."""
        return self._pressed(view, positions)[0]

    def gradient(self, view: PotentialView, positions: Floats) -> Floats:
        """Derivative of the energy."""
        return np.asarray(polygon(view).T @ self._pressed(view, positions)[2])

    def hessian(self, view: PotentialView, positions: Floats) -> Any:
        """Its exact derivative, by dual numbers."""
        count = self._pressed(view, positions)[1]
        nodes, block = np.zeros((count, 4), np.int32), np.zeros((count, 8, 8))
        stiffen(*self._arguments(view, positions), nodes, block)
        return assembled(view, nodes, block)

    def largest_step(self, view: PotentialView, positions: Floats, displacement: Floats) -> float:
        """The fraction after which overlaps are within `TAKEN` or twice those before: beyond, too much would press."""
        share, most = 1.0, max(TAKEN, 2.0 * self._deepest(view, positions))
        while share > SHORTEST and self._deepest(view, positions + share * displacement) > most:
            share *= 0.5
        return share

    def _deepest(self, view: PotentialView, positions: Floats) -> float:
        """Largest mean overlap around a vertex, over its undeformed length; large where it has no number."""
        push = np.hypot(*self._pressed(view, positions)[2].T)
        return float(np.nan_to_num((push / view.length**2).max() / self._arguments(view, positions)[5], nan=np.inf))

    def friction_gradient(self, view: PotentialView, positions: Floats) -> Floats:
        """Coulomb friction of pairs of points that are matched at the lagged positions, smoothed."""
        return np.asarray(polygon(view).T @ self._rubbing(view, positions))

    def friction_hessian(self, view: PotentialView, positions: Floats) -> Any:
        """Its derivative by the slip."""
        nodes, weight, slip, bound, within = self._rubbed(view, positions)
        rise = 2.0 * bound * np.maximum(0.0, 1.0 - np.abs(slip)) / within
        return assembled(view, nodes, np.einsum("r,ri,rj->rij", rise, weight, weight))

    def pressures(self, view: PotentialView, positions: Floats, normal: Floats, length: Floats) -> Pressures:
        """Forces of the vertices of the slave's polygon over their lengths: their sums are the contact forces."""
        m, rubbed = len(normal), np.zeros_like(positions)
        if view.friction is not None:
            rubbed = self._rubbing(view, positions)
        along = np.stack([-normal[:, 1], normal[:, 0]], axis=1)
        forces = ((self._pressed(view, positions)[2][:m] * normal).sum(axis=1), -(rubbed[:m] * along).sum(axis=1))
        return Pressures(*(gathered(view, np.stack(forces)) / length))

    def _pressed(self, view: PotentialView, positions: Floats) -> tuple[float, int, Floats]:
        """Energy, number of pairs of segments that overlap, and derivative (n, 2) by the vertices of the polygons."""
        out = np.zeros_like(positions)
        energy, count = press(*self._arguments(view, positions), out)
        return energy, count, out

    def _rubbing(self, view: PotentialView, positions: Floats) -> Floats:
        """Minus the friction forces (n, 2) on the vertices of the polygons."""
        nodes, weight, slip, bound, _ = self._rubbed(view, positions)
        out = np.zeros_like(positions)
        size = np.where(np.abs(slip) < 1.0, slip * (2.0 - np.abs(slip)), np.sign(slip)) * bound
        np.add.at(out, nodes, (size[:, None] * weight).reshape(-1, 4, 2))
        return out

    def _rubbed(self, view: PotentialView, positions: Floats) -> tuple[Ints, Floats, Floats, Floats, float]:
        """Points that rub: nodes (r, 4), weights (r, 8), slip (r,) over the last number [mm], bounds (r,) [N]."""
        room = 4 * self._pressed(view, view.lagged)[1]
        nodes, weight, force = np.zeros((room, 4), np.int32), np.zeros((room, 8)), np.zeros(room)
        arguments = self._arguments(view, view.lagged)
        rub(*arguments, nodes, weight, force)
        assert view.friction is not None  # the core asks for friction where there is some
        moved, within = polygon(view) @ (positions - view.start), self.slip * float(arguments[3].min())
        slip = (weight * moved[nodes].reshape(-1, 8)).sum(axis=1) / within
        return nodes, weight, slip, view.friction.coefficient * force, within

    def _arguments(self, view: PotentialView, positions: Floats) -> tuple[Any, ...]:
        """What all kernels take."""
        vertices, m = polygon(view), len(view.slave.nodes)
        length = np.hypot(*np.diff((vertices @ view.reference)[view.edges], axis=1)[:, 0].T)
        of = np.concatenate([view.slave.nodes, view.master.nodes])
        ends = np.bincount(of[view.edges].ravel(), minlength=of.max() + 1)[of] == 1
        k = self.stiffness / sum(1.0 / float(side.max()) for side in (view.stiffness[:m], view.stiffness[m:]))
        slaves, deepest = len(view.slave.segments), DEEPEST * float(length.max())
        return vertices @ positions, view.edges, slaves, length, ends, k, deepest
