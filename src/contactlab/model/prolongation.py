"""Prolongation of a coarser model's state to a finer mesh: displacements and pressures, interpolated."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from contactlab.api import Estimate, Floats, Surface
from contactlab.meshing.locate import located
from contactlab.model.bodies.body import Body
from contactlab.model.implicit_model import ImplicitModel

if TYPE_CHECKING:
    from contactlab.contact.pair import ContactPair

NEAR = 4  # coarse segments that are compared for each fine one


def pressures(model: ImplicitModel) -> Floats:
    """Return multipliers (r, k) of the state over their lengths [MPa]."""
    if model.contact is None:
        return np.zeros((1, 0))
    force, measure = model.contact.conditions.force, model.contact.conditions.measure
    return np.divide(force, measure, out=np.zeros_like(force), where=measure > 0.0)


class Prolongation:
    """Map from one model to a finer model of the same scene. The search is done once."""

    def __init__(self, coarse: ImplicitModel, fine: ImplicitModel) -> None:
        self.shape = fine.reference.shape
        self.bodies = [_BodyMap(a, b) for a, b in zip(coarse.bodies, fine.bodies, strict=True)]
        pairs = zip(_pairs(coarse), _pairs(fine), strict=True)
        self.pairs = [_PairMap(a, b, coarse.reference, fine.reference) for a, b in pairs]
        self.multipliers = fine.contact.conditions.force.shape if fine.contact is not None else (1, 0)

    def estimate(self, time: float, displacement: Floats, pressure: Floats) -> Estimate:
        """Return the coarse displacement (N, 2) and pressure (r, k) at `time`, on the fine mesh."""
        moved, pressed = np.zeros(self.shape), np.zeros(self.multipliers)
        for body in self.bodies:
            body.carry(displacement, moved)
        for pair in self.pairs:
            pair.carry(pressure, pressed)
        return Estimate(time, moved, pressed)


def _pairs(model: ImplicitModel) -> tuple[ContactPair, ...]:
    return tuple(model.contact.passes) if model.contact is not None else ()


class _BodyMap:
    """Nodal values of one body, interpolated by the shape functions of the coarse cells."""

    def __init__(self, coarse: Body, fine: Body) -> None:
        cells, places = located(coarse.mesh, coarse.element, fine.mesh.nodes)
        self.nodes, self.weights = coarse.cells[cells], coarse.element.shape(places).value
        self.own = slice(fine.first, fine.first + fine.count)

    def carry(self, values: Floats, out: Floats) -> None:
        out[self.own] = np.einsum("na,nad->nd", self.weights, values[self.nodes])


class _PairMap:
    """Pressures of one pair, straight along the segments of the coarse slave surface."""

    def __init__(self, coarse: ContactPair, fine: ContactPair, before: Floats, after: Floats) -> None:
        self.coarse, self.fine = coarse, fine
        self.nodes, self.share = _along(coarse.slave, before, fine.slave, after)

    def carry(self, values: Floats, out: Floats) -> None:
        begin, end = self.nodes.T
        for slot in range(self.fine.rows_per_node):
            own = _filled(values[:, _slots(self.coarse, slot)], self.coarse)
            out[:, _slots(self.fine, slot)] = (1.0 - self.share) * own[:, begin] + self.share * own[:, end]


def _slots(pair: ContactPair, slot: int) -> slice:
    nodes = len(pair.slave.nodes)
    return slice(pair.first_slot + slot * nodes, pair.first_slot + (slot + 1) * nodes)


def _filled(values: Floats, pair: ContactPair) -> Floats:
    """Fill nodes without multiplier with the mean of adjacent nodes with one."""
    without, after, before = pair.between
    if not len(without):
        return values
    filled = values.copy()
    filled[:, without] = 0.5 * (values[:, after] + values[:, before])
    return filled


def _along(coarse: Surface, before: Floats, fine: Surface, after: Floats) -> tuple[Floats, Floats]:
    """Return for every node of the fine surface the ends (m, 2) of a coarse segment, and the share between them (m,).

    The segment is nearest to the middle of a fine segment at the node: each flank of a corner keeps its own.
    """
    from scipy.spatial import cKDTree

    a, b = (before[coarse.nodes[coarse.segments[:, k]]] for k in range(2))
    middles = after[fine.nodes[fine.segments]].mean(axis=1)
    near = cKDTree(0.5 * (a + b)).query(middles, k=[*range(1, min(NEAR, len(a)) + 1)])[1]
    distances = np.stack([_distance(middles, a[column], b[column]) for column in near.T])
    nearest = near[np.arange(len(middles)), distances.argmin(axis=0)]
    own = nearest[fine.node_segments.max(axis=1)]
    share = np.clip(_share(after[fine.nodes], a[own], b[own]), 0.0, 1.0)
    return coarse.segments[own], share


def _share(points: Floats, a: Floats, b: Floats) -> Floats:
    along = b - a
    share: Floats = np.einsum("nd,nd->n", points - a, along) / np.einsum("nd,nd->n", along, along)
    return share


def _distance(points: Floats, a: Floats, b: Floats) -> Floats:
    share = np.clip(_share(points, a, b), 0.0, 1.0)[:, None]
    return np.asarray(np.hypot(*(points - (1.0 - share) * a - share * b).T))
