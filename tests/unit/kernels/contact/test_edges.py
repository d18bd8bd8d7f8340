"""Rows of node arrays, and the largest move."""

from __future__ import annotations

import numpy as np

from contactlab.kernels.contact.edges import largest_move, take


def test_take_copies_the_rows_of_an_index() -> None:
    values, index, out = np.random.default_rng(1).uniform(size=(9, 2)), np.array([8, 0, 3], np.int32), np.zeros((3, 2))
    take(values, index, out)
    np.testing.assert_array_equal(out, values[index])


def test_largest_move_is_that_of_one_coordinate() -> None:
    before, now = np.random.default_rng(2).uniform(size=(2, 40, 2))
    assert largest_move(now, before) == np.abs(now - before).max()
    assert largest_move(now, now) == 0.0
