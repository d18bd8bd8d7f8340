"""The sorted search against all pairs of boxes."""

from __future__ import annotations

import numpy as np
import pytest
from surfaces import chain

from contactlab.kernels.contact.search import near_segments


def wave(points: int, seed: int, turned: bool) -> np.ndarray:
    draw = np.random.default_rng(seed)
    x = np.cumsum(draw.uniform(0.1, 1.0, points))
    y = draw.normal(0.0, 2.0, points)
    return np.stack([y, x] if turned else [x, y], axis=1)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("reach", [0.0, 0.3, 50.0])
@pytest.mark.parametrize("seed", range(3))
def test_sweep_finds_what_comparing_all_boxes_finds(seed: int, reach: float, turned: bool) -> None:
    slave, master = wave(17, seed, turned), wave(30, seed + 10, turned)
    own, other = chain(17).segments, chain(30).segments
    found = near_segments(slave, own, master, other, reach)
    ends, others = slave[own], master[other]
    apart = (others.min(axis=1)[None] > ends.max(axis=1)[:, None] + reach) | (
        others.max(axis=1)[None] < ends.min(axis=1)[:, None] - reach
    )
    for s, near in enumerate(~apart.any(axis=2)):
        np.testing.assert_array_equal(found.master[found.start[s] : found.start[s + 1]], np.flatnonzero(near))
