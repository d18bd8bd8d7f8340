"""Separations from columns and the coupling against the dense product T^-T (D^T x - M^T y)."""

from __future__ import annotations

import numpy as np
import pytest
from surfaces import columns_of, dense_rows

from contactlab.kernels.contact.factored_rows import FAR, separations
from contactlab.kernels.contact.tables import CouplingColumns

ROUND_OFF = 1e-12  # of numbers near ten


@pytest.mark.parametrize("single", [False, True], ids=["slave columns", "own nodes"])
def test_separations_and_their_parts(single: bool) -> None:
    master, M, found, T = columns_of(1)
    slave, D, *_ = columns_of(7)
    draw = np.random.default_rng(3)
    x, y, angle = draw.uniform(size=(12, 2)), draw.uniform(size=(14, 2)), draw.uniform(0.0, 6.0, 12)
    x = x if single else np.concatenate([x, draw.uniform(size=(2, 2))])
    normals = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    separation, gaps = np.zeros((12, 2)), np.zeros((12, 2))
    columns = CouplingColumns(slave, master, np.full(1, single))
    separations(found.table, columns, (x, y), normals, separation, gaps)
    kept = found.order
    weighted = np.linalg.solve(T.T, -M @ y) + (x if single else np.linalg.solve(T.T, D @ x))
    np.testing.assert_allclose(separation[kept], weighted[kept], atol=ROUND_OFF)
    tangents = np.stack([normals[:, 1], -normals[:, 0]], axis=1)
    np.testing.assert_allclose(gaps[kept, 0], (normals * weighted).sum(axis=1)[kept], atol=ROUND_OFF)
    np.testing.assert_allclose(gaps[kept, 1], (tangents * weighted).sum(axis=1)[kept], atol=ROUND_OFF)
    np.testing.assert_array_equal(np.delete(gaps[:, 0], kept), FAR)


def test_both_ways_of_weighing_agree() -> None:
    """Columns and substitutions give what rows give: the rows are the columns, solved."""
    master, _, found, _ = columns_of(4)
    y = np.random.default_rng(5).uniform(size=(14, 2))
    separation, gaps = np.zeros((12, 2)), np.zeros((12, 2))
    normals = np.tile([0.0, 1.0], (12, 1))
    columns = CouplingColumns(master, master, np.full(1, True))
    separations(found.table, columns, (np.zeros((12, 2)), y), normals, separation, gaps)
    rows = dense_rows(found.rows(master, master.allocate(12, 14)), 14)
    np.testing.assert_allclose(separation[found.order], -(rows @ y)[found.order], atol=ROUND_OFF)
