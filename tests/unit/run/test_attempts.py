"""What is said of the integrators of `auto` that came short."""

from __future__ import annotations

from typing import Any

import pytest

from contactlab.errors import SceneError, SimulationFailure
from contactlab.explanation.announcement import announcement
from contactlab.explanation.explain import explain
from contactlab.reports.run import integrator
from contactlab.run.attempts import Attempt, Attempts, as_taken, comes_short, first_that_fits
from contactlab.run.run import Run
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene, load_scene

BLOCK: dict[str, Any] = {
    "integrator": "auto",
    "materials": {"m": {"use": "linear-elastic", "young": 1000.0, "poisson": 0.3, "density": 1e-9}},
    "bodies": {"b": {
        "element": "q1", "material": "m",
        "mesh": {"use": "rectangle", "x": [0.0, 1.0], "y": [0.0, 1.0], "cells": [2, 2]},
    }},
    "supports": [{"on": "b.bottom", "ux": 0.0, "uy": 0.0}],
    "loads": [{"on": "b.top", "ty": {"ramp": "linear", "to": -1.0}}],
}  # fmt: skip
STOPPED = Attempt(
    "newton", "not-converged", "stopped at 40 % of the load, it buckles; try less (a step failed)",
    {"time": 0.4, "share": 0.4, "of": "load"}, 4, 30, 0.25,
)  # fmt: skip


def scene(**more: Any) -> Scene:
    return Scene.from_data({**BLOCK, **more})


def test_an_attempt_is_told_in_a_clause() -> None:
    assert STOPPED.brief == "newton not-converged: stopped at 40 % of the load, it buckles (0.25 CPU s)"
    refused = Attempt.of_error("newton", SceneError("nothing moves by itself in statics: no motion", where="key v"))
    assert (refused.status, refused.reason) == ("refused", "nothing moves by itself in statics: no motion (key v)")
    assert refused.brief == "newton refused: nothing moves by itself in statics: no motion"
    failed = Attempt.of_error("newton", SimulationFailure("diverged", "bodies overlap"))
    assert (failed.status, failed.reason, failed.folder) == ("diverged", "bodies overlap", "")
    chosen = Attempts([], [STOPPED]).resolved("implicit-dynamics")
    assert integrator(chosen) == f"implicit-dynamics; {STOPPED.brief}"


def test_a_run_comes_short_by_its_status_its_stabilisation_or_forces_that_lean() -> None:
    assert comes_short({"status": "finished", "reason": ""}) == ""
    codes = {"slower-loading": "", "leaning-forces": "forces differ"}
    for code, reason in codes.items():
        warned = {"warnings": [{"code": code, "text": "forces differ"}]}
        assert comes_short({"status": "finished", "reason": "", **warned}) == reason
    assert comes_short({"status": "diverged", "reason": "too fast"}) == "too fast"
    # another integrator would not help
    for status in ("failed", "interrupted", "timed-out"):
        assert comes_short({"status": status, "reason": "the disk is full"}) == ""
    for share, reason in ((0.04, ""), (0.09, "stabilisation took 9.0% of the work, in 2 load steps")):
        took = {"steps": 2, "work": 1.0, "share": share}
        assert comes_short({"status": "finished", "reason": "", "stabilisation": took}) == reason


def test_a_run_that_is_finished_is_further_than_one_that_is_not() -> None:
    finished = Attempt("newton", "finished", "stabilised", {"share": 1.0})
    assert finished.progress > Attempt("a", "not-converged", "", {"share": 1.0}).progress > STOPPED.progress


def test_what_explains_or_chooses_takes_the_integrator_that_the_run_begins_with() -> None:
    first, order = first_that_fits(scene(), scene().registry)
    assert first.integrator["use"] == "newton"
    said = explain(first, first.registry, attempts=order).scene.integrator
    assert said == "auto: newton, then implicit-dynamics, central-difference if it fails"
    thrown = scene(bodies={"b": {**BLOCK["bodies"]["b"], "spin": 3.0}}, time={"end": 1e-6})
    first, order = first_that_fits(thrown, thrown.registry)
    said = explain(first, first.registry, attempts=order).scene.integrator
    assert said.startswith("auto: implicit-dynamics, then central-difference if it fails; newton refused: nothing")
    with pytest.raises(SceneError, match="nothing moves by itself"):
        first_that_fits(thrown.with_({"integrator.order": ["newton"]}), thrown.registry)
    named = scene(integrator="newton")
    assert first_that_fits(named, named.registry) == (named, None)
    assert explain(named, named.registry).scene.integrator == ""


@pytest.mark.parametrize(
    ("contact", "order", "why"),
    [
        ({"enforcement": "active-set"}, ["central-difference", "newton"], "needed: kind ExplicitEnforcement"),
        ({"enforcement": "nitsche"}, ["implicit-dynamics", "newton"], "follows the stress of the slave's cells"),
        ({"algorithm": "barrier"}, ["central-difference", "newton"], "is a potential"),
    ],
)
def test_an_integrator_that_does_not_take_a_contact_is_left_out_with_the_reason(
    contact: dict[str, Any], order: list[str], why: str
) -> None:
    changes = {f"contacts.0.{key}": value for key, value in contact.items()}
    disc = load_scene("disc-on-block").with_({**changes, "integrator": {"use": "auto", "order": order}})
    first, attempts = first_that_fits(disc, disc.registry)
    assert first.integrator["use"] == "newton"
    assert attempts is not None
    (refused,) = attempts.tried
    assert (refused.use, refused.status) == (order[0], "refused")
    assert why in refused.reason


def test_a_scene_is_refined_with_the_integrator_that_its_run_took() -> None:
    results = simulate(
        scene(integrator={"use": "auto", "order": [{"use": "newton", "steps": 2}, "central-difference"]})
    )
    taken = as_taken(scene(integrator={"use": "auto", "order": results.summary["resolved"]["integrator"]["order"]}),
                     results.summary)  # fmt: skip
    assert taken.integrator["steps"] == 2
    named = scene(integrator="newton")
    assert as_taken(named, {}) is named


def test_each_run_is_announced_with_what_came_short_before_it() -> None:
    said: list[str] = []
    hard = {"use": "newton", "iterations": 1, "stabilised": False}
    order = [hard, {"use": "implicit-dynamics", "steps": 5}]
    changes = {
        "integrator": {"use": "auto", "order": order},
        "materials.m.use": "neo-hookean",
        "materials.m.young": 100.0,
    }

    def announce(run: Run) -> None:
        said.append(announcement(run))

    simulate(scene(time={"end": 1e-6}).with_(changes), announce=announce)
    assert said[0].startswith("newton applies the load in about 1 increment,")
    before, line = said[1].split("\n")
    assert before.startswith("newton not-converged: stopped at 0 % of the load")
    assert line.startswith("implicit-dynamics simulates 1e-06 s")
