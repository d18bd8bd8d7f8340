"""Friction laws that follow the rate of slip and remember, against closed forms; restart and rejected steps.

The laws are those of tests/outside/rate-friction.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

import contactlab
from contactlab.api import StepStatus
from contactlab.model.build import build
from contactlab.parts.registry import Registry
from contactlab.scene.scene import Scene

LAWS = Path(__file__).parents[1] / "outside" / "rate-friction" / "src" / "rate_friction" / "laws.py"
REGISTRY = Registry(files=[LAWS])
ALGORITHMS = pytest.mark.parametrize("algorithm", ["node-on-segment", "mortar-p1"])
STRIBECK = {"use": "stribeck", "static": 0.5, "kinetic": 0.3, "speed": 20.0}
BULK = {"use": "bulk", "mu": 0.3, "shear": 50.0}
DIETERICH = {"use": "rate-and-state", "mu": 0.4, "a": 0.02, "b": 0.03, "length": 1.0, "speed": 1.0}


def drawn(friction: dict[str, Any], rates: tuple[float, float], end: float, steps: int, algorithm: str) -> Any:
    """Coefficients over time of a block that is pressed and drawn over a floor at one rate, and then at another."""
    first, second = rates
    points = [[0.0, 0.0], [0.5 * end, 0.5 * end * first], [end, 0.5 * end * (first + second)]]
    scene = Scene.from_data(
        {
            "time": {"end": end},
            "integrator": {"use": "newton", "steps": steps},
            "materials": {"m": {"use": "linear-elastic", "young": 1000.0, "poisson": 0.0, "density": 1e-9}},
            "bodies": {
                "b": {
                    "element": "q1", "material": "m",
                    "mesh": {"use": "rectangle", "x": [0.0, 1.0], "y": [0.0, 0.5], "cells": [2, 1]},
                }
            },
            "rigid": {"floor": {"line": [[50.0, 0.0], [-50.0, 0.0]]}},
            "contacts": [{"slave": "b.bottom", "master": "floor", "algorithm": algorithm, "friction": friction}],
            "supports": [{"on": "b.top", "ux": {"ramp": "table", "to": 1.0, "points": points}}],
            "loads": [{"on": "b.top", "ty": {"ramp": "constant", "to": -2.0}}],
            "record": {"frames": steps},
        },
        registry=REGISTRY,
    )  # fmt: skip
    results = contactlab.simulate(scene)
    assert results.status == "finished", results.reason
    history = {name: values[1:] for name, values in results.history.items()}  # without the start
    return history["time"] / end, -history["contacts.0.fx"] / history["contacts.0.fy"]


@ALGORITHMS
def test_a_steady_slip_has_the_coefficient_of_its_rate(algorithm: str) -> None:
    """Stribeck's curve at two rates; 1e-4 is ten times what bounds may still change by when a step has converged."""
    time, found = drawn(STRIBECK, (10.0, 100.0), 0.02, 40, algorithm)
    for place, rate in ((0.5, 10.0), (1.0, 100.0)):
        assert np.interp(place, time, found) == pytest.approx(0.3 + 0.2 * np.exp(-rate / 20.0), abs=1e-4)


def test_a_step_of_the_rate_has_a_direct_effect_and_an_evolution() -> None:
    """mu + a ln(v/v0) at once, from where b ln(theta v0/L) leads to a new steady slip within some lengths L.

    Contacts are as old as at the start of a step: the error halves with the steps.
    """
    errors = []
    for steps in (25, 50):
        time, found = drawn(DIETERICH, (1.0, 5.0), 2.0, steps, "mortar-p1")
        assert np.interp(0.45, time, found) == pytest.approx(0.4, abs=1e-4)  # exp(-0.9) of what the start left
        after = time > 0.5 * (1.0 + 1e-9)
        slid = 5.0 * (2.0 * time[after] - 1.0)
        age = 0.2 + 0.8 * np.exp(-slid)
        errors.append(np.abs(found[after] - 0.4 - 0.02 * np.log(5.0) - 0.03 * np.log(age)).max())
        assert found.max() > 0.4 + 0.5 * 0.02 * np.log(5.0)
        assert found[-1] == pytest.approx(0.4 - 0.01 * np.log(5.0), abs=1e-3)
    assert errors[1] < 0.6 * errors[0]
    assert errors[1] < 3e-3


