"""What a run says of its length before the first step."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest
from contactlab_dynamics.central_difference import CentralDifference
from contactlab_statics.implicit_dynamics import ImplicitDynamics

from contactlab.api import StepControl
from contactlab.explanation.announcement import announcement
from contactlab.model.build import build
from contactlab.run.prepare import schedule_of
from contactlab.run.run import Run
from contactlab.scene.scene import Scene


def said(integrator: str, uy: Any, **time: float) -> str:
    """The line of a pressed block."""
    block = {"use": "rectangle", "x": [0.0, 1.0], "y": [0.0, 1.0], "cells": [2, 2]}
    scene = Scene.from_data({
        "integrator": integrator,
        "materials": {"m": {"use": "linear-elastic", "young": 1000.0, "poisson": 0.3, "density": 1e-9}},
        "bodies": {"b": {"element": "q1", "material": "m", "mesh": block}},
        "supports": [{"on": "b.bottom", "ux": 0.0, "uy": 0.0}, {"on": "b.top", "uy": uy}],
        "time": time,
    })  # fmt: skip
    model = build(scene, scene.registry)
    return announcement(cast(Run, SimpleNamespace(model=model, schedule=schedule_of(model, scene), attempts=None)))


@pytest.mark.parametrize(("kind", "begin"), [(CentralDifference, "at least"), (ImplicitDynamics, "about")])
def test_steps_that_follow_their_error_have_no_number_and_no_cost_before_they_are_made(
    kind: Any, begin: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Explicit steps may only be shorter than the stable one: 5 000 steps were told of a run that took 62 733."""
    monkeypatch.setattr(kind, "control", lambda self: StepControl(order=3))
    name = "central-difference" if kind is CentralDifference else "implicit-dynamics"
    line = said(name, {"ramp": "linear", "to": -0.01}, end=1e-5)
    assert line.startswith(f"simulates 1e-05 s (time.end): {begin} ")
    assert "whose length follows their error" in line
    assert "CPU time" not in line


def test_end_steps_cost_and_the_key_that_makes_a_run_long_are_named() -> None:
    """A wave at 1.16e6 mm/s takes 4.3e-7 s through a cell of 0.5 mm: the stable step is somewhat shorter."""
    line = said("central-difference", {"ramp": "linear", "to": -0.01, "duration": 1.0})
    assert line.startswith("simulates 1 s (supports.1.uy.duration)")
    steps = float(line.partition("about ")[2].partition(" steps")[0].replace(" ", ""))
    assert 1.0 / 4.3e-7 < steps < 3.0 / 4.3e-7
    assert "CPU time" in line
    assert "less than 1 s" not in line
    assert "supports.1.uy.duration makes it long: without it the loading takes" in line
    assert 'integrator = "newton"' in line


@pytest.mark.parametrize(
    ("integrator", "more", "expected"),
    [
        ("newton", {}, "applies the load in about 1 increment, less than 1 s of CPU time"),
        ("central-difference", {"end": 1e-5}, "simulates 1e-05 s (time.end): about"),
    ],
)
def test_a_short_run_is_one_plain_line(integrator: str, more: dict[str, float], expected: str) -> None:
    line = said(integrator, {"ramp": "linear", "to": -0.01}, **more)
    assert line.startswith(expected)
    assert "makes it long" not in line
    assert "\n" not in line
