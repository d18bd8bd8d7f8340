"""The best piecewise linear approximation: closed forms, an order, and nothing that is nearer."""

from __future__ import annotations

import math

import numpy as np
import pytest

from contactlab.accuracy.efficiency import best_error
from contactlab.studies.profile import Profile, distance, norm


def test_a_parabola_is_missed_by_its_closed_form() -> None:
    # x^2 less its interpolant is s (h - s) in each segment; its mean h^2/6 belongs to the functions, and what is left
    # is orthogonal to all of them: the square of the error is h^5/180 a segment
    fine = np.linspace(0.0, 1.0, 40001)
    for count in (1, 3, 10):
        nodes = np.linspace(0.0, 1.0, count + 1)
        h = 1.0 / count
        wanted = math.sqrt(count * h**5 / 180.0) / math.sqrt(1.0 / 5.0)
        assert best_error(nodes, Profile(fine, fine**2)) == pytest.approx(wanted, rel=1e-6)  # the parabola's own facets
    # a step from 0 to 1 in the middle of one segment: its best line 1/2 + 3/2 (s - 1/2) leaves a quarter of the square
    step = Profile(np.array([0.0, 0.5, 0.5, 1.0]), np.array([0.0, 0.0, 1.0, 1.0]))
    assert best_error(np.array([0.0, 1.0]), step) == pytest.approx(math.sqrt((0.25 - 0.1875) / 0.5))


def test_a_function_of_the_space_is_met() -> None:
    x = np.array([0.0, 0.3, 0.5, 1.2])
    assert best_error(x[::-1], Profile(x, np.array([1.0, 3.0, -2.0, 0.5]))) < 1e-14


def test_hertz_is_followed_to_first_order_and_nothing_is_nearer() -> None:
    angles = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 8001)
    circle = Profile(np.sin(angles), np.cos(angles))
    found = []
    for n in (8, 16, 32, 64):
        nodes = np.linspace(-1.5, 1.5, 3 * n + 2)  # two thirds of a segment from node to edge, on every mesh
        found.append(best_error(nodes, circle))
        interpolant = Profile(nodes, circle(nodes))
        assert found[-1] < distance(interpolant, circle) / norm(circle)
    # the square root at the edge: its best linear function is off by h^(1/2) over a length of h
    orders = np.log2(np.array(found[:-1]) / np.array(found[1:]))
    assert np.abs(orders - 1.0).max() < 0.25  # the edge lies a little elsewhere in its segment from mesh to mesh


def test_a_window_leaves_out_what_lies_beyond() -> None:
    fine = np.linspace(-1.0, 1.0, 20001)
    kinked = Profile(fine, np.where(fine < 0.5, fine + 2.0, 100.0 * fine**2))
    nodes = np.linspace(-1.0, 1.0, 21)
    assert best_error(nodes, kinked) > 1e-3
    assert best_error(nodes, kinked, (-1.0, 0.4)) < 1e-12
    assert best_error(nodes, kinked, (-0.83, 0.37)) < 1e-12  # between nodes
    # what lies beyond the nodes is missed whole
    assert best_error(np.array([0.0, 0.5]), Profile(np.array([-1.0, 1.0]), np.ones(2))) == pytest.approx(
        math.sqrt(0.75)
    )


def test_without_nodes_there_is_none() -> None:
    assert math.isnan(best_error(np.array([0.3]), Profile(np.array([0.0, 1.0]), np.ones(2))))
    assert math.isnan(best_error(np.array([0.0, 1.0]), Profile(np.array([0.0, 1.0]), np.zeros(2))))
