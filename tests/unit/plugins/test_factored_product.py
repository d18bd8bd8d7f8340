"""Products with factored conditions, function by function."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from contactlab_dynamics.factored_product import WIDEST, Touched, band_of

from contactlab.api import Floats

ROUND_OFF = 1e-13
CONDITIONS, NODES = 9, 12


def drawn(seed: int, reach: int) -> tuple[Any, Touched, Floats]:
    """Rows of which each weighs some nodes along a chain, the fourth none; what they touch, and B (k, L) in full."""
    draw = np.random.default_rng(seed)
    full = np.zeros((CONDITIONS, NODES))
    for i in range(CONDITIONS):
        first = min(i, NODES - 1)
        full[i, first : first + draw.integers(1, reach + 1)] = draw.uniform(0.5, 1.5)
    full[3] = 0.0
    full = full[:, full.any(axis=0)]  # every node is there because a row touches it
    row, local = np.nonzero(full)
    rows = SimpleNamespace(weight=full[row, local])
    return rows, Touched(local.astype(np.int32), row.astype(np.int32), np.full(CONDITIONS, -1, np.int32)), full


def dense(band: Floats) -> Floats:
    """The matrix (k, k) of a layer of a band."""
    half = len(band) // 2 - 1
    found = np.zeros((CONDITIONS, CONDITIONS))
    for d in range(-half, half + 1):
        for i in range(CONDITIONS):
            if 0 <= i + d < CONDITIONS:
                found[i, i + d] = band[half + d, i]
            else:
                assert band[half + d, i] == 0.0
    return found


@pytest.mark.parametrize("reach", [1, 3, 6])
@pytest.mark.parametrize("seed", range(3))
def test_band_of_holds_what_conditions_do_to_each_other(seed: int, reach: int) -> None:
    rows, touched, full = drawn(seed, reach)
    nodes = full.shape[1]
    soft = np.repeat(np.random.default_rng(seed).uniform(0.5, 2.0, (nodes, 1)), 2, axis=1)
    band = band_of.py_func(rows, touched, soft, nodes)
    assert len(band) == 1
    assert band.shape[1] % 4 == 0
    np.testing.assert_allclose(dense(band[0]), full @ np.diag(soft[:, 0]) @ full.T, atol=ROUND_OFF)


def test_band_of_nodes_that_give_way_in_one_direction_has_two_layers() -> None:
    rows, touched, full = drawn(5, 3)
    nodes = full.shape[1]
    soft = np.random.default_rng(5).uniform(0.5, 2.0, (nodes, 2))
    soft[4, 1], soft[6] = 0.0, 0.0
    band = band_of.py_func(rows, touched, soft, nodes)
    assert len(band) == 2
    for c in range(2):
        np.testing.assert_allclose(dense(band[c]), full @ np.diag(soft[:, c]) @ full.T, atol=ROUND_OFF)


@pytest.mark.parametrize(("moves", "layers"), [(1.0, 0), (0.0, 1)])
def test_band_of_a_node_that_joins_conditions_far_apart_is_none_unless_it_is_fixed(moves: float, layers: int) -> None:
    count = WIDEST + 2
    row = np.repeat(np.arange(count, dtype=np.int32), 2)
    local = np.stack([np.zeros(count, np.int32), np.arange(1, count + 1, dtype=np.int32)], axis=1).ravel()
    soft = np.ones((count + 1, 2))
    soft[0] = moves
    touched = Touched(local, row, np.full(count, -1, np.int32))
    assert len(band_of.py_func(SimpleNamespace(weight=np.ones(2 * count)), touched, soft, count + 1)) == layers