def test_a_share_of_the_stress_behind_is_drawn_along() -> None:
    """Rubbed from the second step on, as the first begins without stress; each step turns shares of shear by 4e-3."""
    _, found = drawn(BULK, (10.0, 100.0), 0.02, 8, "mortar-p1")
    assert found[0] == pytest.approx(0.0, abs=1e-12)
    assert found[-1] == pytest.approx(0.3, rel=1e-8)


def sliding(integrator: dict[str, Any], friction: dict[str, Any], speed: float, algorithm: str) -> Scene:
    """A block, one cell high and under a given squeeze, that slides freely over a floor from a start at this speed."""
    return Scene.from_data(
        {
            "time": {"end": 1e-3},
            "integrator": integrator,
            "materials": {"m": {"use": "linear-elastic", "young": 100.0, "poisson": 0.0, "density": 1e-6}},
            "bodies": {
                "b": {
                    "element": "q1", "material": "m", "velocity": [speed, 0.0],
                    "mesh": {"use": "rectangle", "x": [0.0, 1.0], "y": [0.0, 1.0], "cells": [2, 1]},
                }
            },
            "rigid": {"floor": {"line": [[50.0, 0.0], [-50.0, 0.0]]}},
            "contacts": [{"slave": "b.bottom", "master": "floor", "algorithm": algorithm, "friction": friction}],
            "supports": [{"on": "b.top", "uy": {"ramp": "constant", "to": -0.01}}],
        },
        registry=REGISTRY,
    )  # fmt: skip


@ALGORITHMS
def test_viscous_friction_slows_a_block_in_explicit_steps(algorithm: str) -> None:
    """Bounds are those of the slip of their step: the error is of first order, as velocities are half a step behind."""
    errors = [error_of_a_slide({"use": "central-difference"}, steps, algorithm) for steps in (60, 120)]
    assert errors[1] < 0.6 * errors[0]
    assert errors[1] < 0.01


@pytest.mark.full
def test_viscous_friction_slows_a_block_in_implicit_steps() -> None:
    """Bounds are those of the mean rate of their step."""
    assert error_of_a_slide({"use": "implicit-dynamics", "impacts": False}, 60, "mortar-p1") < 0.005


def error_of_a_slide(integrator: dict[str, Any], steps: int, algorithm: str) -> float:
    """Error of the momentum that is left, relative.

    mu = m + c v is linear: two masses M/2, a spring G A/h between them, friction N (m + c v) on the lower one.
    """
    at_rest, viscous, speed, end = 0.3, 5e-4, 1000.0, 6e-4
    law = STRIBECK | {"static": at_rest, "kinetic": at_rest, "viscous": viscous}
    half, spring, load = 0.5e-6, 50.0, 1.0
    # lower and upper displacement, their velocities, and 1
    rates = np.zeros((5, 5))
    rates[0, 2] = rates[1, 3] = 1.0
    rates[2] = [-spring / half, spring / half, -load * viscous / half, 0.0, -load * at_rest / half]
    rates[3] = [spring / half, -spring / half, 0.0, 0.0, 0.0]
    expected = (expm(end * rates) @ [0.0, 0.0, speed, speed, 1.0])[2:4].sum() * half
    model = build(sliding(integrator, law, speed, algorithm), REGISTRY)
    advance = model.bound_integrator().step
    for _ in range(steps):
        assert advance(end / steps).status is StepStatus.accepted
    own = slice(model.bodies[0].first, model.bodies[0].first + model.bodies[0].count)
    return float(abs(model.mass[own] @ model.state["velocity"][own, 0] / expected - 1.0))


