"""D, M and T of one overlap against quadrature with many points, and traces against their derivatives."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from contactlab_mortar.integrals import (
    constant_basis,
    hat,
    hat_derivative,
    integrate,
    integrate_changes,
    integrate_straight,
    trace,
    trace_derivative,
)
from contactlab_mortar.overlap import Overlap

from contactlab.api.compiled.kernel import kernel

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(12)


@kernel
def integrated(interval, length, halves, linear, p, out):
    """`integrate` for callers from Python."""
    low, high, first, last = interval
    integrate(Overlap(low, high, first, last), length, halves, linear, p, out)


@kernel
def straight(interval, length, linear, p, out):
    """`integrate_straight` for callers from Python."""
    low, high, first, last = interval
    integrate_straight(Overlap(low, high, first, last), length, linear, p, out)


@kernel
def changed(interval, length, halves, linear, change, p, out):
    """`integrate_changes` for callers from Python."""
    low, high, first, last = interval
    integrate_changes(Overlap(low, high, first, last), length, halves, linear, change, p, out)


def by_points(interval, length, sizes, halves, linear):  # type: ignore[no-untyped-def]
    """The same integrals, cut where the constant basis jumps, with 12 points on each part."""
    low, high, first, last = interval
    D, M, T = np.zeros((sizes[0], 2)), np.zeros((sizes[1], 2)), np.zeros((2, 2))
    breaks = [low, *([0.5] if low < 0.5 < high else []), high]
    for begin, end in pairwise(breaks):
        for t, w in zip(0.5 * (1.0 + POINTS), 0.5 * WEIGHTS, strict=True):
            xi = begin + t * (end - begin)
            eta = first + (xi - low) / (high - low) * (last - first)
            for k in range(2):
                psi = hat(halves[2], xi, k) if linear else constant_basis(halves[2], xi, k)
                psi *= w * (end - begin) * length
                D[:, k] += [psi * trace(sizes[0], halves[0], xi, i) for i in range(sizes[0])]
                M[:, k] += [psi * trace(sizes[1], halves[1], eta, i) for i in range(sizes[1])]
                T[:, k] += [psi * hat(halves[2], xi, i) for i in range(2)]
    return D, M, T


@pytest.mark.parametrize("linear", [False, True], ids=["P0", "P1"])
@pytest.mark.parametrize("sizes", [(2, 2), (3, 2), (2, 3), (3, 3)])
@pytest.mark.parametrize("interval", [(0.1, 0.45, 0.9, 0.2), (0.5, 1.0, 0.7, 0.0), (0.2, 0.9, 0.8, 0.3)])
def test_gauss_points_are_as_many_as_exact_integrals_need(linear: bool, sizes: tuple, interval: tuple) -> None:
    for halves in ((0, 1, 0), (1, 0, 0), (0, 1, 1), (1, 1, 2)):
        if halves[2] and sizes[0] == 2:
            continue
        out = np.zeros((2, sizes[0], 2)), np.zeros((2, sizes[1], 2)), np.zeros((2, 2, 2))
        integrated(interval, 0.7, halves, linear, 1, out)
        for got, expected in zip(out, by_points(interval, 0.7, sizes, halves, linear), strict=True):
            np.testing.assert_allclose(got[1], expected, atol=1e-15)
            np.testing.assert_array_equal(got[0], 0.0)


@pytest.mark.parametrize("linear", [False, True], ids=["P0", "P1"])
@pytest.mark.parametrize("interval", [(0.0, 1.0, 1.0, 0.0), (0.2, 0.9, 0.8, 0.3), (0.6, 0.8, 0.1, 0.0)])
def test_the_closed_form_is_the_integral_of_straight_edges(linear: bool, interval: tuple) -> None:
    out = tuple(np.full((1, 2, 2), np.nan) for _ in range(3))
    straight(interval, 0.7, linear, 0, out)
    for got, expected in zip(out, by_points(interval, 0.7, (2, 2), (0, 0, 0), linear), strict=True):
        np.testing.assert_allclose(got[0], expected, atol=1e-15)


@pytest.mark.parametrize("linear", [False, True], ids=["P0", "P1"])
@pytest.mark.parametrize("sizes", [(2, 2), (3, 3)])
def test_changes_of_integrals_are_their_central_differences(linear: bool, sizes: tuple) -> None:
    """Over a step of 1e-6, whose square and whose round-off over it are below 1e-9."""
    interval, change, h = np.array([0.2, 0.9, 0.8, 0.3]), np.array([0.3, -0.4, 0.7, 0.2]), 1e-6
    for halves in ((0, 1, 0), (1, 1, 2)) if sizes[0] == 3 else ((0, 0, 0),):
        found, high, low = (tuple(np.zeros((2, rows, 2)) for rows in (*sizes, 2)) for _ in range(3))
        changed(tuple(interval), 0.7, halves, linear, tuple(change), 1, found)
        integrated(tuple(interval + h * change), 0.7, halves, linear, 1, high)
        integrated(tuple(interval - h * change), 0.7, halves, linear, 1, low)
        for got, one, other in zip(found, high, low, strict=True):
            np.testing.assert_allclose(got, (one - other) / (2.0 * h), atol=1e-9)


@pytest.mark.parametrize("nodes", [2, 3])
@pytest.mark.parametrize("half", [0, 1])
def test_traces_sum_to_one_and_have_their_derivatives(nodes: int, half: int) -> None:
    h = 1e-5
    for xi in (0.0, 0.3, 1.0):
        assert sum(trace(nodes, half, xi, i) for i in range(nodes)) == pytest.approx(1.0, abs=1e-15)
        for i in range(nodes):
            change = (trace(nodes, half, xi + h, i) - trace(nodes, half, xi - h, i)) / (2.0 * h)
            assert trace_derivative(nodes, half, xi, i) == pytest.approx(change, abs=1e-10)  # round-off over h


@pytest.mark.parametrize("halves", [0, 1, 2])
def test_hats_sum_to_one_and_have_their_derivatives(halves: int) -> None:
    for xi in (0.1, 0.7):
        assert hat(halves, xi, 0) + hat(halves, xi, 1) == pytest.approx(1.0, abs=1e-15)
        assert constant_basis(halves, xi, 0) + constant_basis(halves, xi, 1) == 1.0
        for k in range(2):
            change = (hat(halves, xi + 0.1, k) - hat(halves, xi - 0.1, k)) / 0.2
            assert hat_derivative(halves, k) == pytest.approx(change, abs=1e-14)
