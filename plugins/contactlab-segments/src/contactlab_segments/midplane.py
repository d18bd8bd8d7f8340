"""Contact without slave and master, on the common line of two chains of segments, by a penalty.

Two segments that face each other have a mean line, the bisector of their directions. Points of both are matched across
it, and the overlap of matched points, -g, has the energy

    E = 1/2 (integral over one side + integral over the other)  of  k/2 <-g>^2 ds,    p = k <-g>,

with undeformed lengths ds. The sides enter alike: forces do not change when slave and master are
exchanged. Integrals are split where segments end. So they are exact, and a uniform overlap is a uniform pressure on
both sides, whatever the meshes. Forces are the derivatives of the energy. There are no multipliers, so there is no
inf-sup condition: surfaces overlap by p / k. Theory: docs/theory/midplane.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Floats, Ints, NodalForces, Potential, PotentialView
from contactlab_segments.midplane_kernels import press, rub, stiffen
from contactlab_segments.midplane_nodes import Overlaps, assembled, gathered, overlaps, polygon

TAKEN, SHORTEST = 0.1, 1e-3  # of a segment: overlaps that corrections may bring; of a correction


@dataclass(frozen=True)
class Midplane(Potential):
    """Both sides press where they overlap, on the line between them; neither is the slave.

    stiffness  [-] pressure per overlap, over the stiffness of the cells behind: surfaces overlap by p h / (stiffness M)
               for each side, with the depth h of its cells and their dilatational modulus M
    slip       [-] slip over the shortest undeformed segment up to which friction grows to its bound, in a step of a
               tenth of the loading or time
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
        energy: float = press(*self._overlaps(view, positions), np.zeros_like(positions))
        return energy

    def gradient(self, view: PotentialView, positions: Floats) -> Floats:
        """Derivative of the energy."""
        return np.asarray(polygon(view).T @ self._overlaps(view, positions).derivative())

    def hessian(self, view: PotentialView, positions: Floats) -> Any:
        """Exact Hessian of the energy, by dual numbers."""
        found = self._overlaps(view, positions)
        block = np.zeros((len(found.pairs), 8, 8))
        stiffen(*found, block)
        return assembled(view, found.pairs[:, 2:], block)

    def largest_step(self, view: PotentialView, positions: Floats, displacement: Floats) -> float:
        """Fraction after which overlaps are within `TAKEN` or twice the overlaps before: more would press too much."""
        share, most = 1.0, max(TAKEN, 2.0 * self._deepest(view, positions))
        while share > SHORTEST and self._deepest(view, positions + share * displacement) > most:
            share *= 0.5
        return share

    def _deepest(self, view: PotentialView, positions: Floats) -> float:
        """Largest mean overlap around a vertex, over its undeformed length; large if it is not a number."""
        found = self._overlaps(view, positions)
        push = np.hypot(*found.derivative().T)
        return float(np.nan_to_num((push / view.length**2).max() / found.stiffness, nan=np.inf))

    def friction_gradient(self, view: PotentialView, positions: Floats) -> Floats:
        """Coulomb friction of pairs of points that are matched at the lagged positions, smoothed."""
        return np.asarray(polygon(view).T @ self._rubbing(view, positions))

    def friction_hessian(self, view: PotentialView, positions: Floats) -> Any:
        """Derivative of friction by the slip."""
        nodes, weight, slip, bound, within = self._rubbed(view, positions)
        rise = 2.0 * bound * np.maximum(0.0, 1.0 - np.abs(slip)) / within
        return assembled(view, nodes, np.einsum("r,ri,rj->rij", rise, weight, weight))

    def nodal_forces(self, view: PotentialView, positions: Floats) -> NodalForces:
        """Forces on the vertices of the slave's polygon."""
        pressed, m = self._overlaps(view, positions).derivative(), len(view.slave.nodes)
        rubbed = np.zeros_like(pressed) if view.friction is None else self._rubbing(view, positions)
        return NodalForces(*gathered(view, -np.stack([pressed[:m], rubbed[:m]])))

    def _overlaps(self, view: PotentialView, positions: Floats) -> Overlaps:
        m = len(view.slave.nodes)
        k = self.stiffness / sum(1.0 / float(side.max()) for side in (view.stiffness[:m], view.stiffness[m:]))
        return overlaps(view, positions, k)

    def _rubbing(self, view: PotentialView, positions: Floats) -> Floats:
        """Minus the friction forces (n, 2) on the vertices of the polygons."""
        nodes, weight, slip, bound, _ = self._rubbed(view, positions)
        out = np.zeros_like(positions)
        size = np.where(np.abs(slip) < 1.0, slip * (2.0 - np.abs(slip)), np.sign(slip)) * bound
        np.add.at(out, nodes, (size[:, None] * weight).reshape(-1, 4, 2))
        return out

    def _rubbed(self, view: PotentialView, positions: Floats) -> tuple[Ints, Floats, Floats, Floats, float]:
        """Points that rub: nodes (r, 4), weights (r, 8), slip (r,) over the last number [mm], bounds (r,) [N]."""
        assert view.friction is not None  # the core calls this only with friction
        found = self._overlaps(view, view.lagged)
        room = 4 * len(found.pairs)
        nodes, weight, force = np.zeros((room, 4), np.int32), np.zeros((room, 8)), np.zeros(room)
        rub(*found, nodes, weight, force)
        moved, within = polygon(view) @ (positions - view.start), view.pace * self.slip * float(found.length.min())
        slip = (weight * moved[nodes].reshape(-1, 8)).sum(axis=1) / within
        return nodes, weight, slip, view.friction.coefficient * force, within