@pytest.mark.parametrize(
    ("use", "block"), [("central-difference", 2), ("implicit-dynamics", 2), ("central-difference", 1)]
)
def test_a_share_of_the_stress_behind_slows_a_block(use: str, block: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """A load N of 1 N takes mu N in each step but the first, which begins without stress: exact to round-off.

    Blocks of single cells share their room for stresses in explicit runs.
    """
    monkeypatch.setattr("contactlab.model.bodies.body.block_size", lambda cells: block)
    integrator = {"use": use} | ({"impacts": False} if use == "implicit-dynamics" else {})
    steps, dt = 60, 1e-5
    model = build(sliding(integrator, BULK, 1000.0, "mortar-p1"), REGISTRY)
    assert len(model.forces[0].blocks) == 2 // block
    advance = model.bound_integrator().step
    for _ in range(steps):
        assert advance(dt).status is StepStatus.accepted
    own = slice(model.bodies[0].first, model.bodies[0].first + model.bodies[0].count)
    momentum = model.mass[own] @ model.state["velocity"][own, 0]
    assert 1e-3 - momentum == pytest.approx(0.3 * (steps - 1) * dt, rel=1e-8)
    assert model.contact is not None
    assert model.contact.pairs[0].memory["traction"] == pytest.approx([-1.0] * 3, rel=1e-6)


def test_the_stress_behind_is_recorded_with_the_curves(tmp_path: Path) -> None:
    scene = sliding({"use": "newton"}, BULK, 0.0, "mortar-p1").with_({"supports.0.ux": 0.01})
    results = contactlab.simulate(scene, out=tmp_path)
    assert results.contact["contacts.0"].last.memory["traction"] == pytest.approx([-1.0] * 3)
    assert "traction" in (tmp_path / "contact.csv").read_text(encoding="utf-8").splitlines()[0]


@pytest.mark.parametrize("law", [DIETERICH | {"speed": 1000.0, "length": 0.1}, BULK], ids=["memory", "stress"])
@pytest.mark.parametrize("use", ["central-difference", "implicit-dynamics", "newton"])
def test_memory_survives_a_restart_and_no_step_that_fails_advances_it(
    use: str, law: dict[str, Any], taken_up: Any
) -> None:
    """Taken up by new parts half-way, and with steps that are rejected or taken back: the same bits."""
    integrator = {"use": use} | ({"impacts": False} if use == "implicit-dynamics" else {})
    scene = sliding(integrator, law, 1000.0, "mortar-p1").with_({"materials.m.use": "neo-hookean"})
    if use == "newton":
        drawn_along = {"supports.0.ux": {"ramp": "linear", "to": 1.0}, "bodies.b.velocity": [0.0, 0.0]}
        scene = scene.with_(drawn_along)
    dt, steps = 1e-5, 8
    model, _ = taken_up(scene, REGISTRY, dt, steps)
    kept = model.state["friction.contacts.0"][-1]
    assert model.contact is not None
    start = 1e-4 if law["use"] == "rate-and-state" else 0.0
    assert np.all(kept[model.state["multipliers"][0, model.contact.pairs[0].own] > 0.0] != start)


@pytest.mark.parametrize("dt", [1e-3, 1e-5])
def test_rates_are_found_in_steps_of_any_length(dt: float) -> None:
    """Steps much shorter than the time in which a block is loaded at 1 mm/s, 1e-3 s: bounds must not alternate.

    mu is that of the rate of reference once the block slides, to ten times what bounds may still change by.
    """
    law = DIETERICH | {"a": 0.03, "b": 0.01}
    held = {"ramp": "constant", "to": -0.002}
    drawn_along = {"supports.0.uy": held, "supports.0.ux": {"ramp": "linear", "to": 1.0, "duration": 1.0}}
    scene = sliding({"use": "newton"}, law, 0.0, "mortar-p1").with_(
        {**drawn_along, "materials.m.young": 1000.0, "time.end": 1.0}
    )
    model = build(scene, REGISTRY)
    advance, found = model.bound_integrator().step, []
    for length in (*[1e-3] * 6, *[dt] * 3):  # loaded and set in motion first
        assert advance(length).status is StepStatus.accepted
        normal, tangential = model.state["multipliers"]
        found.append(-tangential.sum() / normal.sum())
    assert found[-3:] == pytest.approx([0.4] * 3, abs=1e-4)
