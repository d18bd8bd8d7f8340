"""Load steps of a body that flows in a direction that turns: second order in the step."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from contactlab_solids.power_law import PowerLaw
from tiers import some

import contactlab
from contactlab.scene.scene import Scene

LAW = {
    "use": "power-law", "young": 7000.0, "poisson": 0.3, "density": 2.7e-9, "strength": 100.0, "prestrain": 0.02,
    "exponent": 0.1,
}  # fmt: skip


def reaction(element: str, steps: int) -> Any:
    """Force on the bottom of a block that is flattened, and sheared more and more as it is."""
    mesh = {"use": "rectangle", "x": [0.0, 3.0], "y": [0.0, 3.0], "cells": [3, 3]}
    scene = Scene.from_data({
        "time": {"end": 1.0},
        "integrator": {"use": "newton", "steps": steps},
        "materials": {"m": LAW},
        "bodies": {"block": {"element": element, "material": "m", "mesh": mesh}},
        "supports": [
            {"on": "block.bottom", "ux": 0.0, "uy": 0.0},
            {"on": "block.top", "ux": {"ramp": "parabola", "to": 0.3}, "uy": {"ramp": "linear", "to": -0.2}},
        ],
        "record": {"frames": 1, "recorders": []},
    })  # fmt: skip
    results = contactlab.simulate(scene)
    assert results.status == "finished", results.reason
    return np.array(results.summary["reactions"]["block.bottom"])


@pytest.mark.parametrize("element", some(["q1", "q1-fbar"], ["q1-fbar"]))
def test_flow_that_turns_is_of_second_order_in_the_load_step(element: str, monkeypatch: pytest.MonkeyPatch) -> None:
    exact = reaction(element, 100)
    size = np.linalg.norm(exact)
    errors = [float(np.linalg.norm(reaction(element, steps) - exact) / size) for steps in (5, 10, 20)]
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert orders.min() > 1.6, errors
    monkeypatch.setattr(PowerLaw, "implicit_euler", False)
    alone = float(np.linalg.norm(reaction(element, 20) - exact) / size)
    assert errors[-1] < 0.15 * alone, (errors, alone)
