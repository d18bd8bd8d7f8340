"""A rigid flat punch whose edge lies within a segment of the slave: the pressure inside is as good as on nodes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from contactlab_cases.statics import l2_error, ordered
from tiers import some

import contactlab

CELLS = 20  # in a half-width of 1 mm


def l2_of_pressure(algorithm: str, beyond: float) -> float:
    """L2 error over 0.9 of the contact; the edge lies by `beyond` segments beyond a node."""
    a = 1.0 + beyond / CELLS
    scene: dict[str, Any] = {
        "name": "punch", "time": {"end": 1.0}, "integrator": "newton",
        "materials": {"soft": {"use": "linear-elastic", "young": 1000.0, "poisson": 0.3, "density": 1e-9}},
        "bodies": {
            "block": {
                "element": "q1", "material": "soft",
                "mesh": {
                    "use": "rectangle", "x": [-10.0, -1.5, 1.5, 10.0], "y": [-20.0, 0.0],
                    "cells": [[12, 3 * CELLS, 12], 24], "grading": [[0.05, 1.0, 20.0], 0.003],
                },
            }
        },
        "rigid": {"punch": {"line": [[-a, 1.0], [-a, 0.0], [a, 0.0], [a, 1.0]], "uy": {"ramp": "linear", "to": -1e-4}}},
        "contacts": [{"slave": "block.top", "master": "punch", "algorithm": algorithm}],
        "supports": [{"on": "block.bottom", "ux": 0.0, "uy": 0.0}],
    }  # fmt: skip
    run = contactlab.simulate(contactlab.Scene.from_data(scene))
    curve, force = run.contact["contacts.0"].last, float(run.summary["reactions"]["block.bottom"][1])
    x, pressure = ordered(curve.x, curve.pressure)

    def exact(at: Any) -> Any:
        return force / (np.pi * np.sqrt(np.maximum(1e-9, a**2 - at**2)))  # Johnson 1985, 2.8

    return l2_error(x, pressure, exact, 0.9 * a)


@pytest.mark.parametrize("algorithm", some(["mortar-p1", "mortar-dual"], ["mortar-dual"]))
def test_an_edge_within_a_segment_costs_no_accuracy_inside(algorithm: str) -> None:
    """The root at the edge leaves its mark a cell inside whether a node is there or not: a quarter more, and 0.03."""
    on_node, *within = (l2_of_pressure(algorithm, beyond) for beyond in (0.0, 0.4, 0.6))
    assert max(within) < 1.25 * on_node + 0.03
