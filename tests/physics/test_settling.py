"""Runs with `end = "auto"` settle when reactions balance the loads, whatever drives them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from contactlab.model.build import build
from contactlab.parts.registry import default_registry
from contactlab.run.schedule import SAMPLES, Schedule
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene


def pressed(**more: Any) -> Scene:
    """A block on another one, that nothing but the contact holds up."""
    body = {"element": "q1", "material": "m"}
    data = {
        "name": "pressed",
        "time": {"end": "auto"},
        "integrator": "central-difference",
        "materials": {"m": {"use": "neo-hookean", "young": 1000.0, "poisson": 0.3, "density": 1e-9}},
        "bodies": {
            "upper": {**body, "mesh": {"use": "rectangle", "x": [0.0, 2.0], "y": [0.0, 1.0], "cells": [4, 2]}},
            "lower": {**body, "mesh": {"use": "rectangle", "x": [0.0, 2.0], "y": [-1.0, 0.0], "cells": [5, 2]}},
        },
        "contacts": [{"slave": "upper.bottom", "master": "lower.top", "algorithm": "mortar-p1"}],
        "supports": [
            {"on": "lower.bottom", "uy": 0.0},
            {"on": "lower.left", "ux": 0.0},
            {"on": "upper.left", "ux": 0.0},
        ],
        "record": {"frames": 2},
        **more,
    }
    return Scene.from_data(data)


def test_a_run_that_a_pressure_drives_settles() -> None:
    """The reaction is pressure times length, in balance with the load."""
    load = {"on": "upper.top", "pressure": {"ramp": "smooth", "to": 5.0}, "follower": False}
    results = simulate(pressed(loads=[load]))
    assert results.status == "finished", results.reason
    # what settled means: 2e-4 over a period, and better in the end
    assert results.summary["reactions"]["lower.bottom"][1] == pytest.approx(10.0, rel=2e-4)
    assert results.summary["reaction_mismatch"] < 2e-4


def test_a_run_under_weight_settles() -> None:
    """Gravity is a load, too: 4 mm2 of 1e-9 t/mm3 under 1e8 mm/s2 weigh 0.4 N."""
    ramp = build(pressed(), default_registry()).timing.ramp
    results = simulate(pressed(effects=[{"use": "gravity", "acceleration": [0.0, -1e8], "ramp": ramp}]))
    assert results.status == "finished", results.reason
    assert results.summary["reactions"]["lower.bottom"][1] == pytest.approx(0.4, rel=2e-4)


@pytest.mark.parametrize(("left", "settled"), [(0.05, False), (1e-6, True)])
def test_what_is_left_of_a_released_body_is_judged_by_what_has_pressed_it(left: float, settled: bool) -> None:
    """The end of an elastic run that is unloaded has no energy of its own, and reactions of vibrations alone.

    One support keeps a share of the force of the run: a twentieth is no rest, a millionth is (2e-4 of a hundredth).
    """
    scene = pressed()
    model = build(scene, default_registry())
    schedule, state = Schedule(model, scene), model.state
    node = model.loading.supports[0].nodes[0]
    state["reaction"][node, 1], state["work"][0], state["clock"][0] = 100.0, 1.0, schedule.next_frame
    assert schedule.frame_due()
    state["reaction"][node, 1], state["work"][0] = 100.0 * left, left**2
    for _ in range(SAMPLES + 1):
        assert not schedule.settled
        state["clock"][0] = schedule.next_sample
        schedule.done()
    assert schedule.settled == settled


@pytest.mark.parametrize(("weight", "young"), [(0.1, 1e3), (1e-5, 2e5)])
def test_what_steps_do_not_resolve_fades_too(weight: float, young: float) -> None:
    """A sudden weight excites all modes of a column of four cells, and steps resolve the lowest one.

    Those of steel under its own weight are so small that steps are accepted by the round-off of its stresses.
    """
    layers = 4
    column = {"element": "q1", "material": "m"}
    mesh = {"use": "rectangle", "x": [0.0, 1.0], "y": [0.0, 1.0], "cells": [1, layers]}
    scene = pressed().with_(
        {
            "integrator": {"use": "implicit-dynamics", "steps": 50},
            "materials": {"m": {"use": "linear-elastic", "young": young, "poisson": 0.0, "density": 1e-9}},
            "bodies": {"column": {**column, "mesh": mesh}},
            "rigid": {"floor": {"line": [[2.0, 0.0], [-1.0, 0.0]]}},
            "contacts": [{"slave": "column.bottom", "master": "floor", "algorithm": "mortar-p0"}],
            "supports": [],
            "effects": [{"use": "gravity", "acceleration": [0.0, -1e9 * weight]}],
        }
    )
    period = build(scene, default_registry()).timing.period
    results = simulate(scene.with_({"time.ramp": 10.0 * period}))
    assert results.status == "finished", results.reason
    assert results.summary["reactions"]["floor"][1] == pytest.approx(weight, rel=2e-4)
    pressed_by = weight * (np.arange(layers) + 0.5) / layers  # each cell, by what is above it
    stored = (pressed_by**2).sum() / (2.0 * young * layers)
    assert results.summary["balance"]["stored"] == pytest.approx(stored, rel=1e-3)


@pytest.mark.parametrize("held", [{}, {"on": "upper.left", "ux": 0.0}])
def test_a_body_that_its_supports_leave_adrift_is_paced_by_its_stretching(held: dict[str, Any]) -> None:
    """Not by its rigid motion, whose frequency is zero: within a factor of 5 of the period of the body that is held."""
    supports = [{"on": "lower.bottom", "ux": 0.0, "uy": 0.0}] + ([held] if held else [])
    scene = pressed(supports=supports, loads=[{"on": "upper.top", "pressure": 1.0}])
    loose = build(scene, default_registry()).timing.period
    fast = build(
        pressed(supports=[*supports[:1], {"on": "upper.top", "ux": 0.0, "uy": 0.0}]), default_registry()
    ).timing
    assert 0.2 * fast.period < loose < 5.0 * fast.period
