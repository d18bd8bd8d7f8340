"""Gap rows written out, their slips, works and forces, against dense products."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from contactlab_mortar.mortar import MortarP1
from surfaces import dense_rows

from contactlab.api import Floats
from contactlab.contact.explicit_system import allocate_rows
from contactlab.kernels.contact import rows as kernels
from contactlab.testing.surfaces import curved, dense, pair_of

ROUND_OFF = 1e-13  # of numbers near one


@pytest.fixture(scope="module")
def pair() -> Any:
    """A pair of curved surfaces that rubs, at its positions."""
    found, memory = pair_of(MortarP1(), curved(), friction=True)
    found.compute_start_normals(curved().nodes, memory)
    found.weights()
    return found


def operators(pair: Any) -> tuple[Floats, Floats]:
    """Normal and tangential weights (k, N, 2) of the kept multipliers, from the dense rows of both sides."""
    weights, nodes = pair.weights(), curved().nodes
    scalar = np.zeros((pair.slots, len(nodes)))
    scalar[:, pair.slave.nodes] += dense_rows(weights.slave, len(pair.slave.nodes))
    scalar[:, pair.master.nodes] -= dense_rows(weights.master, len(pair.master.nodes))
    normal = pair.normals
    tangent = np.stack([normal[:, 1], -normal[:, 0]], axis=1)
    return scalar[:, :, None] * normal[:, None], scalar[:, :, None] * tangent[:, None]


def written(pair: Any, margin: float, multipliers: Floats, room: int = 64) -> Any:
    rows = allocate_rows(pair.slots, room, True)
    address, packed = pair.address, rows.packed.address
    rows.count, _ = kernels.write_rows(address, margin, multipliers, 0, 0, 0, packed)
    return rows


def test_write_rows_gives_weights_gaps_and_lengths_of_their_multipliers(pair: Any) -> None:
    rows, nodes = written(pair, np.inf, np.zeros((2, pair.slots))), len(curved().nodes)
    normal, tangent = operators(pair)
    entries = slice(0, rows.start[rows.count])
    pattern = rows_of(rows)
    np.testing.assert_array_equal(np.sort(rows.slot[: rows.count]), np.sort(pair.coupling.order))
    slot = rows.slot[: rows.count]
    np.testing.assert_allclose(dense(pattern, rows.normal_weight[entries], nodes), normal[slot], atol=ROUND_OFF)
    np.testing.assert_allclose(dense(pattern, rows.tangent_weight[entries], nodes), tangent[slot], atol=ROUND_OFF)
    np.testing.assert_array_equal(rows.gap[: rows.count], pair.gaps[slot, 0])
    np.testing.assert_array_equal(rows.measure[: rows.count], pair.cover[slot])


def rows_of(rows: Any) -> Any:
    from contactlab.api import GapConditions

    k, z = rows.count, rows.start[rows.count]
    none = np.zeros((0, 2))
    return GapConditions(rows.start[: k + 1], rows.node[:z], none, none, rows.gap[:k], rows.measure[:k], rows.slot[:k])


def test_write_rows_leaves_out_open_rows_without_a_force(pair: Any) -> None:
    gaps, kept = pair.gaps[:, 0], pair.coupling.order
    margin = float(np.median(gaps[kept]))
    pressed = np.zeros((2, pair.slots))
    farthest = kept[np.argmax(gaps[kept])]
    pressed[0, farthest] = 1.0
    expected = set(kept[gaps[kept] < margin]) | {farthest}
    rows = written(pair, margin, pressed)
    assert set(rows.slot[: rows.count]) == expected


def test_write_rows_tells_that_rows_do_not_fit(pair: Any) -> None:
    assert written(pair, np.inf, np.zeros((2, pair.slots)), room=1).count == -1


def test_write_slips_is_the_tangent_times_separation_now_minus_at_the_start(pair: Any) -> None:
    rows, draw = written(pair, np.inf, np.zeros((2, pair.slots))), np.random.default_rng(2)
    angle = draw.uniform(0.0, 6.0, pair.slots)
    before = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    current = curved().nodes + draw.normal(size=curved().nodes.shape)
    kernels.write_slips(0, rows.count, 0, (pair.gaps, pair.normals, before), current, rows.packed.address)
    normal, _ = operators(pair)
    separation = np.einsum("kni,ki->kn", normal, pair.normals) @ current
    start = before[:, 1] * separation[:, 0] - before[:, 0] * separation[:, 1]
    slot = rows.slot[: rows.count]
    np.testing.assert_allclose(rows.slip[: rows.count], (pair.gaps[:, 1] - start)[slot], atol=10.0 * ROUND_OFF)


def test_tangential_work_is_force_times_sliding(pair: Any) -> None:
    rows, draw = written(pair, np.inf, np.zeros((2, pair.slots))), np.random.default_rng(3)
    shape = curved().nodes.shape
    multipliers, velocity = draw.uniform(size=(2, pair.slots)), draw.normal(size=shape)
    compliance, force, dt = draw.uniform(size=shape), draw.normal(size=shape), 0.3
    rows.slip[: rows.count] = draw.normal(size=rows.count)
    work, dissipated = kernels.tangential_work(
        rows.count, rows.packed.address, multipliers, velocity, dt, compliance, force
    )
    slot, (_, tangent) = rows.slot[: rows.count], operators(pair)
    y, along = multipliers[1, slot], tangent[slot]
    end = rows.slip[: rows.count] + (along * compliance * force).sum(axis=(1, 2))
    assert work == pytest.approx(dt * float(y @ (along * velocity).sum(axis=(1, 2))), abs=100.0 * ROUND_OFF)
    assert dissipated == pytest.approx(-float(y @ end), abs=100.0 * ROUND_OFF)


def test_add_forces_is_the_transposed_weights_times_multipliers(pair: Any) -> None:
    draw, shape = np.random.default_rng(4), curved().nodes.shape
    multipliers, across, along = draw.uniform(size=(2, pair.slots)), np.zeros(shape), np.zeros(shape)
    kernels.add_forces(pair.address, multipliers, 0, across, along)
    kept, (normal, tangent) = pair.coupling.order, operators(pair)
    np.testing.assert_allclose(across, np.einsum("k,kni->ni", multipliers[0, kept], normal[kept]), atol=ROUND_OFF)
    np.testing.assert_allclose(along, np.einsum("k,kni->ni", multipliers[1, kept], tangent[kept]), atol=ROUND_OFF)


def test_flexibilities_are_what_unit_forces_do_to_their_own_gaps(pair: Any) -> None:
    nodal, out = np.random.default_rng(5).uniform(size=curved().nodes.shape), np.zeros(pair.slots)
    kernels.flexibilities(pair.address, nodal, out)
    normal, _ = operators(pair)
    kept = pair.coupling.order
    np.testing.assert_allclose(out[kept], (normal**2 * nodal).sum(axis=(1, 2))[kept], atol=ROUND_OFF)


def test_extrapolate_goes_on_linearly_where_forces_pressed_twice_and_never_pulls() -> None:
    now, before = np.array([3.0, 1.0, 2.0, 0.0, 1.0]), np.array([2.0, 3.0, 0.0, 1.0, 1.0])
    last = now.copy()
    kernels.extrapolate(now, before)
    np.testing.assert_array_equal(now, [4.0, 0.0, 2.0, 0.0, 1.0])
    np.testing.assert_array_equal(before, last)
