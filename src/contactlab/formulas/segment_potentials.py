"""Contact by energies of segments: the array methods of `SegmentPotential`, from its formulas."""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import coo_array, csr_array, eye_array, kron

from contactlab.api import Floats, Ints, PotentialView, SegmentPotential
from contactlab.api.compiled.formulas import Slot
from contactlab.formulas import segment_potential_kernels as kernels
from contactlab.formulas.parameters import values_of
from contactlab.formulas.segments import DEPTH, ClassKernels, gauss_rule

TAKEN, SHORTEST = 0.1, 1e-3  # of a segment: overlaps that corrections may bring; of a correction
EDGE = 0.1  # of its neighbour's force: what a node beyond the edge of contact may bear for itself


class _Kernels(ClassKernels):
    """The kernels of one class."""

    @property
    def formula_slots(self) -> dict[Slot, Any]:
        places, weights = gauss_rule(self.kind.points)
        return {
            kernels.NORMAL: self.called("normal", "own, other, p", {}),
            kernels.OVERLAP: self.called("overlap", "own, other, p", {}),
            kernels.ENERGY: self.called("energy", "gap, stiffness, p", {}),
            kernels.POINTS: places, kernels.WEIGHTS: weights,
        }  # fmt: skip


_of_class = cache(_Kernels)


class Parts(NamedTuple):
    """Pairs of segments that press, and what kernels need of them.

    at         (n, 2) [mm] vertices of the polygons
    pairs      (c, 6) numbers of both segments, and the nodes of the four ends
    length     (e,) [mm] undeformed, and `ends` (n,) whether a side begins or ends at a node
    stiffness  [MPa/mm] of the cells behind, both sides in series
    begins     [mm] gap beyond which there is no energy
    deepest    [mm] deeper overlaps are the far side of a thin body
    numbers    (k, 1) parameters of the formulas
    """

    at: Floats
    pairs: Ints
    length: Floats
    ends: Any
    stiffness: float
    begins: float
    deepest: float
    numbers: Floats


def parts(part: SegmentPotential, view: PotentialView, positions: Floats) -> Parts:
    """Find the pairs of segments that press."""
    vertices, of = polygon(view), np.concatenate([view.slave.nodes, view.master.nodes])
    length = np.hypot(*np.diff((vertices @ view.reference)[view.edges], axis=1)[:, 0].T)
    ends = np.bincount(of[view.edges].ravel(), minlength=of.max() + 1)[of] == 1
    m = len(view.slave.nodes)
    stiffness = 1.0 / sum(1.0 / float(side.max()) for side in (view.stiffness[:m], view.stiffness[m:]))
    begins, deepest, numbers = float(part.begins(view)), DEPTH * float(length.max()), values_of(part)
    at, pairs, count = vertices @ positions, np.zeros((0, 6), np.int32), len(view.edges)
    find = _of_class(type(part)).made(kernels.meeting)
    while count > len(pairs):
        pairs = np.zeros((count, 6), np.int32)
        count = find(at, view.edges, len(view.slave.segments), length, ends, begins, deepest, numbers, pairs)
    return Parts(at, pairs[:count], length, ends, stiffness, begins, deepest, numbers)


def energy(part: SegmentPotential, view: PotentialView, positions: Floats) -> float:
    """Implement `Potential.energy`."""
    return _pressed(part, view, positions)[0]


def gradient(part: SegmentPotential, view: PotentialView, positions: Floats) -> Floats:
    """Implement `Potential.gradient`."""
    return np.asarray(polygon(view).T @ _pressed(part, view, positions)[1])


def _pressed(part: SegmentPotential, view: PotentialView, positions: Floats) -> tuple[float, Floats]:
    """Return the energy, and its derivative by the vertices of the polygons (n, 2)."""
    found = np.zeros_like(positions)
    energy = _of_class(type(part)).made(kernels.press)(*parts(part, view, positions), found)
    return float(energy), found


def hessian(part: SegmentPotential, view: PotentialView, positions: Floats) -> Any:
    """Implement `Potential.hessian`; plain Python has no dual numbers that change."""
    made_of = _of_class(type(part))
    if made_of.in_python:
        return None
    found = parts(part, view, positions)
    block = np.zeros((len(found.pairs), 8, 8))
    made_of.made(kernels.stiffen)(*found, block)
    return assembled(view, found.pairs[:, 2:], block)


def largest_step(part: SegmentPotential, view: PotentialView, positions: Floats, displacement: Floats) -> float:
    """Implement `Potential.largest_step`: overlaps stay within `TAKEN` or twice the overlaps before."""
    share, most = 1.0, max(TAKEN, 2.0 * _deepest(part, view, positions))
    while share > SHORTEST and not _deepest(part, view, positions + share * displacement) <= most:
        share *= 0.5
    return share


class Points(NamedTuple):
    """Gauss points of the parts that press, see `segment_potential_kernels.points`."""

    nodes: Ints
    share: Floats
    across: Floats
    gap: Floats
    measure: Floats
    pressure: Floats
    shortest: float


def _points(part: SegmentPotential, view: PotentialView, positions: Floats) -> Points:
    found = parts(part, view, positions)
    room = 2 * part.points * len(found.pairs)
    nodes, rows = np.zeros((room, 4), np.int32), tuple(np.zeros((room, width)) for width in (4, 2, 3))
    count = _of_class(type(part)).made(kernels.points)(*found, nodes, *rows)
    share, across, size = (row[:count] for row in rows)
    gap, measure, pressure = size.T
    return Points(nodes[:count], share, across, gap, measure, pressure, float(found.length.min()))


