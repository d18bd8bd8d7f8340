"""Disc on block (Baillet & Sassi 2005, test 1), frictionless: forces, pressures, symmetry, swap of slave and master.

At depth 0.01 mm against an independent high-order code, at the paper's 0.1581 mm against the project's own finer runs.
What a fine mesh shows does not depend on how the equilibrium is found: the finest runs are statics, but for one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from tiers import some

from contactlab.model.build import build
from contactlab.scene.scene import load_scene
from contactlab.studies import measures
from contactlab.studies.profile import Profile, integral
from contactlab.studies.reference import Reference, load_reference

SHALLOW, DEEP = -0.01, -0.1581
MORTARS = ["mortar-p0", "mortar-p1"]
EACH = [(algorithm, swap) for algorithm in MORTARS for swap in (False, True)]
NODES = [("node-on-segment", False), ("node-on-segment", True)]
EXPLICIT = {SHALLOW: ("mortar-p1", True), DEEP: ("mortar-p0", False)}
"""Explicit runs that every tier makes, for all tests that look at one; pairs of runs to be compared are statics."""
Runs = Callable[..., Any]


def keys(depth: float, level: int, algorithm: str, swap: bool) -> dict[str, Any]:
    return {
        "level": level,
        "supports.1.uy.to": depth,
        "contacts.0.algorithm": algorithm,
        "contacts.0.swap": swap,
    }


def still(depth: float, level: int, algorithm: str, swap: bool, steps: int = 1) -> dict[str, Any]:
    """Of statics."""
    return keys(depth, level, algorithm, swap) | {"integrator": {"use": "newton", "steps": steps}}


def profile(run: Any) -> Profile:
    return Profile.of_curve(run.curve)


def error(run: Any, reference: Reference) -> float:
    return measures.pressure_error(profile(run), reference.profile, reference.window)


def asymmetry(runs: Runs, *changes: dict[str, Any]) -> float:
    """S of two runs, on the multiplier as a function of the deformed position."""
    return measures.mutual_difference(*(profile(runs(one)) for one in changes))


def both(make: Callable[..., dict[str, Any]], depth: float, level: int, algorithm: str, **more: int) -> Any:
    """Changes of a run and of the one with slave and master exchanged."""
    return [make(depth, level, algorithm, swap, **more) for swap in (False, True)]


# --- depth 0.01 mm ----------------------------------------------------------------------------------


def check_shallow(run: Any, force: float, pressure: float) -> None:
    reference = load_reference("disc-on-block-shallow-other-code")
    assert run.status == "finished", run.summary["reason"]
    assert reference.scalar("reaction") == 60.321
    assert run.reaction("block.bottom")[1] == pytest.approx(60.321, rel=force)
    assert run.reaction("disc.top")[1] == pytest.approx(-60.321, rel=force)
    assert error(run, reference) <= pressure


@pytest.mark.parametrize(("algorithm", "swap"), some(EACH, [EXPLICIT[SHALLOW]]))
def test_shallow_on_few_cells(runs: Runs, algorithm: str, swap: bool) -> None:
    """The half width of contact, 0.1 mm, is three or four cells; twice the bounds of half the cells, or less."""
    check_shallow(runs(keys(SHALLOW, 2, algorithm, swap)), 0.006, 0.09)


@pytest.mark.parametrize(
    ("make", "algorithm", "swap"),
    [(still, algorithm, swap) for algorithm in MORTARS for swap in (False, True)]
    + [pytest.param(keys, "mortar-p1", False, marks=pytest.mark.full)],
)
def test_shallow(runs: Runs, make: Callable[..., dict[str, Any]], algorithm: str, swap: bool) -> None:
    """Force within 0.3 % and pressure within 5 %: six cells over the half width of contact."""
    check_shallow(runs(make(SHALLOW, 4, algorithm, swap)), 0.003, 0.05)


@pytest.mark.parametrize(
    ("algorithm", "make"), [("mortar-p0", still), pytest.param("mortar-p1", keys, marks=pytest.mark.full)]
)
def test_shallow_converges(runs: Runs, algorithm: str, make: Callable[..., dict[str, Any]]) -> None:
    """Halving the cells takes a third or more off the pressure error and half off the force error."""
    reference = load_reference("disc-on-block-shallow-other-code")
    coarse, fine = (runs(make(SHALLOW, level, algorithm, False)) for level in (2, 4))
    assert error(fine, reference) < 0.67 * error(coarse, reference)
    forces = [abs(run.reaction("block.bottom")[1] - 60.321) for run in (coarse, fine)]
    assert forces[1] < 0.5 * forces[0]


@pytest.mark.parametrize("algorithm", MORTARS)
def test_shallow_swap(runs: Runs, algorithm: str) -> None:
    assert asymmetry(runs, *both(still, SHALLOW, 4, algorithm)) < 0.03


# --- the paper's depth ------------------------------------------------------------------------------


@pytest.mark.parametrize(("algorithm", "swap"), some(EACH, [EXPLICIT[DEEP]]))
def test_deep(runs: Runs, algorithm: str, swap: bool) -> None:
    run = runs(keys(DEEP, 2, algorithm, swap))
    assert run.status == "finished", run.summary["reason"]
    assert error(run, load_reference("disc-on-block-deep")) <= 0.03
    sideways, upwards = run.reaction("block.bottom")
    assert abs(sideways) < 1e-6 * upwards
    assert abs(run.summary["contacts"]["contacts.0"]["resultant"][0]) < 1e-6 * upwards
    # settled: one side's force is the other's (the criterion of the run itself)
    assert upwards == pytest.approx(-run.reaction("disc.top")[1], rel=5e-4)


STILL: dict[str, int] = {"steps": 2}
WAYS: list[tuple[Callable[..., dict[str, Any]], int, dict[str, int]]] = [
    (still, 2, STILL),
    (still, 3, STILL),
    (keys, 2, {}),
]


@pytest.mark.parametrize("algorithm", MORTARS)
@pytest.mark.parametrize(
    ("make", "level", "more"), [WAYS[0], *(pytest.param(*w, marks=pytest.mark.full) for w in WAYS[1:])]
)
def test_deep_swap(
    runs: Runs, algorithm: str, make: Callable[..., dict[str, Any]], level: int, more: dict[str, int]
) -> None:
    assert asymmetry(runs, *both(make, DEEP, level, algorithm, **more)) <= 0.012


@pytest.mark.parametrize("swap", [False, True])
def test_both_multipliers_give_the_same_force(runs: Runs, swap: bool) -> None:
    """P0 and P1 differ by their weights alone, which a smooth pressure hardly sees."""
    forces = [runs(still(DEEP, 2, algorithm, swap, **STILL)).reaction("block.bottom")[1] for algorithm in MORTARS]
    assert forces[0] == pytest.approx(forces[1], rel=2e-3)


@pytest.mark.parametrize("algorithm", MORTARS)
def test_the_choice_of_slave_hardly_changes_the_force(runs: Runs, algorithm: str) -> None:
    """0.5 % is the usual allowance; at this depth the force is set by the block, not by the interface."""
    forces = [runs(still(DEEP, 2, algorithm, swap, **STILL)).reaction("block.bottom")[1] for swap in (False, True)]
    assert forces[0] == pytest.approx(forces[1], rel=5e-3)


def test_node_on_segment_is_asymmetric_or_does_not_finish(runs: Runs) -> None:
    """The defect that mortar contact is for: exchange of slave and master matters five times as much, or more."""
    found = [runs(changes) for changes in both(keys, DEEP, 2, "node-on-segment")]
    for run in found:
        assert run.status == "finished" or len(run.summary["reason"]) > 40
    if all(run.status == "finished" for run in found):
        worst = max(asymmetry(runs, *both(still, DEEP, 2, algorithm, **STILL)) for algorithm in MORTARS)
        assert measures.mutual_difference(*map(profile, found)) > 5.0 * worst


COARSE = {"bodies.disc.mesh.cells": [8, 2], "bodies.block.mesh.cells": [12, 2]}


def test_the_way_and_the_end_alone_agree(runs: Runs) -> None:
    """What `end = "auto"` chooses without a history is slow enough: the whole way gives the same pressure at the end.

    What settled means bounds both: 2e-4 of the reactions, and less of the pressure.
    """
    changes = keys(DEEP, 1, "mortar-p0", False) | COARSE
    end, way = runs(changes), runs(changes | {"time.history": True}, auto=True)
    assert (end.status, way.status) == ("finished", "finished")
    assert (end.summary["history"]["curve"], way.summary["history"]["curve"]) == ("the end only", "quasi-static")
    assert measures.mutual_difference(profile(end), profile(way)) < 1e-4
    assert way.summary["steps"] > 5 * end.summary["steps"]
    for run, periods in ((end, 6.0), (way, 100.0)):
        ramp, period = (run.summary["resolved"][key] for key in ("ramp", "period"))
        assert ramp == pytest.approx(periods * period)


# --- what must hold in any of these runs ------------------------------------------------------------


CASES = some(
    [(depth, *one) for depth in (SHALLOW, DEEP) for one in EACH], [(depth, *one) for depth, one in EXPLICIT.items()]
)


@pytest.mark.parametrize(("depth", "algorithm", "swap"), CASES)
def test_contact_conditions_hold(runs: Runs, depth: float, algorithm: str, swap: bool) -> None:
    """The weak cone to round-off; gaps of pressed nodes to the tolerance of the sweeps, 1e-10 segment lengths."""
    contact = runs(keys(depth, 2, algorithm, swap)).summary["contacts"]["contacts.0"]
    assert contact["cone_violation"] <= 1e-12
    assert contact["complementarity"] < 1e-9
    assert contact["max_penetration"] < 0.01 * 1.6 / 48  # of a segment, between the nodes
    assert -0.1 < contact["most_negative"] <= 0.0  # the edge of contact: allowed and small


@pytest.mark.parametrize(("depth", "algorithm", "swap"), CASES)
def test_pressure_is_symmetric_and_carries_the_force(runs: Runs, depth: float, algorithm: str, swap: bool) -> None:
    run = runs(keys(depth, 2, algorithm, swap))
    assert measures.mirror_asymmetry(profile(run)) < 1e-6
    upwards = run.reaction("block.bottom")[1]
    assert integral(profile(run)) == pytest.approx(upwards, rel=2e-3)  # linear interpolants of P0 pressures too
    assert np.all(run.curve.nodal_pressure >= 0.0)


@pytest.mark.parametrize(("depth", "algorithm", "swap"), CASES)
def test_run_was_quasi_static_and_its_ledger_closes(runs: Runs, depth: float, algorithm: str, swap: bool) -> None:
    balance = runs(keys(depth, 2, algorithm, swap)).summary["balance"]
    assert balance["kinetic"] < 1e-3 * balance["internal"]
    assert balance["ledger_error"] < 1e-9
    # booked and stored energy belong to times half a step apart, at rest the same
    assert balance["stored_against_work"] < 1e-4
    assert balance["friction"] == 0.0
    assert balance["numerical"] == 0.0


@pytest.mark.parametrize(
    ("algorithm", "swap"), some([*EACH, *NODES], [("mortar-p1", True), ("node-on-segment", False)])
)
def test_forces_on_both_bodies_cancel_in_every_step(algorithm: str, swap: bool) -> None:
    """While the surfaces curve, slide and partly cover each other: linear momentum is exact."""
    scene = load_scene("disc-on-block").with_(keys(DEEP, 1, algorithm, swap) | {"time.ramp": 2e-6})
    model = build(scene, scene.registry)
    advance, force = model.bound_integrator().step, model.state["contact_force"]
    dt, disc = 0.9 * model.stable_step(), model.bodies[0]
    pressed = 0
    for _ in range(400):
        advance(dt)
        pushed = float(np.abs(force).sum())
        pressed += int(pushed > 1.0)
        # a sum of some hundred numbers of this size
        np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=1e-12 * max(pushed, 1.0))
    assert pressed > 200
    assert force[disc.first : disc.first + disc.count, 1].sum() > 1.0
