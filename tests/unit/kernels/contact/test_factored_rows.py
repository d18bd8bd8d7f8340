"""Separations from columns and the coupling against the dense product T^-T (D^T x - M^T y)."""

from __future__ import annotations

import numpy as np
import pytest
from contactlab_mortar.mortar import MortarP1
from surfaces import columns_of

from contactlab.api import FactoredRows
from contactlab.kernels.contact.factored_rows import FAR, allow_constant_motion, largest_sideways, separations
from contactlab.kernels.contact.tables import BothSides
from contactlab.testing.surfaces import flat, pair_of, rows_of_pair

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
    columns, found.table.single[0] = BothSides(slave, master), single
    separations(found.table, columns, (x, y), normals, separation, gaps)
    kept = found.order
    weighted = np.linalg.solve(T.T, -M @ y) + (x if single else np.linalg.solve(T.T, D @ x))
    np.testing.assert_allclose(separation[kept], weighted[kept], atol=ROUND_OFF)
    tangents = np.stack([normals[:, 1], -normals[:, 0]], axis=1)
    np.testing.assert_allclose(gaps[kept, 0], (normals * weighted).sum(axis=1)[kept], atol=ROUND_OFF)
    np.testing.assert_allclose(gaps[kept, 1], (tangents * weighted).sum(axis=1)[kept], atol=ROUND_OFF)
    np.testing.assert_array_equal(np.delete(gaps[:, 0], kept), FAR)


def test_allow_constant_motion_of_rows_that_are_not_written_out() -> None:
    """Gaps less the motion that is allowed, against products with the rows themselves."""
    at, draw, last_dt = flat().lifted((0.0, 1e-3)), np.random.default_rng(4), 0.3
    pair, _ = pair_of(MortarP1(), at)
    factored, N = FactoredRows.allocate(pair.slots, 20 * pair.slots), len(at.nodes)
    assert pair.append_factored(factored)
    rows, count = rows_of_pair(pair, at), factored.count
    G = np.zeros((count, N, 2))
    for i in range(count):
        for z in range(rows.start[i], rows.start[i + 1]):
            G[i, rows.node[z]] += rows.normal_weight[z]
    gap, offset = factored.gap[:count].copy(), np.zeros(pair.slots)
    predicted, velocity = at.nodes + 0.05 * draw.normal(size=(N, 2)), draw.normal(size=(N, 2))
    allow_constant_motion(count, factored.packed.address, at.nodes, predicted, velocity, last_dt, offset)
    moved, came = (np.tensordot(G, x, 2) for x in (predicted - at.nodes, last_dt * velocity))
    allowed = np.minimum(np.minimum(-gap, -came), 0.0)
    assert (allowed < 0.0).any()
    np.testing.assert_allclose(factored.gap[:count], moved - allowed, atol=ROUND_OFF)
    np.testing.assert_allclose(offset[:count], gap + allowed, atol=ROUND_OFF)


def test_largest_sideways_distance_over_segments() -> None:
    pair, _ = pair_of(MortarP1(), flat())
    assert largest_sideways(pair.address) < ROUND_OFF
    k = pair.coupling.order[2]
    pair.gaps[k, 1] = -0.3
    assert largest_sideways(pair.address) == pytest.approx(0.3 / pair.coupling.full[k])
