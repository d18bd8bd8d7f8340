"""Gradients of the weighted separations against their central differences."""

from __future__ import annotations

import numpy as np
import pytest
from contactlab_mortar.mortar import MortarP0, MortarP1
from dense_pieces import AGREED, SURFACES, central, drawn_move, fold, pieces_of, view_of

from contactlab.api import GapGradients


@pytest.mark.parametrize(("linear", "vertices"), [(False, False), (True, False), (True, True)])
@pytest.mark.parametrize("name", sorted({*SURFACES} - {"curved"}))
def test_mortar_gradients_are_central_differences_of_separations(name: str, linear: bool, vertices: bool) -> None:
    """Of D^T x - M^T y - T^T r at fixed positions x and y and separations r, two multipliers being one."""
    at, algorithm = SURFACES[name], (MortarP1 if linear else MortarP0)("vertices" if vertices else "nodes")
    view = view_of(at, ends=False)
    pieces, count = pieces_of(algorithm, view)
    k = len(pieces.normal)
    owner, r = np.arange(k, dtype=np.int32), np.random.default_rng(5).normal(size=(k, 2))
    owner[3], owner[5] = 4, -1  # merged and dropped: the separations that T weighs are those of owners
    found = GapGradients.allocate(count, 2, 12, 4 * k)
    assert algorithm.gradients(view, pieces, count, owner, r, found)
    move = drawn_move(at)
    moved = np.concatenate([move[at.slave.nodes], move[at.master.nodes]])
    both = np.where(found.node[:count, :, None] >= 0, moved[found.node[:count]], 0.0)
    change = np.zeros((k, 2))
    np.add.at(change, found.multiplier[:count], np.einsum("pjdvc,pvc->pjd", found.value[:count], both))
    dD, dM, dT, _ = central(algorithm, at, move, ends=False)
    seen = np.where(owner[:, None] >= 0, r[owner], 0.0)
    np.testing.assert_allclose(change, dD.T @ view.at.slave - dM.T @ view.at.master - dT.T @ seen, atol=2.0 * AGREED)


def test_mortar_gradients_are_not_given_where_normals_are_not_the_averaged_ones() -> None:
    view = view_of(fold())
    pieces, count = pieces_of(MortarP1(), view)
    k = len(pieces.normal)
    found = GapGradients.allocate(count, 2, 12, 4 * k)
    assert not MortarP1().gradients(view, pieces, count, np.arange(k, dtype=np.int32), np.zeros((k, 2)), found)
