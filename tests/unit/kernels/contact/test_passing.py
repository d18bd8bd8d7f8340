"""Points that pass through a chain of segments, by hand: the chain lies on y = 0, with its body below."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from contactlab.kernels.contact.passing import find_passages

SEGMENTS = np.array([[0, 1], [1, 2]], np.int32)
FLAT = np.array([[1.0, 0.0], [0.0, 0.0], [-1.0, 0.0]])
PLATE = np.array([[1.0, 0.0], [0.0, 0.0], [-1.0, 0.0], [-1.0, -0.5], [1.0, -0.5]])
ROUND_PLATE = np.array([[0, 1], [1, 2], [2, 3], [3, 4], [4, 0]], np.int32)
UP = FLAT + np.array([0.0, 3.0])
LIMIT = 0.1


def share(start: Any, end: Any, before: Any = FLAT, after: Any = None, segments: Any = SEGMENTS) -> float:
    """The passage of one point."""
    after = before if after is None else after
    points = np.array([start]), np.array([end]), np.array([99], np.int32)
    chain = np.asarray(before), np.asarray(after), np.arange(len(before), dtype=np.int32)
    return float(find_passages(points, chain, segments, LIMIT)[0])


@pytest.mark.parametrize("x", [0.3, -0.7, 0.0])
@pytest.mark.parametrize("depth", [0.2, 36.0, 1e6])
def test_a_point_is_followed_however_far_it_goes(x: float, depth: float) -> None:
    """Also through the node between two segments: it is `LIMIT` deep at that share of its way."""
    assert share([x, 0.01], [x, -depth]) == pytest.approx((0.01 + LIMIT) / (0.01 + depth), rel=1e-9)


@pytest.mark.parametrize(
    ("start", "end"),
    [
        ([0.3, 0.01], [0.3, -0.09]),  # not deep enough
        ([1.3, 0.01], [1.3, -36.0]),  # beside the chain
        ([0.3, 0.0], [5.3, 0.0]),  # slides off
        ([0.3, -0.001], [0.3, 5.0]),  # comes out
        ([0.3, -36.0], [0.3, 5.0]),  # comes from behind
    ],
)
def test_what_does_not_pass_through(start: Any, end: Any) -> None:
    assert share(start, end) == np.inf


def test_a_chain_that_moves_passes_a_point_as_well() -> None:
    assert share([0.3, 0.5], [0.3, 0.5], after=UP) == pytest.approx((0.5 + LIMIT) / 3.0)
    assert share([0.3, 0.5], [0.3, 3.6], after=UP) == np.inf


def test_a_point_that_comes_out_behind_a_plate_stops_in_its_middle() -> None:
    assert share([0.3, 0.75], [0.3, -9.25], PLATE, segments=ROUND_PLATE) == pytest.approx((0.75 + 0.25) / 10.0)
    touching = share([0.3, 0.0], [0.3, -10.0], PLATE, segments=ROUND_PLATE)
    assert 0.0 < touching < 0.05


@pytest.mark.parametrize("twice", [True, False])
def test_a_point_at_a_corner_leaves_the_body_there(twice: bool) -> None:
    """It lies in an acute corner by round-off, at one side, and leaves by the other: it has passed through nothing.

    A closed chain may have its first node `twice`, with one number.
    """
    acute = PLATE[[4, 0, 1, 2, 3, 4]]
    acute[1, 0] -= 1e-6
    chain = np.array([[0, 1], [1, 2], [2, 3], [3, 4], [4, 5]], np.int32)
    numbers = np.array([0, 1, 2, 3, 4, 0], np.int32)
    if not twice:
        acute, numbers, chain = acute[:5], numbers[:5], np.where(chain == 5, 0, chain).astype(np.int32)
    place, up = acute[:1] + np.array([-1e-9, 1e-7]), np.array([0.0, 3e-7])
    passed = find_passages((place, place, np.array([99])), (acute, acute + up, numbers), chain, LIMIT)
    assert np.isinf(passed).all()


def test_a_turned_and_shifted_motion_has_the_same_share() -> None:
    """All positions turned by an angle and shifted far away: products of coordinates keep 1e-9."""
    c, s = np.cos(0.7), np.sin(0.7)

    def there(points: Any) -> Any:
        return np.asarray(points) @ np.array([[c, s], [-s, c]]) + np.array([40.0, -70.0])

    moved = FLAT + np.array([0.1, 0.05])
    one = share([0.3, 0.2], [-0.4, -3.0], FLAT, moved)
    other = share(there([0.3, 0.2]), there([-0.4, -3.0]), there(FLAT), there(moved))
    assert np.isfinite(one)
    assert other == pytest.approx(one, rel=1e-9)


def test_nodes_of_a_chain_do_not_pass_through_their_own_segments() -> None:
    own = np.arange(3, dtype=np.int32)
    after = FLAT + np.array([[0.0, -5.0], [0.0, 0.0], [0.0, 0.0]])
    assert np.isinf(find_passages((FLAT, after, own), (FLAT, after, own), SEGMENTS, LIMIT)).all()
