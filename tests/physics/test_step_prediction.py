"""Load steps start from where the step before leads: fewer iterations to the same state."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import contactlab
from contactlab.implicit import load_step
from contactlab.model.build import build
from contactlab.results.results import Results
from contactlab.scene.scene import Scene

ALUMINIUM = {
    "use": "power-law", "young": 70000.0, "poisson": 0.3, "density": 2.7e-9, "strength": 348.0, "prestrain": 0.02,
    "exponent": 0.03,
}  # fmt: skip


def upset(**more: Any) -> Scene:
    """A block 4 x 8 between rough plates, flattened by a sixteenth in ten steps."""
    mesh = {"use": "rectangle", "x": [0.0, 4.0], "y": [0.0, 8.0], "cells": [4, 8]}
    data: dict[str, Any] = {
        "time": {"end": 1.0},
        "integrator": {"use": "newton", "steps": 10},
        "materials": {"m": ALUMINIUM},
        "bodies": {"block": {"element": "q1-fbar", "material": "m", "mesh": mesh}},
        "supports": [
            {"on": "block.bottom", "ux": 0.0, "uy": 0.0},
            {"on": "block.top", "ux": 0.0, "uy": {"ramp": "linear", "to": -0.5}},
        ],
        "record": {"frames": 1, "recorders": []},
    }
    return Scene.from_data(data).with_(more)


def without(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> Results:
    with monkeypatch.context() as patch:
        patch.setattr(load_step, "FARTHEST", 0.0)
        return contactlab.simulate(scene)


LOADED = {
    "supports": [{"on": "block.bottom", "ux": 0.0, "uy": 0.0}],
    "loads": [{"on": "block.top", "pressure": {"ramp": "linear", "to": 380.0}}],
}


@pytest.mark.parametrize("more", [{}, LOADED], ids=["moved", "loaded"])
def test_steps_that_go_on_need_fewer_iterations_and_end_in_the_same_state(
    more: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same to the tolerance of the iteration, since the start of an iteration is no part of its solution."""
    scene = upset(**more)
    plain, predicted = without(scene, monkeypatch), contactlab.simulate(scene)
    assert plain.status == predicted.status == "finished"
    assert predicted.summary["iterations"] <= 0.7 * plain.summary["iterations"]
    assert np.abs(predicted.displacement - plain.displacement).max() < 1e-6 * np.abs(plain.displacement).max()


def test_a_loading_that_turns_round_is_not_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = upset()
    model = build(scene, scene.registry)
    step = model.bound_integrator().step
    before = load_step.Prediction(model, model.state)  # type: ignore[arg-type]
    held = model.prescribed.dof
    ahead = model.prescribed.scale * model.prescribed.values(0.2)[model.prescribed.ramp]
    assert not before.start(0.1, ahead)  # nothing is known before the first step
    step(0.1)
    there = model.state["displacement"].copy()
    now = there.reshape(-1)[held]
    assert not before.start(0.1, 0.5 * now)  # back
    assert not before.start(0.1, now + 10.0 * (ahead - now))  # further than anything is known of
    assert np.array_equal(model.state["displacement"], there)
    assert before.start(0.1, ahead)
    assert np.array_equal(model.state["displacement"].reshape(-1)[held], ahead)
    free = np.setdiff1d(np.arange(there.size), held)
    assert model.state["displacement"].reshape(-1)[free] == pytest.approx(2.0 * there.reshape(-1)[free])


def test_laws_without_history_start_from_where_they_are() -> None:
    """Their steps are long: on fine meshes contact took a fifth more iterations from an extrapolated start."""
    law = {"use": "neo-hookean", "young": 1000.0, "poisson": 0.25, "density": 1e-6}
    scene = upset(**{"materials.m": law})
    model = build(scene, scene.registry)
    model.bound_integrator().step(0.1)
    following = load_step.Prediction(model, model.state)  # type: ignore[arg-type]
    assert not following.start(0.1, 2.0 * model.state["displacement"].reshape(-1)[model.prescribed.dof])


def test_with_friction_contact_finds_its_edge_sooner(monkeypatch: pytest.MonkeyPatch) -> None:
    """A twentieth of the iterations at least (6 to 17 % on all meshes, docs/statics.md), to the same pressures."""
    keys = {"level": 1, "integrator": {"use": "newton", "steps": 10}, "record.frames": 1}
    friction = {"contacts.0.friction": {"use": "coulomb", "mu": 0.2}}
    scene = contactlab.load_scene("disc-on-block").with_(keys | friction)
    plain, predicted = without(scene, monkeypatch), contactlab.simulate(scene)
    assert plain.status == predicted.status == "finished"
    assert predicted.summary["iterations"] <= 0.95 * plain.summary["iterations"]
    found, expected = (np.asarray(run.contact["contacts.0"].last.pressure) for run in (predicted, plain))
    assert found == pytest.approx(expected, abs=1e-6 * expected.max())  # steps are exact to 1e-8


@pytest.mark.full
def test_the_forging_begins_in_few_iterations() -> None:
    """A quarter of its way, where contact is made: eight iterations a step, and hardly a step in vain.

    Without prediction three times as many go into steps that fail.
    """
    forging = contactlab.load_scene("three-body-forging")
    changes = {f"contacts.{number}.algorithm": "mortar-p1" for number in range(3)}
    push = {"supports.0.uy": {"ramp": "parabola", "to": -0.6}, "record.frames": 1, "record.recorders": []}
    results = contactlab.simulate(forging.with_({"integrator": {"use": "newton"}} | changes | push))
    assert results.status == "finished", results.reason
    assert results.summary["iterations"] <= 110
    top, floor = (results.summary["reactions"][name] for name in ("punch.top", "floor"))
    assert np.abs(np.add(top, floor)).max() < 1e-6 * abs(floor[1])  # what moves symmetrically stays so
