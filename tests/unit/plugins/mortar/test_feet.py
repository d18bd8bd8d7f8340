"""Where pieces begin and end: points that see each other along the slave's normals."""

from __future__ import annotations

import numpy as np
import pytest
from contactlab_mortar.mortar import MortarP0, MortarP1
from dense_pieces import SURFACES, fold, pieces_of, view_of


@pytest.mark.parametrize("name", ["shallow", "partly covered"])
def test_mortar_feet_see_each_other_along_the_normals(name: str) -> None:
    view, algorithm = view_of(SURFACES[name], ends=False), MortarP0()
    pieces, count = pieces_of(algorithm, view)
    feet = np.full((count, 4), np.nan)
    assert algorithm.feet(view, pieces, count, feet)
    # what is found again is what was found, also for pieces that are made once more
    kept = np.full((count, 4), np.nan)
    assert algorithm.pieces(view, pieces) == count
    assert algorithm.feet(view, pieces, count, kept)
    np.testing.assert_array_equal(kept, feet)
    x, y = view.at.slave[pieces.slave[:count]], view.at.master[pieces.master[:count]]
    n = pieces.normal[pieces.slave[:count]]
    for xi, eta in (feet[:, :2].T, feet[:, 2:].T):
        xi, eta = xi[:, None], eta[:, None]
        across = (1.0 - xi) * x[:, 0] + xi * x[:, 1] - (1.0 - eta) * y[:, 0] - eta * y[:, 1]
        q = (1.0 - xi) * n[:, 0] + xi * n[:, 1]
        np.testing.assert_allclose(across[:, 0] * q[:, 1] - across[:, 1] * q[:, 0], 0.0, atol=1e-14)
    # the integral of one over a piece is how long it is
    length = np.linalg.norm(x[:, 1] - x[:, 0], axis=1) * (feet[:, 2] - feet[:, 0])
    np.testing.assert_allclose(length, pieces.T[:count].sum(axis=(1, 2)), atol=1e-14)


def test_mortar_feet_are_not_given_where_normals_are_not_the_averaged_ones() -> None:
    view = view_of(fold())
    pieces, count = pieces_of(MortarP1(), view)
    assert not MortarP1().feet(view, pieces, count, np.zeros((count, 4)))
