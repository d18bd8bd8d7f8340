"""Integrals of piecewise linear functions are exact, whatever the meshes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contactlab.studies.profile import FoldedSurfaceError, Profile, distance, integral, norm

# Sums of a few dozen products of numbers of order one to a hundred: round-off only.
ROUND_OFF = 1e-12

lengths = st.lists(st.floats(0.01, 2.0), min_size=1, max_size=12)
values = st.floats(-100.0, 100.0)


@st.composite
def profiles(draw: st.DrawFn) -> Profile:
    steps = draw(lengths)
    x = draw(st.floats(-3.0, 3.0)) + np.concatenate([[0.0], np.cumsum(steps)])
    return Profile(x, np.array(draw(st.lists(values, min_size=x.size, max_size=x.size))))


def test_norm_of_a_hat_is_the_closed_form() -> None:
    hat = Profile(np.array([-1.0, 0.0, 3.0]), np.array([0.0, 2.0, 0.0]))
    assert integral(hat) == pytest.approx(4.0, rel=ROUND_OFF)
    assert norm(hat) ** 2 == pytest.approx(4.0 * 4.0 / 3.0, rel=ROUND_OFF)


def test_distance_of_two_boxes_counts_the_jumps_at_their_ends() -> None:
    a = Profile(np.array([0.0, 2.0]), np.array([1.0, 1.0]))
    b = Profile(np.array([1.0, 3.0]), np.array([1.0, 1.0]))
    assert distance(a, b) ** 2 == pytest.approx(2.0, rel=ROUND_OFF)


def test_window_cuts_inside_segments() -> None:
    line = Profile(np.array([0.0, 10.0]), np.array([0.0, 10.0]))
    assert integral(line, (2.5, 3.5)) == pytest.approx(3.0, rel=ROUND_OFF)
    assert norm(line, (1.0, 4.0)) ** 2 == pytest.approx((64.0 - 1.0) / 3.0, rel=ROUND_OFF)
    assert integral(line, (9.0, 12.0)) == pytest.approx(9.5, rel=ROUND_OFF)


@given(profiles(), st.lists(st.floats(0.01, 0.99), max_size=8))
def test_refining_a_profile_changes_nothing(profile: Profile, shares: list[float]) -> None:
    x = np.unique(np.concatenate([profile.x, profile.x[0] + np.array(shares) * np.ptp(profile.x)]))
    scale = np.abs(profile.value).max() * np.sqrt(np.ptp(profile.x)) + 1.0
    assert distance(profile, Profile(x, profile(x))) <= 1e-10 * scale  # square root of round-off in a square


@given(profiles(), profiles())
def test_distance_obeys_the_parallelogram_law_on_a_common_mesh(a: Profile, b: Profile) -> None:
    if a.x[-1] >= b.x[0] and b.x[-1] >= a.x[0]:
        x = np.unique(np.concatenate([a.x, b.x]))
        inside = x[(x >= max(a.x[0], b.x[0])) & (x <= min(a.x[-1], b.x[-1]))]
        if inside.size > 1:
            window = (float(inside[0]), float(inside[-1]))
            total = Profile(inside, a(inside) + b(inside))
            left = norm(total, window) ** 2 + distance(a, b, window) ** 2
            right = 2.0 * (norm(a, window) ** 2 + norm(b, window) ** 2)
            assert left == pytest.approx(right, rel=1e-9, abs=1e-9)


@given(profiles(), profiles())
def test_distance_is_symmetric_and_survives_reflection(a: Profile, b: Profile) -> None:
    assert distance(a, b) == pytest.approx(distance(b, a), rel=ROUND_OFF)
    assert distance(a.mirrored(0.3), b.mirrored(0.3)) == pytest.approx(distance(a, b), rel=1e-9, abs=1e-9)


def test_nodes_may_come_in_either_direction() -> None:
    x, value = np.array([0.0, 1.0, 3.0]), np.array([1.0, 5.0, 2.0])
    forward, backward = Profile.of_nodes(x, value), Profile.of_nodes(x[::-1], value[::-1])
    assert distance(forward, backward) == 0.0


def test_upright_sides_without_pressure_are_left_out() -> None:
    x = np.array([0.0, 0.01, 0.0, 1.0, 2.0, 2.0, 1.9])
    for echo in (0.0, 1e-7):
        value = np.array([echo**2, echo, echo, 4.0, 0.0, echo, echo**2])
        assert integral(Profile.of_nodes(x, value)) == pytest.approx(4.0, rel=max(ROUND_OFF, echo))


def test_pressure_on_a_folded_surface_is_refused() -> None:
    with pytest.raises(FoldedSurfaceError, match="turns back"):
        Profile.of_nodes(np.array([0.0, 1.0, 0.5]), np.array([1.0, 2.0, 3.0]))


def test_edges_are_read_between_nodes_and_at_a_chain_end() -> None:
    ramp = Profile(np.array([0.0, 1.0, 2.0]), np.array([0.0, 10.0, 10.0]))
    assert ramp.edges(2.5) == (pytest.approx(0.25), 2.0)
    assert ramp.edges(11.0) is None


def test_a_profile_without_nodes_is_zero() -> None:
    empty = Profile.of_nodes(np.array([0.0, 1.0, 0.5]), np.zeros(3))
    assert integral(Profile(np.array([0.0, 1.0]), np.array([1.0, 1.0]))) == 1.0
    assert norm(empty) == 0.0
