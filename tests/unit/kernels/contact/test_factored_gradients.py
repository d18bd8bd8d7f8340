"""Rows of consistent forces before their coupling is inverted: against central differences, dense products and laws."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from contactlab_dynamics.forward_increment import ForwardIncrement
from contactlab_mortar.mortar import MortarP0, MortarP1
from surfaces import central_differences

from contactlab.api import FactoredGradients, Floats
from contactlab.contact.gradients import ModelGradients
from contactlab.kernels.contact import factored_gradients as kernels
from contactlab.testing.surfaces import Chains, flat, pair_of

BOTH = pytest.mark.parametrize("algorithm", [MortarP0(), MortarP1()], ids=["P0", "P1"])


def rough(full: bool = True) -> Chains:
    """Surfaces with nodes off by some hundredths of a segment, but for those that an end of the slave sees.

    An end that leans against the master is pressed along the master's normal, and these rows are for averaged ones.
    """
    at = flat(full=full)
    x = at.nodes[at.slave.nodes, 0]
    inner = np.minimum(at.nodes[:, 0] - x.min(), x.max() - at.nodes[:, 0]) > 0.8
    off = np.random.default_rng(7).normal(scale=0.01, size=at.nodes.shape)
    return at.moved(at.nodes + np.where(inner[:, None], off, 0.0))


def written(algorithm: Any, at: Chains) -> tuple[Any, ModelGradients, Floats]:
    """A pair, its factored rows, and the algorithm's memory."""
    pair, memory = pair_of(algorithm, at)
    model = ModelGradients([pair], len(at.nodes))
    assert model.assemble([memory])
    return pair, model, memory


def dense(rows: FactoredGradients, nodes: int) -> Floats:
    """The rows (k, N, 2), written out from what the table says."""
    f, count = rows.factors, rows.factors.count
    B, angles, own = np.zeros((count, 2, nodes, 2)), np.zeros((rows.used[1], nodes, 2)), np.zeros((count, 2, nodes, 2))
    for a in range(rows.used[1]):
        for end, sign in zip(rows.nodes[rows.ends[a]], (-1.0, 1.0), strict=True):
            angles[a, end] += sign * rows.turn[a]
    for i in range(count):
        for z in range(f.start[i], f.start[i + 1]):
            B[i, :, rows.nodes[f.node[z]], :] += rows.block[z]
        for z in range(rows.angle_start[i], rows.angle_start[i + 1]):
            B[i] += rows.lever[z][:, None, None] * angles[rows.angle[z]]
        if f.own[i] >= 0:
            own[i, :, rows.nodes[f.own[i]], :] = np.eye(2)
    lower, upper = np.eye(count), np.zeros((count, count))
    for i in range(count):
        upper[i, i] = 1.0 / f.inverse[i]
        if i:
            upper[i - 1, i], lower[i, i - 1] = f.above[i], f.below[i] * f.inverse[i - 1]
    G = np.einsum("ic,icnd->ind", f.normal[:count], own + np.tensordot(np.linalg.inv((lower @ upper).T), B, 1))
    return np.asarray(G + rows.spin[:count, None, None] * angles[rows.own_angle[:count]])


@BOTH
def test_write_gradients_gives_central_differences_of_gaps(algorithm: Any) -> None:
    """Of a slave that moves as a rigid body on a master that moves in any way: nothing is left out then."""
    at = rough()
    pair, model, memory = written(algorithm, at)
    rows, draw = model.rows, np.random.default_rng(3)
    move, slave = draw.normal(size=at.nodes.shape), at.slave.nodes
    arm = at.nodes[slave] - at.nodes[slave].mean(axis=0)
    move[slave] = draw.normal(size=2) + draw.normal() * np.stack([-arm[:, 1], arm[:, 0]], axis=1)
    slots = rows.factors.slot[: rows.factors.count].copy()
    found = (dense(rows, len(at.nodes)) * move).sum(axis=(1, 2))
    expected = central_differences(pair, memory, at.nodes, move, slots)
    assert np.abs(expected).max() > 1.0
    np.testing.assert_allclose(found, expected, atol=1e-8)


@BOTH
@pytest.mark.parametrize("full", [True, False], ids=["covered", "partly covered"])
def test_write_gradients_gives_rows_without_resultant_and_moment(algorithm: Any, full: bool) -> None:
    at = rough(full)
    _, model, _ = written(algorithm, at)
    force = dense(model.rows, len(at.nodes))
    assert np.abs(force).max() > 0.5
    assert np.abs(force.sum(axis=1)).max() < 1e-14  # round-off of numbers of size one
    moment = (at.nodes[:, 0] * force[..., 1] - at.nodes[:, 1] * force[..., 0]).sum(axis=1)
    assert np.abs(moment).max() < 1e-14


def test_write_gradients_is_asked_again_with_more_room() -> None:
    at = rough()
    _, model, memory = written(MortarP1(), at)
    expected = dense(model.rows, len(at.nodes))
    model.rows = model._room(1)
    assert model.assemble([memory])
    np.testing.assert_array_equal(dense(model.rows, len(at.nodes)), expected)


@BOTH
def test_allow_factored_motion_and_the_solve_hold_complementarity(algorithm: Any) -> None:
    """Gaps less the motion that is allowed, against dense products; then the forces that hold them."""
    at, draw, last_dt = rough(), np.random.default_rng(4), 0.3
    _, model, _ = written(algorithm, at)
    rows, count, N = model.rows, model.rows.factors.count, len(at.nodes)
    G, gap = dense(rows, N).reshape(count, -1), rows.factors.gap[: model.rows.factors.count].copy()
    predicted, velocity = at.nodes + 0.05 * draw.normal(size=(N, 2)), draw.normal(size=(N, 2))
    kernels.allow_factored_motion(count, rows.packed.address, at.nodes, predicted, velocity, last_dt)
    allowed = np.minimum(np.minimum(-gap, -last_dt * G @ velocity.ravel()), 0.0)
    left = G @ (predicted - at.nodes).ravel() - allowed
    np.testing.assert_allclose(rows.factors.gap[:count], left, atol=1e-13)
    compliance, multipliers, force = draw.uniform(0.5, 2.0, (N, 2)), np.zeros((1, 20)), np.zeros((N, 2))
    solve = ForwardIncrement().solve_gradients(rows, compliance, multipliers, force)
    assert solve is not None
    y = multipliers[0, rows.factors.slot[:count]]
    np.testing.assert_allclose(force.ravel(), G.T @ y, atol=1e-12)
    end = left + G @ (compliance * force).ravel()
    assert (y > 0.0).any()
    assert (y == 0.0).any()
    assert y.min() >= 0.0
    # the tolerance of the enforcement, in segments of size one
    np.testing.assert_allclose(np.minimum(end, y), 0.0, atol=1e-9)
    np.testing.assert_allclose(rows.factors.left[:count], end + allowed + gap, atol=1e-9)