def _deepest(part: SegmentPotential, view: PotentialView, positions: Floats) -> float:
    """Return the largest mean overlap around a vertex, over its undeformed length."""
    found, overlap = _points(part, view, positions), np.zeros(len(positions))
    depth = found.measure * np.maximum(0.0, -found.gap)
    np.add.at(overlap, found.nodes, np.abs(found.share) * depth[:, None])
    return float((overlap / view.length**2).max())


# --- friction ---------------------------------------------------------------------------------------------------------


class _Rubbing(NamedTuple):
    """Points that rub: nodes (r, 4), weights (r, 8) of slips, slips (r,) over `within` [mm], bounds (r,) [N]."""

    nodes: Ints
    weight: Floats
    slip: Floats
    bound: Floats
    within: float


def _rubbing(part: SegmentPotential, view: PotentialView, positions: Floats) -> _Rubbing:
    assert view.friction is not None  # the core calls this only with friction
    found = _points(part, view, view.lagged)
    weight = (found.share[:, :, None] * found.across[:, None, :]).reshape(-1, 8)
    moved, within = polygon(view) @ (positions - view.start), view.pace * part.slip * found.shortest
    slip = (weight * moved[found.nodes].reshape(-1, 8)).sum(axis=1) / within
    return _Rubbing(found.nodes, weight, slip, view.friction.coefficient * found.pressure * found.measure, within)


def _rubbed(part: SegmentPotential, view: PotentialView, positions: Floats) -> Floats:
    """Return minus the friction forces (n, 2) on the vertices of the polygons."""
    found, out = _rubbing(part, view, positions), np.zeros_like(positions)
    slip = found.slip
    size = np.where(np.abs(slip) < 1.0, slip * (2.0 - np.abs(slip)), np.sign(slip)) * found.bound
    np.add.at(out, found.nodes, (size[:, None] * found.weight).reshape(-1, 4, 2))
    return out


def friction_gradient(part: SegmentPotential, view: PotentialView, positions: Floats) -> Floats:
    """Implement `Potential.friction_gradient`."""
    return np.asarray(polygon(view).T @ _rubbed(part, view, positions))


def friction_hessian(part: SegmentPotential, view: PotentialView, positions: Floats) -> Any:
    """Implement `Potential.friction_hessian`."""
    found = _rubbing(part, view, positions)
    rise = 2.0 * found.bound * np.maximum(0.0, 1.0 - np.abs(found.slip)) / found.within
    return assembled(view, found.nodes, np.einsum("r,ri,rj->rij", rise, found.weight, found.weight))


# --- nodes and vertices -----------------------------------------------------------------------------------------------


def polygon(view: PotentialView) -> Any:
    """Vertices (n, n) by nodes: quadratic edges count as two segments that enclose the same area, by Simpson's rule.

    Equal areas make a uniform pressure on the segments the consistent forces 1/6, 4/6, 1/6 on the nodes of the edge.
    """
    n = len(view.reference)
    found = eye_array(n, format="csr")
    for edges in (view.slave.edges, view.master.edges + len(view.slave.nodes)):
        if edges.shape[1] == 3:
            place = np.repeat(edges[:, 2], 3), edges.ravel()
            found = found + csr_array((np.tile([-1 / 6, -1 / 6, 1 / 3], len(edges)), place), shape=(n, n))
    return found


def assembled(view: PotentialView, nodes: Ints, block: Floats) -> Any:
    """Matrix (2n, 2n) of the nodes from blocks (c, 8, 8) of four vertices (c, 4) each."""
    size = 2 * len(view.reference)
    dof = (2 * nodes[:, :, None] + np.arange(2)).reshape(-1, 8)
    place = np.repeat(dof, 8, axis=1).ravel(), np.tile(dof, 8).ravel()
    found = coo_array((block.ravel(), place), shape=(size, size)).tocsr()
    if max(side.edges.shape[1] for side in (view.slave, view.master)) == 2:
        return found  # vertices are nodes
    by_node = kron(polygon(view), eye_array(2), "csr")
    return by_node.T @ found @ by_node


def nodal_forces(part: SegmentPotential, view: PotentialView, positions: Floats) -> Floats:
    """Return forces (2, m, 2) on the slave's vertices, of pressure and of friction.

    Small ones beyond the edge of contact are their neighbour's: their hats reach into the last segment that presses.
    Mortars, too, merge multipliers with little cover.
    """
    m, pressed = len(view.slave.nodes), _pressed(part, view, positions)[1]
    rubbed = np.zeros_like(pressed) if view.friction is None else _rubbed(part, view, positions)
    forces = -np.stack([pressed[:m], rubbed[:m]])
    segments, found = view.slave.segments, forces.copy()
    here, there = np.concatenate([segments, segments[:, ::-1]]).T
    load = np.hypot(*forces[0].T)
    bare = np.zeros(len(load), np.bool_)
    bare[here[load[there] <= 0.0]] = True
    small = bare[here] & (load[here] > 0.0) & (load[here] < EDGE * load[there])
    for all_of, given in zip(found, forces, strict=True):
        np.add.at(all_of, there[small], given[here[small]])
    found[:, here[small]] = 0.0
    return found
