"""Derivatives of the pieces against central differences of the pieces."""

from __future__ import annotations

import numpy as np
import pytest
from contactlab_mortar.mortar import MortarP0, MortarP1
from dense_pieces import AGREED, SURFACES, along, central, derivatives_of, drawn_move


@pytest.mark.parametrize("vertices", [False, True], ids=["nodes", "vertices"])
@pytest.mark.parametrize("linear", [False, True], ids=["P0", "P1"])
@pytest.mark.parametrize("name", SURFACES)
def test_mortar_derivatives_are_central_differences_of_the_pieces(name: str, linear: bool, vertices: bool) -> None:
    """Of D, M and T, summed over the pieces, along a random move of all nodes."""
    at, algorithm = SURFACES[name], (MortarP1 if linear else MortarP0)("vertices" if vertices else "nodes")
    found, pieces, _, view = derivatives_of(algorithm, at)
    move, n, k = drawn_move(at), found.count, len(pieces.normal)
    step = along(view, at, found.moved[:n], move)[:, None, None]
    sides = (found.slave, found.dD, len(at.slave.nodes)), (found.master, found.dM, len(at.master.nodes))
    for (nodes, values, size), expected in zip(
        (*sides, (found.multiplier, found.dT, k)), central(algorithm, at, move)[:3], strict=True
    ):
        change = np.zeros((size, k))
        np.add.at(change, (nodes[:n, :, None], found.multiplier[:n, None, :]), step * values[:n])
        assert np.abs(expected).max() > 0.1
        np.testing.assert_allclose(change, expected, atol=AGREED)
