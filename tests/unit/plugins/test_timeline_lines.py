"""Lines of the timeline, with the steps that they need."""

from __future__ import annotations

import numpy as np
import pytest

series = pytest.importorskip("contactlab_rerun.series", reason="rerun-sdk is not installed (plugin contactlab-rerun)")


@pytest.mark.parametrize("last", [1, 2, 3, 1000])
def test_pieces_pass_through_all_that_is_left_out(last: int) -> None:
    x = np.cumsum(np.random.default_rng(1).integers(1, 4, last + 1)).astype(float)  # steps were thinned already
    share = x / x[-1]
    lines = np.stack([np.sin(6.0 * share), np.where(share < 0.4, 0.0, 3.0)], axis=1)
    kept = series.corners(x, lines)
    assert {0, last} <= set(kept.tolist())
    for line in lines.T:
        assert np.abs(np.interp(x, x[kept], line[kept]) - line).max() <= series.SEEN * np.abs(lines).max()
    # pieces of length h are off a sine of 6 rad by 6^2 h^2 / 8 at most, and the jump takes as many as halvings
    assert len(kept) <= max(last + 1 if last < 100 else 0, 2.0 * 6.0 / np.sqrt(8.0 * 3.0 * series.SEEN) + 2.0 * 10.0)


def test_of_noise_the_extremes_stay() -> None:
    noise = np.random.default_rng(1).normal(size=(1000, 2))
    kept = series.corners(np.arange(1000.0), noise)
    assert len(kept) <= 252
    for line in noise.T:
        parts = line[:992].reshape(-1, 16)
        assert {*parts.max(axis=1), *parts.min(axis=1)} <= set(line[kept])


def test_what_is_not_a_number_stays() -> None:
    line = np.zeros((100, 1))
    line[37] = np.nan
    assert 37 in series.corners(np.arange(100.0), line)
