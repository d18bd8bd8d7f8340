"""Depths behind a chain against the distance to every segment."""

from __future__ import annotations

import numpy as np
import pytest
from surfaces import chain

from contactlab.kernels.contact.penetration import depths


def test_depths_behind_are_distances_to_the_nearest_segment() -> None:
    """The body lies on the left of the chain; its outside, and what is beyond its ends, counts nothing."""
    line = np.stack([np.linspace(3.0, 0.0, 7), np.zeros(7)], axis=1)  # the body is below
    points = np.array([[1.0, -0.2], [2.2, -0.7], [1.4, 0.3], [-0.5, -0.1], [3.5, -0.1], [1.5, -5.0]])
    np.testing.assert_allclose(depths(points, line, chain(7).segments, 1.0), [0.2, 0.7, 0.0, 0.0, 0.0, 0.0], atol=1e-15)


def test_depths_behind_a_bent_chain_are_those_of_the_nearest_segment() -> None:
    """A corner of 90 degrees: a point inside is as deep as the nearer of its two flanks is far."""
    corner = np.array([[0.0, 2.0], [0.0, 0.0], [2.0, 0.0]])  # down, then right: the body is above and to the right
    points = np.array([[0.3, 1.5], [1.2, 0.4], [-0.3, 1.0], [1.0, -0.3]])
    np.testing.assert_allclose(depths(points, corner, chain(3).segments, 1.0), [0.3, 0.4, 0.0, 0.0], atol=1e-15)


@pytest.mark.parametrize("turn", [0.0, 0.4, 0.5 * np.pi])
def test_depths_are_those_of_every_point_held_against_every_segment(turn: float) -> None:
    chance = np.random.default_rng(7)
    x = np.sort(chance.uniform(-1.0, 1.0, 40))
    rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    positions = np.stack([x, 0.2 * np.sin(5.0 * x)], axis=1) @ rotation
    segments = np.stack([np.arange(39), np.arange(1, 40)], axis=1).astype(np.int32)
    segments = segments[chance.permutation(39)]
    points, limit = np.stack([chance.uniform(-1.2, 1.2, 300), chance.uniform(-0.4, 0.4, 300)], axis=1) @ rotation, 0.15
    a, along = positions[segments[:, 0]], positions[segments[:, 1]] - positions[segments[:, 0]]
    length = np.hypot(*along.T)
    off = points[:, None] - a
    share = (off * along).sum(axis=2) / length**2
    gap = (off[:, :, 0] * along[:, 1] - off[:, :, 1] * along[:, 0]) / length
    gap[(share < 0.0) | (share > 1.0)] = np.inf
    nearest = gap[np.arange(300), np.abs(gap).argmin(axis=1)]
    expected = np.where(np.abs(nearest) < limit, np.maximum(0.0, -nearest), 0.0)
    assert (expected > 0.0).sum() > 20
    assert depths(points, positions, segments, limit) == pytest.approx(expected, abs=1e-14)
