"""Contact forces that are consistent with the gaps: their directions, and that they make no energy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from contactlab_mortar.mortar import MortarP0, MortarP1
from contactlab_segments.node_on_segment import NodeOnSegment
from tiers import some

import contactlab
from contactlab.api import ContactAlgorithm, Floats, Rows
from contactlab.contact.gradients import PairGradients
from contactlab.contact.operator_pair import OperatorPair
from contactlab.model.build import build
from contactlab.testing.surfaces import Chains, chains, curved, flat, pair_of

P0, P1, NODES = MortarP0(), MortarP1(), NodeOnSegment()
CONSISTENT = {"use": "forward-increment", "forces": "consistent"}
FROZEN = {"use": "forward-increment", "forces": "frozen"}


def rough(at: Chains) -> Chains:
    """The same surfaces with every node off by some hundredths of a segment: no symmetry, no plane left."""
    shake = np.random.default_rng(7).normal(scale=0.01, size=at.nodes.shape)
    return Chains(at.nodes + shake, at.slave, at.master)


SURFACES = {
    "curved": rough(curved()),
    "partly covered": rough(flat(full=False)),
    "quadratic": rough(flat(order=2)),
    "quadratic, partly covered": rough(flat(full=False, order=2)),
}
VALLEY = chains(np.array([[0.6, 0.1], [1.0, -0.03], [1.4, 0.1]]), np.array([[-0.1, 0.05], [1.0004, 0.0], [2.0, 0.07]]))
"""A node of the slave below a concave vertex, where it projects onto neither segment: the normal is between theirs."""
EVERY = [
    pytest.param(algorithm, at, id=f"{name}, {kind}")
    for name, at in SURFACES.items()
    for kind, algorithm in (("P0", P0), ("P1", P1), ("nodes", NODES))
    if not (kind == "nodes" and "quadratic" in name)
] + [pytest.param(NODES, VALLEY, id="valley, nodes")]


def derivatives(pair: OperatorPair, memory: Floats, nodes: int) -> tuple[Floats, Floats]:
    """Rows (k, 2 N) of gaps and of slips."""
    rows = Rows.allocate(pair.slots, 4 * nodes, friction=True)
    assert PairGradients(pair).append_rows(rows, 0, np.inf, np.zeros((2, pair.slots)), memory) > 0
    row = np.repeat(np.arange(rows.count), np.diff(rows.start[: rows.count + 1]))
    found = []
    for weight in (rows.normal_weight, rows.tangent_weight):
        dense = np.zeros((rows.count, nodes, 2))
        np.add.at(dense, (row, rows.node[: len(row)]), weight[: len(row)])
        found.append(dense.reshape(rows.count, -1))
    return found[0], found[1]


def gaps(pair: OperatorPair, memory: Floats, nodes: Floats) -> Floats:
    pair.update(nodes, memory)
    return np.asarray(pair.gaps[pair.coupling.order, 0].copy())


@pytest.mark.parametrize(("algorithm", "at"), EVERY)
def test_rows_are_derivatives_of_gaps(algorithm: ContactAlgorithm, at: Chains) -> None:
    pair, memory = pair_of(algorithm, at, friction=True)
    row, _ = derivatives(pair, memory, len(at.nodes))
    move, h = np.random.default_rng(3).normal(scale=0.01, size=at.nodes.shape), 1e-4
    at_steps = [gaps(pair, memory, at.nodes + k * h * move) for k in (1, -1, 2, -2)]
    change = (8.0 * (at_steps[0] - at_steps[1]) - (at_steps[2] - at_steps[3])) / (12.0 * h)
    # they err by h^4 times a fifth derivative, which is large where normals of ends turn, and by round-off over h
    assert np.allclose(row @ move.ravel(), change, rtol=0.0, atol=1e-9 * np.abs(change).max() + 1e-10)


@pytest.mark.parametrize(("algorithm", "at"), EVERY)
def test_forces_have_no_resultant_and_no_moment(algorithm: ContactAlgorithm, at: Chains) -> None:
    pair, memory = pair_of(algorithm, at, friction=True)
    # nodes beside vertices fall back on differences over 1e-5 of a segment
    exact = 1e-10 if algorithm is NODES else 1e-12
    for rows in derivatives(pair, memory, len(at.nodes)):
        force = rows.reshape(len(rows), -1, 2)
        assert np.abs(force.sum(axis=1)).max() < exact
        moment = (at.nodes[:, 0] * force[..., 1] - at.nodes[:, 1] * force[..., 0]).sum(axis=1)
        assert np.abs(moment).max() < exact


def run(changes: dict[str, Any], name: str = "disc-on-block", forces: dict[str, str] = CONSISTENT) -> Any:
    scene = contactlab.load_scene(name).with_({"contacts.0.enforcement": forces, **changes})
    return contactlab.simulate(scene)


def test_disc_on_a_finer_block_carries_its_load() -> None:
    # the master's segments are 2.75 times shorter than the slave's; statics with the same forces: 3899.28 N
    results = run({"bodies.block.mesh.cells": [72, 12]})
    assert results.status == "finished"
    assert not [w for w in results.warnings if w.code == "contact-energy"]
    contact = results.history["energy.contact"]
    stored = results.summary["balance"]["stored"]
    assert contact.max() < 1e-9 * stored
    assert np.diff(contact).max() < 1e-9 * stored
    # the rest is what a run that ends as settled may still swing
    assert abs(results.summary["reactions"]["block.bottom"][1] / 3899.28 - 1.0) < 2e-4


CASES = ["dropped-block", "vertex-to-vertex", "bouncing-bar", "spinning-pair"]
BY_TURNS = list(zip(CASES, ["mortar-p0", "mortar-p1", "node-on-segment", "mortar-p1"], strict=True))
EACH = [(name, algorithm) for name in CASES for algorithm in ("mortar-p0", "mortar-p1", "node-on-segment")]


@pytest.mark.parametrize(("name", "algorithm"), some(EACH, BY_TURNS))
def test_no_step_gives_energy(name: str, algorithm: str) -> None:
    scene = contactlab.load_scene(name).with_({"contacts.0.enforcement": CONSISTENT, "contacts.0.algorithm": algorithm})
    model = build(scene, scene.registry)
    advance, dt = model.bound_integrator().step, 0.9 * model.stable_step()
    largest = model.kinetic_energy()
    for _ in range(3000):
        before = model.state["work"][3]
        advance(dt)
        largest = max(largest, model.kinetic_energy())
        # what the contact solve leaves of a gap, 1e-10 segments, times its force
        assert model.state["work"][3] - before < 1e-9 * max(largest, 1e-12)


RAMP = 1.1e-5  # s, some 15 periods: what stays of an overlap at the end does not depend on the pace


def test_an_overlap_that_comes_in_an_instant_and_stays_is_told() -> None:
    """A coarse slave: a segment of the fine master comes within reach at the rim, and gaps jump; the force is short.

    With the finer side as slave nothing jumps, and statics have the same force within 1e-5.
    """
    cells = {"bodies.disc.mesh.cells": [12, 3], "bodies.block.mesh.cells": [68, 11], "time.history": True}
    cells |= {"record.frames": 4}
    told = {}
    for swap in (False, True):
        results = run({**cells, "contacts.0.swap": swap, "time.ramp": RAMP})
        (kept,) = [found for found in results.summary["invariants"] if found["code"] == "kept-overlap"]
        told[swap] = [warning.value for warning in results.warnings if warning.code == "kept-overlap"]
        assert told[swap] == ([kept["value"]] if kept["value"] > kept["limit"] else [])
        gap, pressure = results.contact["contacts.0"].last.gap, results.contact["contacts.0"].last.nodal_pressure
        overlap = float((-gap[pressure > 0.0]).max()) / (1.6 / 12)
        assert (overlap > 5e-3) == bool(told[swap])
    # statics: 3847.2, the run 3833.7, which is 0.35 % less
    assert told[False] == [pytest.approx(0.0038, rel=0.1)]
    assert told[True] == []


def test_energy_that_contact_makes_is_told_and_stops_the_run() -> None:
    # damping as strong as where the way does not matter hides what contact makes
    results = run(
        {"bodies.block.mesh.cells": [72, 12], "time.history": True, "time.ramp": RAMP, "record.frames": 4},
        forces=FROZEN,
    )
    assert results.status == "diverged"
    assert "contact has made" in results.summary["reason"]
    assert 'forces = "consistent"' in results.summary["reason"]
    (warning,) = [w for w in results.warnings if w.code == "contact-energy"]
    assert warning.limit == 0.01
    assert warning.value > 0.1
