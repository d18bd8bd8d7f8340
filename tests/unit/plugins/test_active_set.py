"""Active sets of frictionless conditions, function by function."""

from __future__ import annotations

import numpy as np
from contactlab_dynamics.active_set import Search, begin_descent


def test_a_descent_begins_within_the_conditions_in_use() -> None:
    """Gaps have room for all conditions of a model, the search for those in use: beyond it is other memory."""
    active, easy = np.array([True, False, True]), np.array([2.0, 4.0, 0.5])
    search = Search(active, np.full(3, 9.0), np.zeros(3), np.full(3, 9.0), easy, np.ones(3))
    gaps = np.array([-1.0, 2.0, -3.0, 5.0, -5.0])
    assert begin_descent.py_func(gaps, search) == 1.0 * 2.0 + 9.0 * 0.5
    assert np.array_equal(search.residual, [1.0, 0.0, 3.0])
    assert np.array_equal(search.direction, [2.0, 0.0, 1.5])
