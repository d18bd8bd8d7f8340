"""Integrals of values that vary along edges, exact for any variation between the nodes.

Edges are split at jumps of a profile's values or slopes, and halved while a rule of ten points and the same
rule on both halves differ. Its points gather at the ends of a piece: it resolves a square root there like a parabola.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.api import Element, Floats, Ints, Profile, RunWarning
from contactlab.errors import Where
from contactlab.model.loading.load_profile import Varying, with_mean
from contactlab.parts.registry import Registry

POINTS = 3  # of an edge under a uniform load: exact for the quadratic trace times the derivative of a parabola
PARTS = 3  # Gauss points of a part of an edge, whose length is exact if it is straight
T, W = np.polynomial.legendre.leggauss(10)
NODES, WEIGHTS = 0.5 * T * (3.0 - T * T), 1.5 * (1.0 - T * T) * W  # exact to degree 9
LOOKED_AT = 512  # pieces of all edges for values without declared breaks: narrower features may be missed
DIFFER = 1e-10  # of the whole integral: pieces are halved until two rules differ by less
HALVINGS, MOST = 40, 200_000  # of a piece, pieces: undeclared jumps are then found to round-off
SIDES = 16  # parts of an edge in which its variable is assumed monotonic
BISECTIONS = 60
CHECKED = 200_003  # check points on all edges
WRONG = 0.01  # of the integral


class Points(NamedTuple):
    """Places `at` (n,) in [-1, 1] of edges number `edge` (n,), and their weights (n,)."""

    edge: Ints
    at: Floats
    weight: Floats


class Edges:
    """Edges (e, b) of one element at their undeformed positions.

    Numbers of edges and places on them broadcast: numbers (e, 1) and places (n,) are the same places of each edge.
    """

    def __init__(self, element: Element, edges: Ints, reference: Floats) -> None:
        self.element, self.edges, self.nodes = element, edges, reference[edges]

    def trace(self, points: Points) -> tuple[Floats, Floats]:
        """Return trace functions and their derivatives (n, b) at the points."""
        return self.element.edge_shape(points.at)

    def places(self, edge: Ints, at: Floats) -> Floats:
        """Return positions (..., 2) [mm] of places on edges."""
        return np.asarray(np.einsum("...a,...ai->...i", self.element.edge_shape(at)[0], self.nodes[edge]))

    def speed(self, edge: Ints, at: Floats) -> Floats:
        """Return the length (...) [mm] of an edge per unit of its parameter."""
        along = np.einsum("...a,...ai->...i", self.element.edge_shape(at)[1], self.nodes[edge])
        return np.asarray(np.hypot(along[..., 0], along[..., 1]))

    def arc_lengths(self, edge: Ints, at: Floats) -> Floats:
        """Return arc lengths (...) [mm], continued from edge to edge.

        They begin at the first edge of a chain, in the order of the edges if there are several chains; a closed
        curve begins at its first edge.
        """
        begins, inside = self._begins(), np.zeros(np.broadcast_shapes(edge.shape, at.shape))
        points, weights = np.polynomial.legendre.leggauss(PARTS)
        for point, weight in zip(points.tolist(), weights.tolist(), strict=True):
            inside += weight * self.speed(edge, 0.5 * (at + 1.0) * (point + 1.0) - 1.0)
        return np.asarray(begins[edge] + 0.5 * (at + 1.0) * inside)

    def _begins(self) -> Floats:
        """Return the arc length (e,) [mm] at which each edge begins."""
        points, weights = np.polynomial.legendre.leggauss(PARTS)
        every = np.repeat(np.arange(len(self.edges), dtype=np.int32), PARTS)
        lengths = self.speed(every, np.tile(points, len(self.edges))).reshape(-1, PARTS) @ weights
        values, _ = self.element.edge_shape(np.array([-1.0, 1.0]))
        first, last = (int(value.argmax()) for value in values)
        starts, following = np.empty(len(self.edges)), 0.0
        for edge in _order(self.edges[:, first], self.edges[:, last]):
            starts[edge] = following
            following += float(lengths[edge])
        return starts


def uniform(count: int) -> Points:
    """Return points of a load that does not vary."""
    points, weights = np.polynomial.legendre.leggauss(POINTS)
    return Points(np.repeat(np.arange(count, dtype=np.int32), POINTS), np.tile(points, count), np.tile(weights, count))


def varying(profile: Profile, edges: Edges, registry: Registry, where: Where, told: list[RunWarning]) -> Points:
    """Return points of a varying load, weighted by its factors; `told` gets a warning of a doubtful integral."""
    rule = _Rule(Varying(profile, registry, where), edges)
    points = rule.points()
    factors = rule.factors(points.edge, points.at)
    sizes = points.weight * edges.speed(points.edge, points.at)
    _check(rule, float(factors @ sizes), float(np.abs(factors) @ sizes), told, where)
    return points._replace(weight=points.weight * with_mean(profile, factors, sizes, where))


class _Rule:
    """A profile on edges, and its integration segments."""

    def __init__(self, profile: Varying, edges: Edges) -> None:
        self.profile, self.edges, self.count = profile, edges, len(edges.edges)

    def by(self, edge: Ints, at: Floats) -> Floats:
        """Return the variable of the profile (...)."""
        if self.profile.by == "s":
            return self.edges.arc_lengths(edge, at)
        return self.profile.at(self.edges.places(edge, at))

    def factors(self, edge: Ints, at: Floats) -> Floats:
        return self.profile.values(self.by(edge, at))

    def points(self) -> Points:
        """Return the rule of ten points on all pieces."""
        edge, low, high = self._halved(*self._split())
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        at, weight = middle[:, None] + half[:, None] * NODES, half[:, None] * WEIGHTS
        return Points(np.repeat(edge, len(NODES)), at.ravel(), weight.ravel())

    def _split(self) -> tuple[Ints, Floats, Floats]:
        """Return edges split at breaks of the profile, or into the pieces to test if it declares none."""
        pieces = 1 if len(self.profile.breaks) else max(1, -(-LOOKED_AT // self.count))
        ends = np.linspace(-1.0, 1.0, pieces + 1)
        edge = np.repeat(np.arange(self.count, dtype=np.int32), pieces + 1)
        at = np.tile(ends, self.count)
        if len(self.profile.breaks):
            more_edge, more_at = self._crossings()
            edge, at = np.concatenate([edge, more_edge]), np.concatenate([at, more_at])
        order = np.lexsort((at, edge))
        edge, at = edge[order], at[order]
        own = (edge[1:] == edge[:-1]) & (at[1:] - at[:-1] > 1e-12)
        return edge[:-1][own], at[:-1][own], at[1:][own]

    def _crossings(self) -> tuple[Ints, Floats]:
        """Return breaks on edges by bisection: in each part of an edge as many as lie between its ends."""
        breaks = np.sort(np.array(self.profile.breaks))
        ends = np.linspace(-1.0, 1.0, SIDES + 1)
        every = np.repeat(np.arange(self.count, dtype=np.int32), SIDES + 1)
        found = self.by(every, np.tile(ends, self.count)).reshape(self.count, SIDES + 1)
        begin, end = found[:, :-1].ravel(), found[:, 1:].ravel()
        low, high = np.minimum(begin, end), np.maximum(begin, end)
        if self.profile.by == "angle":  # halving handles parts across the half line of 180 degrees
            low = np.where(high - low > 180.0, high, low)
        first, last = np.searchsorted(breaks, low, side="right"), np.searchsorted(breaks, high, side="left")
        number = np.maximum(last - first, 0)
        part = np.repeat(np.arange(len(low)), number)
        wanted = breaks[np.arange(len(part)) - np.repeat(np.cumsum(number) - number, number) + first[part]]
        edge, a, b = (part // SIDES).astype(np.int32), ends[part % SIDES], ends[part % SIDES + 1]
        rises = end[part] > begin[part]
        for _ in range(BISECTIONS):
            middle = 0.5 * (a + b)
            beyond = (self.by(edge, middle) > wanted) == rises
            a, b = np.where(beyond, a, middle), np.where(beyond, middle, b)
        return edge, 0.5 * (a + b)

    def _halved(self, edge: Ints, low: Floats, high: Floats) -> tuple[Ints, Floats, Floats]:
        """Return pieces, halved until halves do not differ from the whole."""
        done: list[tuple[Ints, Floats, Floats]] = []
        whole = self._integrals(edge, low, high)
        total = float(np.abs(whole).sum())
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            halves = self._integrals(edge, low, middle), self._integrals(edge, middle, high)
            rough = np.abs(whole - halves[0] - halves[1]) > DIFFER * max(total, 1e-300)
            rough &= 2 * np.count_nonzero(rough) + sum(len(one[0]) for one in done) < MOST
            done.append((edge[~rough], low[~rough], high[~rough]))
            if not rough.any():
                return _joined(done)
            edge, whole = np.tile(edge[rough], 2), np.concatenate([half[rough] for half in halves])
            low, high = np.concatenate([low[rough], middle[rough]]), np.concatenate([middle[rough], high[rough]])
        return _joined([*done, (edge, low, high)])

    def _integrals(self, edge: Ints, low: Floats, high: Floats) -> Floats:
        """Return the integral (p,) of the profile over each piece."""
        half = 0.5 * (high - low)
        at = (0.5 * (low + high))[:, None] + half[:, None] * NODES
        every = np.repeat(edge, len(NODES))
        values = self.factors(every, at.ravel()) * self.edges.speed(every, at.ravel())
        return np.asarray(half * (values.reshape(at.shape) @ WEIGHTS))


def _joined(parts: list[tuple[Ints, Floats, Floats]]) -> tuple[Ints, Floats, Floats]:
    edge, low, high = (np.concatenate([part[k] for part in parts]) for k in range(3))
    order = np.lexsort((low, edge))
    return edge[order], low[order], high[order]


def _check(rule: _Rule, found: float, size: float, told: list[RunWarning], where: Where) -> None:
    """Compare the integral with an independent rule: many places, evenly spread over each edge."""
    each = -(-CHECKED // rule.count)
    at = (2.0 * np.arange(each) + 1.0) / each - 1.0
    edge = np.arange(rule.count, dtype=np.int32)[:, None]
    expected = 2.0 / each * float(rule.factors(edge, at).ravel() @ rule.edges.speed(edge, at).ravel())
    off = abs(found - expected) / max(size, abs(expected), 1e-300)
    key = getattr(where, "key", where)
    if off > WRONG:
        told.append(RunWarning(
            "load-resultant", off, WRONG, str(key),
            f"{key}: the integral along the edges is {found:.4g} mm, and {expected:.4g} mm by another rule ({off:.1%} "
            f"apart, at most {WRONG:.0%}): the profile jumps or swings too fast; write it as a table, or declare the "
            "breaks of its function",
        ))  # fmt: skip
    elif not size and not expected:
        told.append(RunWarning(
            "load-resultant", 0.0, 0.0, str(key),
            f"{key}: the profile is 0 all along the edges, and the load pushes on nothing; move it there, or take the "
            "load out",
        ))  # fmt: skip


def _order(first: Ints, last: Ints) -> list[int]:
    """Return edges one after the other: open chains first, closed chains after them."""
    at = {int(node): number for number, node in enumerate(first)}
    reached = {int(node) for node in last}
    order: dict[int, None] = {}
    for begin in sorted(range(len(first)), key=lambda edge: int(first[edge]) in reached):
        edge: int | None = begin
        while edge is not None and edge not in order:
            order[edge] = None
            edge = at.get(int(last[edge]))
    return list(order)
