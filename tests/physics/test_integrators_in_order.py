"""`integrator = "auto"`: where statics come short, inertia finds the state that is asked for, and the run says why."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import contactlab
from contactlab.results.results import Results
from contactlab.scene.scene import Scene

RISE, HALF, LOAD = 0.5, 5.0, 0.02
SOFT = {"use": "neo-hookean", "young": 1000.0, "poisson": 0.3, "density": 1e-9}
ARCH: dict[str, Any] = {
    "format": 1, "name": "arch", "integrator": "auto",
    "materials": {"soft": SOFT},
    "bodies": {"arch": {"element": "q2", "material": "soft", "mesh": {
        "use": "quad-block", "corners": [[-HALF, -0.1], [HALF, -0.1], [HALF, 0.0], [-HALF, 0.0]],
        "bulge": [-RISE, 0.0, RISE, 0.0], "cells": [8, 1],
    }}},
    "supports": [{"on": f"arch.{side}", "ux": 0.0, "uy": 0.0} for side in ("left", "right")],
    "loads": [{"on": "arch.top", "ty": {"ramp": "linear", "to": -LOAD}}],
    "record": {"frames": 4},
}  # fmt: skip
DYNAMICS = {"use": "implicit-dynamics", "steps": 60}
BLOCK: dict[str, Any] = {
    "format": 1, "name": "block", "integrator": {"use": "auto", "order": ["newton", DYNAMICS, "central-difference"]},
    "materials": {"m": {"use": "linear-elastic", "young": 100.0, "poisson": 0.3, "density": 1e-9}},
    "bodies": {"block": {
        "element": "q1", "material": "m",
        "mesh": {"use": "rectangle", "x": [0.0, 1.0], "y": [0.0, 1.0], "cells": [2, 2]},
    }},
    "rigid": {"floor": {"line": [[5.0, 0.0], [-5.0, 0.0]]}},
    "contacts": [{"slave": "block.bottom", "master": "floor", "algorithm": "mortar-p0"}],
    "loads": [{"on": "block.top", "ty": {"ramp": "linear", "to": -1.0}}],
    "record": {"frames": 4},
}  # fmt: skip
NODES = 9


def run(scene: dict[str, Any], *order: Any, **more: Any) -> Results:
    changes: dict[str, Any] = {"integrator": {"use": "auto", "order": list(order)}} if order else {}
    return contactlab.simulate(Scene.from_data({**scene, **more}).with_(changes))


def tried(found: Results) -> list[tuple[str, str]]:
    return [(one["use"], one["status"]) for one in found.summary["resolved"]["integrator"]["tried"]]


@pytest.mark.parametrize(
    ("statics", "ended"),
    [
        # stabilised: 18 % of the work is viscous; test_stabilised_statics.py has it in every tier
        pytest.param({"use": "newton", "steps": 11}, "finished", marks=pytest.mark.full),
        # given up at a fifth of the load
        ({"use": "newton", "steps": 11, "stabilised": False}, "not-converged"),
    ],
)
def test_an_arch_that_snaps_through_ends_in_its_far_equilibrium(statics: dict[str, Any], ended: str) -> None:
    found = run(ARCH, statics, DYNAMICS)
    assert found.status == "finished"
    assert found.summary["resolved"]["integrator"]["use"] == "implicit-dynamics"
    assert tried(found) == [("newton", ended)]
    (attempt,) = found.summary["resolved"]["integrator"]["tried"]
    # Newton's method that happens to jump finds the same place without viscous forces or inertia; the run is held
    # until kinetic energy is a thousandth of the internal one, so that a hundred-thousandth of the way is left
    other = run(ARCH, {"use": "newton", "steps": 7})
    assert tried(other) == []
    np.testing.assert_allclose(other.displacement, found.displacement, atol=2e-5 * RISE)
    assert found.displacement[:, 1].min() < -1.5 * RISE
    if ended == "finished":
        assert attempt["reason"].startswith("stabilisation took 18")
    else:
        # the load of the limit point, at which the stiffness has no lower bound any more
        assert 0.15 < attempt["reached"]["share"] < 0.25
        assert "snaps through" in attempt["reason"]
    cost = found.summary["cost"]
    assert cost["failed_attempts_s"] == attempt["cpu_s"] > 0.0
    assert cost["run_cpu_s"] > cost["failed_attempts_s"]
    assert [event.text for event in found.events if event.text.startswith("tried before: newton")]


@pytest.mark.parametrize("time", [{}, {"end": 2.0}])
def test_a_scene_that_statics_solve_is_that_of_newton_to_the_last_bit(time: dict[str, float]) -> None:
    """The block is held along x alone, so that with an end in seconds it is asked whether it moves freely."""
    held = {"supports": [{"on": "block.left", "ux": 0.0}], "time": time}
    found, plain = run(BLOCK, **held), run(BLOCK, "newton", **held)
    alone = contactlab.simulate(Scene.from_data({**BLOCK, **held}).with_({"integrator": "newton"}))
    assert tried(found) == []
    for other in (plain, alone):
        np.testing.assert_array_equal(found.displacement, other.displacement)
        np.testing.assert_array_equal(found.stress["block"], other.stress["block"])
        assert found.summary["iterations"] == other.summary["iterations"]
    assert "integrator" not in alone.summary["resolved"]


def test_a_body_that_hangs_free_comes_to_rest_on_the_floor_or_flies_as_it_is_asked() -> None:
    free = {"supports": [{"on": "block.left", "ux": 0.0}]}
    above = {**BLOCK, "bodies": {"block": {**BLOCK["bodies"]["block"], "shift": [0.0, 0.05]}}, **free}
    rest = run(above)
    # a state of rest: uniform stress of -1 in y, uniform strain -(1 - nu^2)/E, free to widen to the right
    assert tried(rest) == []
    assert rest.displacement[:NODES, 1].min() == pytest.approx(-0.05 - (1.0 - 0.3**2) / 100.0, rel=1e-9)
    # a motion: the load grows evenly to F = 1 in t = 2e-6 s, and the centre of mass falls by F t^2 / 6 m
    flight = run(above, time={"end": 2e-6})
    assert flight.summary["resolved"]["integrator"]["use"] == "implicit-dynamics"
    assert tried(flight) == [("newton", "refused")]
    assert "sliding along y" in flight.summary["resolved"]["integrator"]["tried"][0]["reason"]
    weights = np.outer([1.0, 2.0, 1.0], [1.0, 2.0, 1.0]).ravel() / 16.0
    fall = weights @ flight.displacement[:NODES, 1]
    # the trapezoidal rule in 60 steps: F t^2 / 6 m is off by 1 / (2 n^2)
    assert fall == pytest.approx(-(2e-6**2) / 6e-9, rel=1e-3)
    assert [warning.code for warning in flight.warnings] == ["open-contact"]  # a motion was asked for


def test_a_thrown_body_goes_to_dynamics_and_says_why() -> None:
    thrown = {**BLOCK, "bodies": {"block": {**BLOCK["bodies"]["block"], "velocity": [0.0, 10.0]}}, "loads": []}
    found = run(thrown, time={"end": 1e-4})
    assert tried(found) == [("newton", "refused")]
    np.testing.assert_allclose(found.displacement[:NODES, 1], 1e-3, rtol=1e-9)


PULLED = [*BLOCK["loads"], {"on": "block.left", "tx": {"ramp": "linear", "to": 0.25}}]
RUBBING = [{**BLOCK["contacts"][0], "friction": {"use": "coulomb", "mu": 0.2}}]


def test_a_load_that_friction_cannot_hold_is_a_motion_and_told_as_one() -> None:
    """0.25 pulls and 0.2 holds: the rest of 0.05 grows evenly to t = 4e-4 s, so that v = F t/2m and x = F t^2/6m."""
    end = 4e-4
    found = run(
        BLOCK, "newton", {"use": "implicit-dynamics", "steps": 50}, loads=PULLED, contacts=RUBBING, time={"end": end}
    )
    assert found.status == "finished"
    assert tried(found) == [("newton", "not-converged")]
    assert "friction" in found.summary["resolved"]["integrator"]["tried"][0]["reason"]
    # 1 %: the block shears by 0.25/G = 0.7 % of its height, and vibrates by as much
    assert found.velocity[:NODES, 0].mean() == pytest.approx(0.05e9 * end / 2.0, rel=0.01)
    assert found.displacement[:NODES, 0].mean() == pytest.approx(0.05e9 * end**2 / 6.0, rel=0.01)
    (warning,) = [warning for warning in found.warnings if warning.code == "not-at-rest"]
    balance = found.summary["balance"]
    assert warning.value == pytest.approx(balance["kinetic"] / balance["external"], rel=1e-9)


@pytest.mark.full
def test_a_state_of_rest_that_there_is_none_of_is_reported_with_every_reason() -> None:
    """Explicit steps get furthest; the floor ends under the block that slides on it."""
    found = run(BLOCK, "newton", "central-difference", loads=PULLED, contacts=RUBBING)
    assert found.status in ("not-converged", "diverged")
    assert tried(found) == [("newton", "not-converged")]
    assert found.summary["resolved"]["integrator"]["use"] == "central-difference"
    assert found.reason.startswith("central-difference, which got furthest: ")
    assert "newton not-converged: stopped at 0 % of the load" in found.reason
    assert found.summary["steps"] > 0
