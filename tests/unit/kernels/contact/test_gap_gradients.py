"""Which rows of consistent forces there are, and what they hold at the end of a step (test_consistent_forces: rows)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from contactlab_mortar.mortar import MortarP1

from contactlab.api import Floats
from contactlab.contact.explicit_system import allocate_rows
from contactlab.contact.gradients import PairGradients
from contactlab.kernels.contact import gap_gradients as kernels
from contactlab.testing.surfaces import curved, pair_of


def dense(rows: Any, weight: Floats, nodes: int) -> Floats:
    """Weights (k, N, 2) of rows."""
    out, end = np.zeros((rows.count, nodes, 2)), rows.start[rows.count]
    np.add.at(
        out, (np.repeat(np.arange(rows.count), np.diff(rows.start[: rows.count + 1])), rows.node[:end]), weight[:end]
    )
    return out


def test_write_rows_leaves_out_open_rows_and_tells_that_rows_do_not_fit() -> None:
    at = curved()
    pair, memory = pair_of(MortarP1(), at, friction=True)
    gaps, kept = pair.gaps[:, 0], pair.coupling.order
    margin, pressed, gradients = float(np.median(gaps[kept])), np.zeros((2, pair.slots)), PairGradients(pair)
    farthest = kept[np.argmax(gaps[kept])]
    pressed[0, farthest] = 1.0
    for room, given in ((64, True), (1, False)):
        rows = allocate_rows(pair.slots, room, True)
        assert (gradients.append_rows(rows, 0, margin, pressed, memory) >= 0) is given
        if given:
            assert set(rows.slot[: rows.count]) == set(kept[gaps[kept] < margin]) | {farthest}


@pytest.mark.parametrize("strict", [False, True])
def test_allow_motion_holds_the_motion_less_what_may_still_close(strict: bool) -> None:
    """Against dense products: G (predicted - current) - allowed, allowed = -gap, or the least of it, the last step's
    closing and zero."""
    at, draw, dt = curved(), np.random.default_rng(4), 0.3
    pair, memory = pair_of(MortarP1(), at, friction=True)
    rows = allocate_rows(pair.slots, 64, True)
    end = PairGradients(pair).append_rows(rows, 0, np.inf, np.zeros((2, pair.slots)), memory)
    assert end == rows.start[rows.count]
    np.testing.assert_array_equal(rows.gap[: rows.count], pair.gaps[rows.slot[: rows.count], 0])
    gap, n = rows.gap[: rows.count].copy(), rows.count
    current, predicted, velocity = (
        at.nodes,
        at.nodes + draw.normal(size=at.nodes.shape),
        draw.normal(size=at.nodes.shape),
    )
    kernels.allow_motion(1, n, rows.packed.address, current, predicted, velocity, dt, strict)
    normal, tangent = (dense(rows, w, len(at.nodes)) for w in (rows.normal_weight, rows.tangent_weight))
    allowed = -gap
    if strict:
        allowed = np.minimum(np.minimum(allowed, -dt * (normal * velocity).sum(axis=(1, 2))), 0.0)
    moved = (normal * (predicted - current)).sum(axis=(1, 2))
    np.testing.assert_allclose(rows.gap[1:n], (moved - allowed)[1:], atol=1e-12)
    assert rows.gap[0] == gap[0]
    np.testing.assert_allclose(rows.offset[1:n], (gap - (normal * current).sum(axis=(1, 2)))[1:], atol=1e-12)
    slid = (tangent * (predicted - current)).sum(axis=(1, 2))
    np.testing.assert_allclose(rows.slip[1:n], slid[1:], atol=1e-12)


def test_from_derivatives_are_the_dense_sums_of_each_entry() -> None:
    draw, count, k = np.random.default_rng(5), 6, 4
    slave, master, multiplier = (draw.integers(0, size, (count, 2)).astype(np.int32) for size in (5, 6, k))
    moved = draw.integers(0, 22, count).astype(np.int32)
    dD, dM, dT = draw.normal(size=(3, count, 2, 2))
    owner, r = np.array([0, 1, -1, 1], np.int32), draw.normal(size=(k, 2))
    x, y = draw.normal(size=(5, 2)), draw.normal(size=(6, 2))
    out = np.zeros((count, 2), np.int32), np.zeros((count, 1), np.int32), np.full((count, 2, 2, 1, 2), np.nan)
    changes = slave, multiplier, master, moved, dD, dM, dT
    assert kernels.from_derivatives(count, changes, owner, (x, y), r, out) == count
    np.testing.assert_array_equal(out[0], multiplier)
    np.testing.assert_array_equal(out[1][:, 0], moved // 2)
    seen = np.where(owner[:, None] >= 0, r[owner], 0.0)
    for e in range(count):
        gap = dD[e].T @ x[slave[e]] - dM[e].T @ y[master[e]] - dT[e].T @ seen[multiplier[e]]
        np.testing.assert_allclose(out[2][e, :, :, 0, moved[e] % 2], gap, atol=1e-14)
        np.testing.assert_array_equal(out[2][e, :, :, 0, 1 - moved[e] % 2], 0.0)
