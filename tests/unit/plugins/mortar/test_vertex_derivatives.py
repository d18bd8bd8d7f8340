"""Derivatives of normals at vertices against central differences."""

from __future__ import annotations

import numpy as np
import pytest
from contactlab_mortar.mortar import MortarP0, MortarP1
from dense_pieces import along, central, derivatives_of, drawn_move, fold

STEEP = 1e-7  # of central differences: the shares turn by 4 per 0.2 of a sine, so their third derivatives are near 1e3


@pytest.mark.parametrize("algorithm", [MortarP0(), MortarP1()], ids=["P0", "P1"])
def test_vertex_derivatives_are_central_differences_of_the_normals(algorithm: MortarP0) -> None:
    """All three parts at once: the averaged normal, what is seen of the master, and the turn of the slave."""
    at = fold()
    found, pieces, _, view = derivatives_of(algorithm, at)
    move, n = drawn_move(at), found.normal_count
    assert n > 4 * len(at.slave.nodes)  # there is more than what averaged normals have
    change = np.zeros_like(pieces.normal)
    step = along(view, at, found.normal_moved[:n], move)
    np.add.at(change, found.normal_of[:n], step[:, None] * found.dnormal[:n])
    expected = central(algorithm, at, move)[3]
    assert np.abs(expected).max() > 1.0
    np.testing.assert_allclose(change, expected, atol=STEEP * np.abs(expected).max())
