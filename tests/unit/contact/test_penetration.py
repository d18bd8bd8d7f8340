"""Depths behind a chain, against every point held against every segment."""

from __future__ import annotations

import numpy as np
import pytest

from contactlab.kernels.contact.penetration import depths


@pytest.mark.parametrize("turn", [0.0, 0.4, 0.5 * np.pi])
def test_as_brute_force_says(turn: float) -> None:
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
