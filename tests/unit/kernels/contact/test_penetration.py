"""Depths behind a chain against the distance to every segment."""

from __future__ import annotations

import numpy as np
from surfaces import chain

from contactlab.kernels.contact.penetration import depths, with_midpoints


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


def test_midpoints_follow_the_nodes() -> None:
    line, segments = np.random.default_rng(1).uniform(size=(5, 2)), chain(5).segments
    found = with_midpoints(line, segments)
    np.testing.assert_array_equal(found[:5], line)
    np.testing.assert_array_equal(found[5:], 0.5 * (line[:-1] + line[1:]))
