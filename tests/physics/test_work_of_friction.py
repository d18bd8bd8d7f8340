"""What friction takes in statics: the bound times the way that surfaces slide, in however few load steps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import contactlab
from contactlab.scene.scene import Scene

MU, PRESSURE, LENGTH, HEIGHT = 0.3, 2.0, 2.0, 0.25
SHEARED = 0.5 * MU * PRESSURE * HEIGHT / 50.0  # mm: half of the bound, at G = 50 MPa


COULOMB = {"use": "coulomb", "mu": MU}
TRESCA = {"use": "tresca", "stress": MU * PRESSURE}


def work(
    young: float, steps: int, algorithm: str, load: Any, along: dict[str, Any], friction: dict[str, Any] = COULOMB
) -> contactlab.Results:
    """A block on a rigid floor, pressed by a table of the time and moved along at its top by another."""
    mesh = {"use": "rectangle", "x": [0.0, LENGTH], "y": [0.0, HEIGHT], "cells": [8, 1]}
    results = contactlab.simulate(Scene.from_data({
        "time": {"end": along["points"][-1][0]},
        "integrator": {"use": "newton", "steps": steps},
        "materials": {"m": {"use": "linear-elastic", "young": young, "poisson": 0.0, "density": 1e-9}},
        "bodies": {"block": {"element": "q1", "material": "m", "mesh": mesh}},
        "rigid": {"floor": {"line": [[4.0, 0.0], [-2.0, 0.0]]}},
        "contacts": [{
            "slave": "block.bottom", "master": "floor", "algorithm": algorithm, "friction": friction,
        }],
        "loads": [{"on": "block.top", "ty": table(-PRESSURE, load)}],
        "supports": [{"on": "block.top", "ux": along}],
    }))  # fmt: skip
    assert results.status == "finished", results.reason
    return results


def table(to: float, points: list[list[float]]) -> dict[str, Any]:
    return {"ramp": "table", "to": to, "points": points}


@pytest.mark.parametrize(("algorithm", "friction"), [("mortar-p1", COULOMB), ("node-on-segment", TRESCA)])
def test_each_way_takes_the_bound_times_its_length(algorithm: str, friction: dict[str, Any]) -> None:
    """Pressed in the first step, then dragged to and fro, one load step each way.

    A slip stress acts on lengths that the last iteration changes: forces end up to 2e-5 below their bound.
    """
    along = table(1.0, [[0.0, 0.0], [1.0, 0.0], [2.0, 0.1], [3.0, -0.1], [4.0, 0.2]])
    results = work(1e5, 4, algorithm, [[0.0, 0.0], [1.0, 1.0]], along, friction)
    found = results.summary["balance"]
    # 1 %: the block gives way by 2 mu p h / E = 3e-6 at each turn, and its front edge is pressed harder
    assert found["friction"] == pytest.approx(MU * PRESSURE * LENGTH * (0.1 + 0.2 + 0.3), rel=0.01)
    assert results.history["energy.slip"][-1] == pytest.approx(found["friction"], rel=0.01)
    assert found["external"] == pytest.approx(found["friction"] + found["stored"], rel=0.01)
    assert found["ledger_error"] == pytest.approx(0.0, abs=1e-3 * found["friction"])


def test_a_bound_that_grows_with_the_slip_takes_half() -> None:
    """Pressed and dragged in one load step: forces and slips grow together."""
    results = work(1e5, 1, "mortar-p1", [[0.0, 0.0], [1.0, 1.0]], table(0.1, [[0.0, 0.0], [1.0, 1.0]]))
    taken = 0.5 * MU * PRESSURE * LENGTH * 0.1
    assert results.summary["balance"]["friction"] == pytest.approx(taken, rel=0.01)
    assert results.history["energy.slip"][-1] == pytest.approx(taken, rel=0.01)


def test_surfaces_that_slip_as_the_pressure_falls() -> None:
    """A sheared block is let slip: it slides from the force that held it, less than the bound at the start."""

    def taken(steps: int) -> float:
        load = [[0.0, 0.0], [1.0, 1.0], [2.0, 1.0], [3.0, 0.25]]
        results = work(
            100.0, steps, "mortar-p1", load, table(SHEARED, [[0.0, 0.0], [1.0, 0.0], [2.0, 1.0], [3.0, 1.0]])
        )
        time, friction = results.history["time"], results.history["energy.friction"]
        return float(np.interp(2.0, time, friction) - friction[-1])

    # 5 %: one step against twenty; with the bound at the start it is 60 % more
    assert taken(3) == pytest.approx(taken(60), rel=0.05)
