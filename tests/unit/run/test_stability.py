"""Scaling of the equations whose pivots tell whether an equilibrium is stable."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csc_array

from contactlab.run.stability import _scaled


def test_scaling_leaves_the_matrix_as_it_is() -> None:
    """Also one that stores zeros and has none on its diagonal: its stiffness is looked at afterwards."""
    values, rows, start = np.array([2.0, 0.0, 1.0, 0.0, 3.0, 4.0]), np.array([0, 1, 2, 0, 1, 0]), np.array([0, 3, 5, 6])
    matrix = csc_array((values, rows, start), shape=(3, 3))
    before = matrix.toarray()
    scaled, scale = _scaled(matrix)
    np.testing.assert_array_equal(matrix.toarray(), before)
    np.testing.assert_allclose(scaled.toarray(), scale[:, None] * before * scale, rtol=1e-15)
    np.testing.assert_allclose(np.diagonal(scaled.toarray()), [1.0, 1.0, 0.0], rtol=1e-15)
