"""Laws that follow a temperature of the scene, against closed forms; restart and steps taken back.

The laws are those of tests/outside/heated.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import contactlab
from contactlab.errors import SceneError
from contactlab.explanation.effect_table import effects_of
from contactlab.model.build import build
from contactlab.model.memory import model_memory, restore_model
from contactlab.parts.registry import Registry
from contactlab.scene.scene import Scene

LAWS = Path(__file__).parents[1] / "outside" / "heated" / "src" / "heated" / "heated_laws.py"
REGISTRY = Registry(files=[LAWS])
HEATED = {"use": "heated", "young": 1000.0, "poisson": 0.3, "expansion": 1e-5, "density": 1e-6}
PLAIN = {"use": "linear-elastic", "young": 1000.0, "poisson": 0.3, "density": 1e-6}
WARM = {"value": {"ramp": "linear", "to": 100.0}, "profile": {"by": "x", "table": [[0.0, 0.0], [2.0, 1.0]]}}
DRAUGHT = {"use": "draught", "lift": 0.02, "on": ["b"]}
INTEGRATORS = pytest.mark.parametrize("integrator", ["newton", "central-difference"])


def bar(integrator: str, **changes: Any) -> Scene:
    """A bar between smooth walls on all sides, heated to 100 K at its right end and not at all at its left."""
    mesh = {"use": "rectangle", "x": [0.0, 2.0], "y": [0.0, 1.0], "cells": [4, 2]}
    sides = {"left": "ux", "right": "ux", "bottom": "uy", "top": "uy"}
    data = {
        "integrator": integrator,
        "materials": {"m": HEATED},
        "bodies": {"b": {"element": "q1", "material": "m", "mesh": mesh}},
        "supports": [{"on": f"b.{side}", axis: 0.0} for side, axis in sides.items()],
        "fields": {"temperature": WARM},
    }
    return Scene.from_data(data | changes, registry=REGISTRY)


@INTEGRATORS
def test_a_bar_that_is_heated_by_place_and_time_presses_on_its_walls(integrator: str) -> None:
    """E alpha/(1 - 2 nu) times the mean temperature, as lengths stay; the run lasts as long as the field changes.

    Explicit runs end at rest to the 1e-3 by which they judge it.
    """
    results = contactlab.simulate(bar(integrator))
    assert results.status == "finished", results.reason
    force = results.summary["reactions"]["b.left"][0]
    assert force == pytest.approx(1000.0 * 1e-5 / 0.4 * 50.0, rel=1e-9 if integrator == "newton" else 1e-3)
    points = np.array([0.25, 0.75, 1.25, 1.75]) * 50.0
    assert np.sort(results.internal_variables["b"]["temperature"].mean(axis=1))[::2] == pytest.approx(points)


def test_the_ledger_closes_where_heat_moves_supports_and_free_sides() -> None:
    """Forces at the start of a step are those of the temperature there; exact to round-off, as the law is linear."""
    pushed = [
        {"on": "b.left", "ux": 0.0},
        {"on": "b.bottom", "uy": 0.0},
        {"on": "b.right", "ux": {"ramp": "linear", "to": -0.001}},
    ]
    results = contactlab.simulate(bar("newton", supports=pushed))
    assert results.status == "finished", results.reason
    assert results.summary["balance"]["ledger_error"] < 1e-9


def test_an_effect_follows_the_temperature_of_its_places() -> None:
    """Held by its bottom it hangs there with the lift at the mean temperature, as shares of nodes are exact for x."""
    held = [{"on": "b.bottom", "ux": 0.0, "uy": 0.0}]
    results = contactlab.simulate(bar("newton", supports=held, effects=[DRAUGHT]))
    assert results.status == "finished", results.reason
    assert results.summary["reactions"]["b.bottom"][1] == pytest.approx(-0.02 * 50.0, rel=1e-9)


def test_an_effect_follows_the_temperature_of_its_time() -> None:
    """Momentum of a free body whose lift grows with time, half a step back: off by (dt / 2 t)^2, 6e-6 here."""
    end, steps = 1e-3, 200
    model = build(bar("central-difference", supports=[], effects=[DRAUGHT], time={"end": end}), REGISTRY)
    advance = model.bound_integrator().step
    for _ in range(steps):
        advance(1e-6)
    time = (steps - 0.5) * 1e-6
    found = float(model.mass @ model.state["velocity"][:, 1])
    assert found == pytest.approx(0.02 * 50.0 / end * 0.5 * time**2, rel=1e-5)


def test_an_effect_without_its_field_is_refused() -> None:
    with pytest.raises(SceneError, match=r"effects\.0(.|\n)*temperature"):
        build(bar("newton", effects=[DRAUGHT], materials={"m": PLAIN}, fields={}), REGISTRY)


def advanced(scene: Scene, stop: int, disturb: bool) -> dict[str, Any]:
    """The state after six steps; resumed by new parts after `stop`, or with steps tried in vain on the way."""
    model = build(scene, REGISTRY)
    dt = model.step_within(0.5) if model.explicit else 1.0 / 6.0
    advance = model.bound_integrator().step
    for step in range(6):
        if step == stop:
            kept = {name: np.copy(values) for name, values in model_memory(model).items()}
            if disturb:
                advance(0.5 * dt)
            else:
                model = build(scene, REGISTRY)
                advance = model.bound_integrator().step
            restore_model(model, kept)
            model.internal_force(0.0)
        advance(dt)
    return {name: model.state[name].copy() for name in ("displacement", "internal_force", "history.b")}


@INTEGRATORS
@pytest.mark.parametrize("disturb", [False, True], ids=["restart", "rejection"])
def test_fields_survive_a_restart_and_steps_that_are_taken_back(integrator: str, disturb: bool) -> None:
    time = {"end": 1.0} if integrator == "newton" else {"end": 1e-3}
    scene = bar(integrator, time=time, effects=[DRAUGHT])
    whole, again = advanced(scene, -1, disturb), advanced(scene, 3, disturb)
    for name, values in whole.items():
        np.testing.assert_array_equal(again[name], values, err_msg=name)


def test_friction_falls_with_the_temperature_of_its_place() -> None:
    """mu (1 - T/melt), drawn over a floor at a mean of 50 K under an even pressure (nu = 0)."""
    friction = {"use": "softening", "mu": 0.4, "melt": 200.0}
    scene = bar(
        "newton",
        materials={"m": {"use": "linear-elastic", "young": 1000.0, "poisson": 0.0, "density": 1e-6}},
        rigid={"floor": {"line": [[9.0, 0.0], [-9.0, 0.0]]}},
        contacts=[{"slave": "b.bottom", "master": "floor", "algorithm": "mortar-p1", "friction": friction}],
        supports=[{"on": "b.top", "ux": {"ramp": "linear", "to": 0.05}, "uy": {"ramp": "constant", "to": -0.001}}],
        fields={"temperature": {"value": 50.0}},
    )
    results = contactlab.simulate(scene)
    assert results.status == "finished", results.reason
    across, along = results.summary["reactions"]["floor"][::-1]
    assert abs(along) / abs(across) == pytest.approx(0.4 * 0.75, rel=1e-5)


@INTEGRATORS
def test_a_pressure_follows_temperature_place_and_time(integrator: str) -> None:
    """Rate T x t u over the nodes' lengths, under a block a million times as stiff; explicitly it rings by 4e-3 u.

    Lengths times places are 2 for x from 0 to 2, whatever the shares of nodes.
    """
    push, end, rate = 0.01, 2.5e-4, 0.01
    scene = Scene.from_data(
        {
            "time": {"end": end},
            "integrator": integrator,
            "materials": {"m": {"use": "linear-elastic", "young": 1000.0, "poisson": 0.0, "density": 1e-9}},
            "bodies": {
                "b": {
                    "element": "q1", "material": "m",
                    "mesh": {"use": "rectangle", "x": [0.0, 2.0], "y": [0.0, 1.0], "cells": [2, 1]},
                }
            },
            "rigid": {"floor": {"line": [[5.0, 0.0], [-5.0, 0.0]]}},
            "contacts": [
                {
                    "slave": "b.bottom", "master": "floor", "algorithm": "mortar-p1",
                    "enforcement": {"use": "curing-layer", "rate": rate},
                }
            ],
            "supports": [{"on": "b.top", "ux": 0.0, "uy": {"ramp": "linear", "to": -push}}],
            "fields": {"temperature": {"value": {"ramp": "linear", "to": 100.0}}},
        },
        registry=REGISTRY,
    )  # fmt: skip
    results = contactlab.simulate(scene)
    assert results.status == "finished", results.reason
    found = abs(results.history["contacts.0.fy"][-1])
    assert found == pytest.approx(rate * 100.0 * 2.0 * end * push, rel=1e-5 if integrator == "newton" else 1e-2)
    with pytest.raises(SceneError, match=r"contacts\.0\.enforcement(.|\n)*got +\"temperature\""):
        build(scene.with_({"fields": {}}), REGISTRY)


def test_a_field_that_is_missing_is_named_and_one_that_is_there_is_explained() -> None:
    with pytest.raises(SceneError, match="temperature"):
        build(bar("newton", fields={}), REGISTRY)
    scene = bar("newton")
    rows = {row.effect: row.by for row in effects_of(scene, REGISTRY, build(scene, REGISTRY))}
    assert rows["fields"] == "fields.temperature"
