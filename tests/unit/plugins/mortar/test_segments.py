"""Pieces against a quadrature that searches for what sees what by bisection, over all pairs of segments."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from contactlab_mortar.mortar import MortarP0, MortarP1
from dense_pieces import SURFACES, pieces_of, summed, view_of
from scipy.optimize import brentq

from contactlab.api import ContactView, Floats, Surface
from contactlab.testing.surfaces import chains

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(12)
CLOSE = 1e-11  # bisection stops at 1e-14 of xi; D, M and T are of order one


def cross(u: Floats, v: Floats) -> float:
    return float(u[0] * v[1] - u[1] * v[0])


def outward(surface: Surface, x: Floats) -> Floats:
    """Averaged normals: the sum of the edges that meet, turned by -90 degrees."""
    total = np.zeros_like(x)
    for i, j in surface.segments:
        total[[i, j]] += x[j] - x[i]
    turned = np.stack([total[:, 1], -total[:, 0]], axis=1)
    return np.asarray(turned / np.hypot(*turned.T)[:, None])


class Quadrature:
    """D, M and T of a view by brute force."""

    def __init__(self, view: ContactView, linear: bool, vertices: bool) -> None:
        self.view, self.linear, self.vertices = view, linear, vertices and view.slave.edges.shape[1] == 3
        self.x, self.y = view.at
        self.normal = outward(view.slave, self.x)
        m, r = len(self.x), len(self.y)
        self.D, self.M, self.T = np.zeros((m, m)), np.zeros((r, m)), np.zeros((m, m))
        for s in range(len(view.slave.segments)):
            for t in range(len(view.master.segments)):
                self.add(s, t)

    def seen(self, s: int, xi: float) -> tuple[Floats, Floats]:
        i, j = self.view.slave.segments[s]
        return (1 - xi) * self.x[i] + xi * self.x[j], (1 - xi) * self.normal[i] + xi * self.normal[j]

    def parameter(self, s: int, point: Floats) -> float:
        """xi from where a point is seen; 0 or 1 where that is before or behind the slave segment."""

        def off(xi: float) -> float:
            x, n = self.seen(s, xi)
            return cross(x - point, n)

        if off(0.0) * off(1.0) > 0.0:
            return 0.0 if off(0.0) < 0.0 else 1.0
        return float(brentq(off, 0.0, 1.0, xtol=1e-14))

    def add(self, s: int, t: int) -> None:
        """What one pair of segments adds."""
        slave, master = self.view.slave, self.view.master
        (i, j), (c, d) = slave.segments[s], self.y[master.segments[t]]
        if (self.x[j] - self.x[i]) @ (d - c) >= 0.0:
            return
        low, high = sorted((self.parameter(s, c), self.parameter(s, d)))
        if high <= low:
            return
        ends = []
        for xi in (low, high):
            x, n = self.seen(s, xi)
            ends.append(cross(x - c, n) / cross(d - c, n))
        length = float(np.hypot(*(self.x[j] - self.x[i])))
        for begin, end in pairwise([low, *([0.5] if low < 0.5 < high else []), high]):
            for point, weight in zip(0.5 * (1.0 + POINTS), 0.5 * WEIGHTS, strict=True):
                xi = begin + point * (end - begin)
                eta = ends[0] + (xi - low) / (high - low) * (ends[1] - ends[0])
                nodes, hats, psi = self.multipliers(s, xi)
                own, at = self.trace(slave, s, xi)
                other, below = self.trace(master, t, eta)
                psi = psi * weight * (end - begin) * length
                self.D[np.ix_(own, nodes)] += np.outer(at, psi)
                self.M[np.ix_(other, nodes)] += np.outer(below, psi)
                self.T[np.ix_(nodes, nodes)] += np.outer(hats, psi)

    def multipliers(self, s: int, xi: float) -> tuple[Any, Floats, Floats]:
        """Nodes of the multipliers at xi, their hats and their basis functions there."""
        slave = self.view.slave
        nodes, share = slave.segments[s], xi
        if self.vertices:
            edge, half = slave.segment_edge[s]
            nodes, share = slave.edges[edge, :2], 0.5 * (xi + half)
        hats = np.array([1.0 - share, share])
        return nodes, hats, hats if self.linear else np.round(hats)

    def trace(self, surface: Surface, s: int, xi: float) -> tuple[Any, Floats]:
        """Nodes of an edge and their shape functions at xi of one of its segments."""
        edge, half = surface.segment_edge[s]
        nodes = surface.edges[edge]
        if len(nodes) == 2:
            return nodes, np.array([1.0 - xi, xi])
        share = 0.5 * (xi + half)
        return nodes, np.array([(1 - share) * (1 - 2 * share), share * (2 * share - 1), 4 * share * (1 - share)])


@pytest.mark.parametrize("vertices", [False, True], ids=["nodes", "vertices"])
@pytest.mark.parametrize("linear", [False, True], ids=["P0", "P1"])
@pytest.mark.parametrize("name", sorted({*SURFACES} - {"steep"}))  # whose flank counts in part
def test_mortar_pieces_sum_to_the_integrals_over_all_pairs_of_segments(name: str, linear: bool, vertices: bool) -> None:
    view = view_of(SURFACES[name])
    pieces, count = pieces_of((MortarP1 if linear else MortarP0)("vertices" if vertices else "nodes"), view)
    expected = Quadrature(view, linear, vertices)
    for got, wanted in zip(summed(pieces, count, view), (expected.D, expected.M, expected.T), strict=True):
        assert np.abs(wanted).max() > 0.01
        np.testing.assert_allclose(got, wanted, atol=CLOSE)


def test_mortar_pieces_leave_out_slave_segments_that_are_far_or_behind() -> None:
    """Of three segments one is within reach, one too far, and one deeper than two segments behind the master."""
    slave = np.array([[0.0, 0.1], [1.0, 0.1], [2.0, 9.0], [3.0, 9.0], [4.0, -9.0], [5.0, -9.0]])
    view = view_of(chains(slave, np.array([[-1.0, 0.0], [6.0, 0.0]])))._replace(reach=0.5)
    pieces, count = pieces_of(MortarP1(), view)
    segments = {tuple(nodes) for nodes in pieces.multiplier[:count]}
    assert (0, 1) in segments
    assert not {(2, 3), (4, 5)} & segments


@pytest.mark.parametrize("algorithm", [MortarP0(), MortarP1()], ids=["P0", "P1"])
def test_a_flank_that_turns_joins_without_a_jump(algorithm: MortarP0) -> None:
    """Covered lengths while a segment of the master turns from 65 to 90 degrees in steps of a tenth of one."""
    slave, lengths = np.array([[-0.5, 0.1], [0.0, 0.1], [0.5, 0.1]]), []
    for angle in np.radians(np.arange(65.0, 90.0, 0.1)):
        end = np.array([0.1 + 0.6 * np.cos(angle), -0.6 * np.sin(angle)])
        view = view_of(chains(slave, np.array([[-0.8, 0.0], [0.1, 0.0], end])))
        pieces, count = pieces_of(algorithm, view)
        lengths.append(pieces.T[:count].sum())
    # a jump would be a fifth of the flank's length, 0.12: what turns by a tenth of a degree moves by a thousandth of it
    assert np.abs(np.diff(lengths)).max() < 0.01
    assert lengths[-1] == pytest.approx(0.6, abs=1e-12)
    assert lengths[0] > 0.8
