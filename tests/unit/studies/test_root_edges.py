"""Edges of contact followed to where the pressure ends: Hertz's half circle on meshes whose nodes miss its edges."""

from __future__ import annotations

import numpy as np
import pytest

from contactlab.studies.profile import Profile, distance, integral, norm
from contactlab.studies.root_edges import with_root_edges

FINE = np.linspace(-1.0, 1.0, 20001)
CIRCLE = Profile(FINE, np.sqrt(1.0 - FINE**2))


def carried(x: np.ndarray) -> Profile:
    """Exact at nodes `x`, but for the two next to the edges: these carry what is left of the force beyond."""
    values = np.sqrt(np.maximum(0.0, 1.0 - x**2))
    pressed = np.flatnonzero(values)
    for edge, step in ((pressed[0], 1), (pressed[-1], -1)):
        inner = x[edge + step]
        left = 0.25 * np.pi - 0.5 * (abs(inner) * np.sqrt(1.0 - inner**2) + np.arcsin(abs(inner)))  # integral to 1
        h = abs(x[edge] - inner)
        values[edge] = left / h - 0.5 * values[edge + step]
    return Profile(x, values)


@pytest.mark.parametrize("shift", [0.0, 0.2, 0.4, 0.6, 0.8])
def test_edges_of_the_half_circle_are_found_wherever_nodes_lie(shift: float) -> None:
    h = 1.0 / 16
    found = carried((np.arange(-24, 25) + shift) * h)
    followed = with_root_edges(found)
    assert distance(followed, CIRCLE) < 0.4 * distance(found, CIRCLE)
    assert distance(followed, CIRCLE) < 0.01 * norm(CIRCLE)
    edges = followed.x[np.flatnonzero(followed.value > 0.0)[[0, -1]] + [-1, 1]]
    assert np.abs(np.abs(edges) - 1.0).max() < 0.2 * h  # of the nodes' half a segment
    # the force is what the edges were found by
    assert integral(followed) == pytest.approx(integral(found), rel=1e-4)


@pytest.mark.parametrize("shift", [0.0, 0.3, 0.6])
def test_edges_of_every_contact_are_followed(shift: float) -> None:
    # three half circles side by side, the outer ones half as high; the last one is cut off, as by the end of a body
    h = 1.0 / 16
    one = carried((np.arange(-22, 23) + shift) * h)
    scales, places = (0.5, 1.0, 0.5), np.array([-3.0, 0.0, 3.0])
    raw = Profile(np.concatenate([one.x + at for at in places]), np.concatenate([k * one.value for k in scales]))
    exact = Profile(np.concatenate([FINE + at for at in places]), np.concatenate([k * CIRCLE.value for k in scales]))
    followed = with_root_edges(raw)
    assert distance(followed, exact) < 0.4 * distance(raw, exact)
    assert distance(followed, exact) < 0.01 * norm(exact)
    assert np.all(np.diff(followed.x) >= 0.0)
    inside = raw.x < 3.0
    cut = Profile(raw.x[inside], raw.value[inside])
    ends = with_root_edges(cut)
    assert ends.x[-1] == cut.x[-1]
    assert ends.value[-1] == cut.value[-1]
    near = (-4.5, 2.5)
    assert distance(ends, exact, near) < 0.4 * distance(cut, exact, near)


def test_edges_that_are_no_roots_stay() -> None:
    x = np.linspace(-1.5, 1.5, 49)
    punch = np.where(np.abs(x) < 0.95, 1.0 / np.sqrt(np.maximum(1.0 - x**2, 0.05)), 0.0)  # grows to its corners
    flat = np.ones(49)  # pressed to the ends of the body
    few = np.where(np.abs(x) < 0.15, 1.0, 0.0)
    for values in (punch, flat, few, np.zeros(49)):
        profile = Profile(x, values)
        followed = with_root_edges(profile)
        np.testing.assert_array_equal(followed.x, x)
        np.testing.assert_array_equal(followed.value, values)
    assert with_root_edges(Profile(x[:0], x[:0])).x.size == 0


def test_what_dies_away_beyond_an_edge_is_no_contact() -> None:
    """The inverse of T carries pressures of a dual basis on, down to numbers whose products underflow."""
    h = 1.0 / 16
    found = carried(np.arange(-60, 61) * h + 0.02)
    echo = 1e-7 * 1e-5 ** np.arange(40)
    last = int(np.flatnonzero(found.value)[-1])
    values = found.value.copy()
    values[last + 1 : last + 1 + len(echo)] = echo[: len(values) - last - 1]
    followed = with_root_edges(Profile(found.x, values))
    assert distance(followed, with_root_edges(found)) < 1e-6
