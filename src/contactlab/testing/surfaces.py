"""Pairs of surfaces for checks of contact algorithms, and their gap conditions."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contactlab.api import (
    ContactMethod,
    Floats,
    FrictionBound,
    FrictionLaw,
    GapConditions,
    Rows,
    Surface,
)
from contactlab.contact.pair import ContactPair
from contactlab.errors import WrongAnswer
from contactlab.meshing.mesh import surface_from_edges
from contactlab.model.contact.systems import contact_pair

LOW, HIGH = 0.5, 2.5  # of the shorter surface; the other one spans 0 ... 3


@dataclass(frozen=True)
class Chains:
    """A slave above a master: all nodes (N, 2), the slave's first."""

    nodes: Floats
    slave: Surface
    master: Surface

    def moved(self, nodes: Floats) -> Chains:
        """The same surfaces at other positions."""
        return replace(self, nodes=np.ascontiguousarray(nodes))

    def lifted(self, by: tuple[float, float]) -> Chains:
        """The slave shifted by a vector [mm]."""
        nodes = self.nodes.copy()
        nodes[self.slave.nodes] += by
        return self.moved(nodes)

    def turned(self, angle: float, shift: tuple[float, float] = (0.0, 0.0)) -> Chains:
        """Both surfaces turned about the origin [rad], then shifted."""
        return self.moved(self.nodes @ rotation(angle).T + shift)

    @property
    def spacing(self) -> float:
        """Longest segment of both [mm]."""
        return max(float(side.lengths(self.nodes[side.nodes]).max()) for side in (self.slave, self.master))


def rotation(angle: float) -> Floats:
    """Matrix that turns by `angle` [rad]."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def chains(slave: Floats, master: Floats, order: int = 1) -> Chains:
    """Surfaces through the points slave (m, 2), left to right, and master (l, 2), left to right below it.

    `order` 2 makes every third point the middle of a quadratic edge.
    """
    nodes = np.ascontiguousarray(np.concatenate([slave, master]))
    below = np.arange(len(nodes) - 1, len(slave) - 1, -1)  # the body below lies on the left of right-to-left
    return Chains(nodes, _surface(np.arange(len(slave)), order), _surface(below, order))


def _surface(path: NDArray[np.int_], order: int) -> Surface:
    starts = range(0, len(path) - 1, order)
    edges = [[path[i], path[i + order], *path[i + 1 : i + order]] for i in starts]
    return surface_from_edges(np.array(edges, np.int32))


def stations(low: float, high: float, count: int, order: int = 1, seed: int = 1) -> Floats:
    """Unevenly spaced abscissae: `count` edges from low to high, middles of quadratic edges in their middle."""
    share = np.cumsum(np.random.default_rng(seed).uniform(0.6, 1.4, count))
    ends = low + (high - low) * np.concatenate([[0.0], share / share[-1]])
    if order == 1:
        return ends
    return np.sort(np.concatenate([ends, 0.5 * (ends[1:] + ends[:-1])]))


def flat(full: bool = True, order: int = 1, edges: tuple[int, int] = (6, 5)) -> Chains:
    """Flush surfaces on y = 0 with meshes that do not match: the slave covered in full, or only partly."""
    spans = [(LOW, HIGH), (0.0, 3.0)] if full else [(0.0, 3.0), (LOW, HIGH)]
    x = [stations(*span, n, order, seed) for span, n, seed in zip(spans, edges, (1, 2), strict=True)]
    slave, master = (np.stack([s, np.zeros_like(s)], axis=1) for s in x)
    return chains(slave, master, order)


def curved() -> Chains:
    """A slave on an arc over a master on a flatter one, partly overlapping."""
    s, m = stations(-0.8, 0.8, 9, seed=3), stations(-1.0, 1.0, 7, seed=4)
    return chains(np.stack([s, 0.5 * s**2 - 0.02], axis=1), np.stack([m, 0.1 * m**2], axis=1))


class Rough(FrictionLaw):
    """Friction, so that tangential rows are made."""

    def bound(self) -> FrictionBound:
        """Coulomb's, with a coefficient of one."""
        return FrictionBound(1.0, 0.0, 0.0)


def pair_of(algorithm: ContactMethod, at: Chains, friction: bool = False) -> tuple[Any, Floats]:
    """The core's pair for the algorithm at its positions, and the algorithm's memory after that."""
    memory = np.zeros((algorithm.memory_size, len(at.slave.nodes)))
    free, law = np.zeros(len(at.slave.nodes), np.bool_), Rough() if friction else None
    pair = contact_pair("contact", algorithm, (at.slave, at.master), at.nodes, 0, law, free)
    try:
        pair.update(at.nodes, memory)
    except WrongAnswer as wrong:
        raise AssertionError(str(wrong)) from None
    return pair, memory


def rows_of_pair(pair: ContactPair, at: Chains, friction: bool = False) -> Rows:
    """All rows of a pair, however far open."""
    rows = Rows.allocate(pair.slots, len(at.nodes), friction)
    pair.append_rows(rows, 0, np.inf, np.zeros((2 if friction else 1, pair.slots)), at.nodes)
    return rows


def conditions(algorithm: ContactMethod, at: Chains, *, tangent: bool = False) -> GapConditions:
    """The finished gap conditions that the core makes of either kind of algorithm."""
    pair, memory = pair_of(algorithm, at, tangent)
    if tangent:
        pair.compute_start_normals(at.nodes, memory)
    rows = rows_of_pair(pair, at, tangent)
    k, z = rows.count, rows.start[rows.count]
    return GapConditions(
        rows.start[: k + 1],
        rows.node[:z],
        rows.normal_weight[:z],
        rows.tangent_weight[:z],
        rows.gap[:k],
        rows.measure[:k],
        rows.slot[:k],
    )


def dense(found: GapConditions, weight: Floats, nodes: int) -> Floats:
    """Weights of the conditions as an array (k, N, 2)."""
    out = np.zeros((len(found.gap), nodes, 2))
    row = np.repeat(np.arange(len(found.gap)), np.diff(found.start))
    np.add.at(out, (row, found.node), weight)
    return out


def consistent_loads(at: Chains, surface: Surface, low: float, high: float) -> Floats:
    """Integral (N,) of each node's trace over low < x < high of a surface along x: forces of a unit pressure."""
    points, weights = np.polynomial.legendre.leggauss(4)
    out = np.zeros(len(at.nodes))
    for edge in surface.edges:
        x = at.nodes[surface.nodes[edge], 0]
        begin, end = np.clip([min(x[:2]), max(x[:2])], low, high)
        if end > begin:
            places = 0.5 * (begin + end) + 0.5 * (end - begin) * points
            shape = _trace((places - x[0]) / (x[1] - x[0]), len(edge))
            np.add.at(out, surface.nodes[edge], 0.5 * (end - begin) * weights @ shape)
    return out


def _trace(t: Floats, nodes: int) -> Floats:
    """Linear or quadratic trace at t in [0, 1]: start, end, middle."""
    if nodes == 2:
        return np.stack([1.0 - t, t], axis=1)
    return np.stack([(1.0 - t) * (1.0 - 2.0 * t), t * (2.0 * t - 1.0), 4.0 * t * (1.0 - t)], axis=1)
