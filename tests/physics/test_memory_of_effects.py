"""An effect with memory, that of tests/outside/remembering, against a closed form; restart and rejected steps."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

import contactlab
from contactlab.errors import WrongAnswer
from contactlab.model.build import build
from contactlab.parts.registry import Registry
from contactlab.scene.scene import Scene

PARTS = Path(__file__).parents[1] / "outside" / "remembering" / "src" / "remembering" / "parts.py"
REGISTRY = Registry(files=[PARTS])
YOUNG, WIDTH, STIFFNESS, RELAXATION, WAY, END = 1000.0, 2.0, 500.0, 3e-4, 0.01, 1e-3


def held_back(integrator: Any) -> Scene:
    """A bar of unit height that is drawn up at its top, with springs and dashpots at its bottom."""
    return Scene.from_data(
        {
            "time": {"end": END},
            "integrator": integrator,
            "materials": {"m": {"use": "linear-elastic", "young": YOUNG, "poisson": 0.0, "density": 1e-9}},
            "bodies": {
                "b": {
                    "element": "q1", "material": "m",
                    "mesh": {"use": "rectangle", "x": [0.0, WIDTH], "y": [0.0, 1.0], "cells": [2, 1]},
                }
            },
            "supports": [{"on": "b.top", "ux": 0.0, "uy": {"ramp": "linear", "to": WAY}}],
            "effects": [
                {"use": "maxwell", "stiffness": STIFFNESS, "relaxation": RELAXATION, "on": ["b.bottom"]},
            ],
        },
        registry=REGISTRY,
    )  # fmt: skip


def error(integrator: Any) -> float:
    results = contactlab.simulate(held_back(integrator))
    assert results.status == "finished", results.reason
    assert "remembering" in results.summary["parts"]["effects.0"]
    longer = RELAXATION * (1.0 + STIFFNESS / (YOUNG * WIDTH))
    expected = STIFFNESS * RELAXATION * WAY / END * -math.expm1(-END / longer)
    return abs(abs(results.summary["reactions"]["b.top"][1]) / expected - 1.0)


def test_a_bar_is_held_back_as_by_a_standard_solid_in_statics() -> None:
    """Spring, dashpot and bar in series, F = k T v (1 - exp(-t/T')), T' = T (1 + k/K); implicit Euler: first order."""
    errors = [error({"use": "newton", "steps": steps}) for steps in (8, 16)]
    assert errors[1] < 0.6 * errors[0] < 0.03


@pytest.mark.parametrize("integrator", ["central-difference", {"use": "implicit-dynamics", "steps": 50}])
def test_a_bar_is_held_back_as_by_a_standard_solid_in_steps_in_time(integrator: Any) -> None:
    """Fifty steps or more; the bar rings by the stress of its start, density c v, 1e-2 MPa of 0.6."""
    assert error(integrator) < 0.02


def test_paths_are_followed_where_effects_remember() -> None:
    assert "effects.0" in build(held_back("newton"), REGISTRY).history.laws


@pytest.mark.parametrize("use", ["central-difference", "implicit-dynamics", "newton"])
def test_memory_survives_a_restart_and_no_step_that_fails_advances_it(use: str, taken_up: Any) -> None:
    """Taken up by new parts half-way, and with steps that are taken back: the same bits."""
    scene = held_back(use).with_({"materials.m.use": "neo-hookean"})
    dt, steps = 2e-7 if use == "central-difference" else 1e-5, 8
    model, saved = taken_up(scene, REGISTRY, dt, steps)
    assert (model.state["effects.0"] != saved["state.effects.0"]).any()


FORGETFUL = """
from dataclasses import dataclass
from contactlab.api import Effect
from contactlab.api.plugin import Part, hookimpl


@dataclass(frozen=True)
class Forgetful(Effect):
    memory = ("x",)

    def bind(self, view):
        def add(time, force, dt, memory):
            force[0, 1] += memory["x"][0]

        return add


@hookimpl
def contactlab_parts():
    return [Part("effect", "forgetful", f"{__name__}:Forgetful", "gives no memory back")]
"""


def test_memory_that_is_not_given_back_is_named(tmp_path: Path) -> None:
    (tmp_path / "forgetful.py").write_text(FORGETFUL)
    registry = Registry(files=[tmp_path / "forgetful.py", PARTS])
    scene = Scene.from_data(held_back("newton").data | {"effects": [{"use": "forgetful"}]}, registry=registry)
    with pytest.raises(WrongAnswer, match="Forgetful: the function of bind gave NoneType, needed: a dict of memory"):
        build(scene, registry).bound_integrator().step(1e-5)
