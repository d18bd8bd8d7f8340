"""Energy of load steps: loads that are there from the start do the work of loads that grow."""

from __future__ import annotations

from typing import Any

import pytest

import contactlab
from contactlab.scene.scene import Scene

PRESSURE, YOUNG, LENGTH, HEIGHT = 2.0, 1000.0, 3.0, 0.5


def bar(steps: int, **more: Any) -> Scene:
    """A bar that does not bulge, held at its left end."""
    mesh = {"use": "rectangle", "x": [0.0, LENGTH], "y": [0.0, HEIGHT], "cells": [6, 1]}
    law = {"use": "linear-elastic", "young": YOUNG, "poisson": 0.0, "density": 1.0}
    return Scene.from_data(
        {
            "name": "bar",
            "integrator": {"use": "newton", "steps": steps},
            "materials": {"m": law},
            "bodies": {"bar": {"element": "q1", "material": "m", "mesh": mesh}},
            "supports": [{"on": "bar.left", "ux": 0.0, "uy": 0.0}],
            "record": {"recorders": []},
            **more,
        }
    )


@pytest.mark.parametrize("tx", [PRESSURE, {"ramp": "linear", "to": PRESSURE}])
@pytest.mark.parametrize("steps", [1, 3])
def test_a_load_from_the_start_does_half_its_force_times_the_way(tx: object, steps: int) -> None:
    results = contactlab.simulate(bar(steps, loads=[{"on": "bar.right", "tx": tx, "follower": False}]))
    stored = 0.5 * PRESSURE**2 / YOUNG * LENGTH * HEIGHT
    assert float(results.history["energy.external"][-1]) == pytest.approx(stored, rel=1e-9)
    assert float(results.history["energy.internal"][-1]) == pytest.approx(stored, rel=1e-9)


def test_a_load_from_the_start_and_one_that_follows_add_up() -> None:
    """From p to 2 p: stored are (2 p)^2/2, of which p^2/2 in the first step whatever its length."""
    grows = {"ramp": "linear", "to": PRESSURE}
    loads = [{"on": "bar.right", "tx": value, "follower": False} for value in (PRESSURE, grows)]
    results = contactlab.simulate(bar(4, loads=loads))
    stored = 2.0 * PRESSURE**2 / YOUNG * LENGTH * HEIGHT
    assert float(results.history["energy.internal"][-1]) == pytest.approx(stored, rel=1e-9)
    assert float(results.history["energy.external"][-1]) == pytest.approx(stored, rel=1e-9)


def test_weight_on_a_held_support_does_the_work_of_a_growing_one() -> None:
    """(rho g)^2 L^3 H/(6 E): nodes of the support are weighed, too, and do not move."""
    weight = {"use": "gravity", "acceleration": [1.0, 0.0]}
    results = contactlab.simulate(bar(1, effects=[weight]))
    stored = float(results.history["energy.internal"][-1])
    assert stored == pytest.approx(LENGTH**3 * HEIGHT / (6.0 * YOUNG), rel=0.05)  # six cells
    assert float(results.history["energy.external"][-1]) == pytest.approx(stored, rel=1e-9)
