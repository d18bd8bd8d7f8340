"""Forging of three plastic bodies: mortars go through, nodes on segments let the billet in between their nodes."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import contactlab
from contactlab.api import Floats, Ints
from contactlab.results.results import Results

MORTAR = pytest.mark.parametrize("algorithm", ["mortar-p0", "mortar-p1"])
SEGMENT = 1.0  # mm, of the tools


@cache
def run(algorithm: str) -> Results:
    scene = contactlab.load_scene("three-body-forging")
    changes = {f"contacts.{number}.algorithm": algorithm for number in range(3)}
    return contactlab.simulate(scene.with_(changes | {"record.frames": 50}))


def area(x: Floats, cells: Ints) -> float:
    """Of quadrilaterals, by their diagonals."""
    a, b, c, d = (x[cells[:, i]] for i in range(4))
    p, q = c - a, d - b
    return float(0.5 * (p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]).sum())


@MORTAR
def test_mortars_reach_the_end(algorithm: str) -> None:
    """Top and floor within 1 %, volume kept, and no deeper than load steps of the same rows, 0.075 of a segment:
    weak conditions hold in the mean, and the billet has nodes between those of the anvil.
    """
    results = run(algorithm)
    assert results.status == "finished", results.reason
    # where a further node of the tools comes to bear, the force rises by a tenth within some periods
    assert {warning.code for warning in results.warnings} == {"unbalanced-reactions"}
    for contact in results.summary["contacts"].values():
        assert contact["max_penetration"] < 0.08 * SEGMENT
        assert contact["cone_violation"] <= 1e-10 * contact["max_pressure"]
    top, floor = (results.summary["reactions"][name][1] for name in ("punch.top", "floor"))
    assert floor == pytest.approx(-top, rel=0.01)
    balance = results.summary["balance"]
    assert balance["ledger_error"] < 1e-6
    assert balance["kinetic"] < 1e-3 * balance["internal"]  # slow enough to be a forging, not an impact
    deformed = results.nodes + results.displacement
    for name in ("anvil", "billet", "punch"):
        cells = results.cells[name]
        assert area(deformed, cells) == pytest.approx(area(results.nodes, cells), rel=0.01)


def test_all_bodies_flow_and_the_anvil_lifts_off() -> None:
    """The billet and the anvil below it, the punch nearly not; the anvil's ends leave the floor."""
    results = run("mortar-p0")
    assert results.status == "finished", results.reason
    strain = {name: values["equivalent_plastic_strain"].max() for name, values in results.internal_variables.items()}
    assert strain["billet"] > 0.3
    assert strain["anvil"] > 0.3  # under the billet's corners it flows as much: newton gives 0.335 and 0.347
    assert strain["punch"] < 0.01
    gap = np.asarray(results.contact["anvil-on-floor"].last.gap)
    assert min(gap[0], gap[-1]) > 0.1


def test_both_mortars_need_the_same_force() -> None:
    """Within 0.5 %, as the resultants of P0 and P1 do where surfaces are curved."""
    forces = [run(algorithm).summary["reactions"]["floor"][1] for algorithm in ("mortar-p0", "mortar-p1")]
    assert forces[0] == pytest.approx(forces[1], rel=0.005)


def test_nodes_on_segments_diverge_and_keep_what_they_have() -> None:
    """The run stops early, says which body and why, and keeps the frames before."""
    results = run("node-on-segment")
    assert results.status == "diverged"
    assert "step" in results.reason
    assert "body" in results.reason
    assert results.history["time"][-1] < 0.2 * results.summary["resolved"]["ramp"]
    assert len(results.contact["billet-on-anvil"].curves) >= 1
