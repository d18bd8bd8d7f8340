"""Vibrations in implicit dynamics know how far they lag behind; what does not vibrate by itself has no lag."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from contactlab_cases.series import Series

from contactlab.results.results import Results
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene

DENSITY, SPEED, STIFFNESS = 1e-8, 100.0, 0.04
MASS = DENSITY * 10.0 * 4.0
PERIOD = 2.0 * math.pi * math.sqrt(MASS / STIFFNESS)
LAW = {"use": "linear-elastic", "young": 2e5, "poisson": 0.3, "density": DENSITY}
BLOCK = {
    "element": "q1", "material": "m", "mesh": {"use": "rectangle", "x": [0.0, 10.0], "y": [0.0, 4.0], "cells": [2, 1]},
}  # fmt: skip
SPRING = {"use": "spring", "on": "block", "stiffness": [0.0, STIFFNESS]}
FLOOR = {
    "rigid": {"floor": {"line": [[60.0, 0.0], [-60.0, 0.0]]}},
    "contacts": [
        {
            "slave": "block.bottom", "master": "floor", "algorithm": "mortar-p0",
            "enforcement": {"use": "linear-pressure", "stiffness": STIFFNESS / 10.0},
        }
    ],
}  # fmt: skip


def run(end: float, steps: int, velocity: list[float], **changes: Any) -> Results:
    scene = {
        "time": {"end": end}, "integrator": {"use": "implicit-dynamics", "steps": steps}, "materials": {"m": LAW},
        "bodies": {"block": {**BLOCK, "velocity": velocity}}, "record": {"recorders": [], "frames": 10}, **changes,
    }  # fmt: skip
    return simulate(Scene.from_data(scene), watch={"kept": Series(("time", "displacement.block.y"))})


def told(results: Results) -> float:
    assert results.status == "finished"
    return max((warning.value for warning in results.warnings if warning.code == "phase-error"), default=0.0)


def error(results: Results, exact: Callable[[np.ndarray], np.ndarray]) -> float:
    """Largest error of the displacement over its largest value; `exact` takes times."""
    time, found = results.watched["kept"]["time"], results.watched["kept"]["displacement.block.y"]
    return float(np.abs(found - exact(time)).max() / np.abs(exact(time)).max())


def swing(time: np.ndarray) -> np.ndarray:
    w = 2.0 * math.pi / PERIOD
    return np.asarray(SPEED / w * np.sin(w * time))


@pytest.mark.parametrize(("periods", "each"), [(10, 12), (5, 24), (10, 28)])
def test_a_mass_on_a_spring(periods: int, each: int) -> None:
    """Known: v/w sin wt. The estimate is the first term of the error, good up to a whole amplitude."""
    results = run(periods * PERIOD, periods * each, [0.0, SPEED], effects=[SPRING])
    true = error(results, swing)
    assert 0.5 < told(results) / true < 2.0


def test_what_it_advises_is_enough() -> None:
    """With the number of steps of the text the error is the limit: it falls with their square."""
    few = run(5 * PERIOD, 120, [0.0, SPEED], effects=[SPRING])
    (text,) = (warning.text for warning in few.warnings if warning.code == "phase-error")
    steps = int(text.split("integrator.steps = ")[1].split()[0])
    many = run(5 * PERIOD, steps, [0.0, SPEED], effects=[SPRING])
    assert told(many) == 0.0
    assert error(many, swing) < 0.05


def test_a_load_on_a_pressure_law() -> None:
    """A load F that acts at once on a floor of stiffness k: -F/k (1 - cos wt), as long as the floor is pressed."""
    force = 0.004
    load = {"on": "block.top", "ty": {"ramp": "table", "to": -force / 10.0, "points": [[0.0, 1.0], [100.0, 1.0]]}}
    results = run(6 * PERIOD, 120, [0.0, 0.0], loads=[load], **FLOOR)
    w = 2.0 * math.pi / PERIOD
    true = error(results, lambda time: force / STIFFNESS * (np.cos(w * time) - 1.0))
    assert 0.5 < told(results) / true < 2.0


MOVED = {"on": "block.bottom", "ux": 0.0, "uy": {"ramp": "smooth", "to": 10.0, "duration": 1e-2}}
PRESSED = {"on": "block.top", "ty": {"ramp": "smooth", "to": -100.0, "duration": 1e-2}}


@pytest.mark.parametrize(
    ("velocity", "changes"),
    [
        ([100.0, 300.0], {}),
        ([0.0, 0.0], {"supports": [MOVED]}),
        ([0.0, 0.0], {"supports": [{"on": "block.bottom", "ux": 0.0, "uy": 0.0}], "loads": [PRESSED]}),
        ([0.0, -300.0], {**FLOOR, "effects": [{"use": "gravity", "acceleration": [0.0, -9810.0]}]}),
    ],
    ids=["thrown", "moved by a support", "pressed slowly", "one bounce"],
)
def test_what_does_not_vibrate_is_told_nothing(velocity: list[float], changes: dict[str, Any]) -> None:
    assert told(run(1e-2, 20, velocity, **changes)) == 0.0
