"""Graded coordinates: the ratio holds, levels nest, mid nodes stay in the middle."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contactlab.meshing.grading import axis, check_axis


@given(count=st.integers(2, 30), ratio=st.floats(0.02, 50.0), level=st.integers(1, 4))
def test_levels_nest_and_the_ratio_is_that_of_level_one(count: int, ratio: float, level: int) -> None:
    coarse, fine = axis((-1.0, 3.0), count, ratio, 1).stations, axis((-1.0, 3.0), count, ratio, level).stations
    sizes = np.diff(coarse)
    assert sizes[-1] / sizes[0] == pytest.approx(ratio, rel=1e-8)  # round-off of differences of coordinates
    assert fine[::level] == pytest.approx(coarse, abs=1e-13)
    assert np.all(np.diff(fine) > 0.0)


def test_spans_have_their_own_counts_and_ratios() -> None:
    sizes = np.diff(axis((-5.0, -1.0, 1.0, 5.0), (4, 8, 4), (0.25, 1.0, 4.0), 1).stations)
    assert sizes[3] / sizes[0] == pytest.approx(0.25)
    assert sizes[4:12] == pytest.approx(np.full(8, 0.25))
    assert sizes[15] / sizes[12] == pytest.approx(4.0)


def test_nodes_between_corners_lie_in_the_middle() -> None:
    graded = axis((0.0, 1.0), 4, 5.0, 1)
    middles = graded((np.arange(4) + 0.5) / 4.0)
    assert middles == pytest.approx(0.5 * (graded.stations[1:] + graded.stations[:-1]), abs=1e-15)


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (((0.0, 0.0), 0, 3, 1.0), "increasing"),
        (((0.0, 1.0, 2.0), 0, 3, 1.0), "each of the 2 spans"),
        (((0.0, 1.0), 0, 0, 1.0), "at least 1"),
        (((0.0, 1.0), 0, 3, -1.0), "> 0"),
        (((0.0, 1.0), 0, 3, (1.0, 2.0)), "one for each"),
    ],
)
def test_what_does_not_fit_is_refused(arguments: tuple, word: str) -> None:
    with pytest.raises(ValueError, match=word):
        check_axis("x", *arguments)
