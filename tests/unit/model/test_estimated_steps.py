"""What `explain` says of the number of steps is what a run then takes."""

from __future__ import annotations

from typing import Any

import pytest

import contactlab
from contactlab.errors import RequestError
from contactlab.explanation.explain import explain
from contactlab.run.simulation import simulate

SHALLOW = {"level": 1, "supports.1.uy.to": -0.03, "record.frames": 1}
HELD = {"ramp": "linear", "to": -0.03, "duration": 0.5}


@pytest.mark.parametrize(
    "changes",
    [
        {"integrator": "newton"},
        {"integrator": {"use": "newton", "steps": 3}, "time.end": 2.0, "supports.1.uy": HELD},
        {"integrator": {"use": "newton", "steps": 3}, "time.step": 0.25, "time.end": 1.0},
        {"integrator": {"use": "implicit-dynamics", "steps": 4, "impacts": False}, "time.end": 1e-5},
    ],
    ids=["steps of equal loading", "a corner of the loading", "a length in the scene", "steps in time"],
)
def test_implicit_runs_take_the_steps_that_are_announced(changes: dict[str, Any]) -> None:
    scene = contactlab.load_scene("disc-on-block").with_(SHALLOW | changes)
    results = simulate(scene)
    assert results.status == "finished"
    assert not [event for event in results.events if "rejected after" in event.text]
    assert explain(scene, scene.registry).scene.estimated_steps == results.summary["steps"]


FRICTION = {"contacts.0.friction": {"use": "coulomb", "mu": 0.2}}
THERE_AND_BACK = {
    "time.end": 2.0,
    "supports.1.uy": {"ramp": "table", "to": -0.03, "points": [[0.0, 0.0], [1.0, 1.0], [2.0, 0.0]]},
}


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({}, "none: the end does not depend on the loading path, so one load step"),
        (THERE_AND_BACK, "none: the end does not depend on the loading path, so 2 load steps, from turn to turn"),
        ({"integrator": {"use": "newton", "steps": 3}}, "none: the end does not depend on the loading path"),
        (FRICTION, "contacts.0.friction"),
    ],
    ids=["straight", "there and back", "load steps asked for", "friction"],
)
def test_explain_says_what_a_scene_without_history_saves(changes: dict[str, Any], told: str) -> None:
    shallow = {**SHALLOW, "integrator": "newton"}
    if "supports.1.uy" in changes:
        shallow.pop("supports.1.uy.to")
    scene = contactlab.load_scene("disc-on-block").with_({**shallow, **changes})
    assert explain(scene, scene.registry).scene.history == told


def test_a_step_left_over_from_an_explicit_run_is_refused() -> None:
    """A hundred million load steps of 1e-8 are nobody's wish."""
    scene = contactlab.load_scene("disc-on-block").with_(SHALLOW | {"integrator": "newton", "time.step": 1e-8})
    with pytest.raises(RequestError, match="this length needs 100000000 steps") as told:
        simulate(scene)
    assert "omit it" in str(told.value)


def test_a_block_above_a_plane_comes_to_rest_on_it_in_statics() -> None:
    """Nothing holds it before it lands: its correction ends on the plane, which then carries its weight."""
    results = simulate(contactlab.load_scene("dropped-block").with_({"integrator": "newton"}))
    assert results.status == "finished"
    weight = 1e-9 * 10.0 * 10.0 * 9810.0
    assert results.summary["reactions"]["plane"] == pytest.approx([0.0, weight], rel=1e-9, abs=1e-9 * weight)
