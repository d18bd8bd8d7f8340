"""A block in a rigid corner: its corner belongs to two flanks, and each takes the pressure of its own side."""

from __future__ import annotations

import numpy as np
import pytest

import contactlab
from contactlab.scene.scene import Scene


@pytest.mark.parametrize("turn", [0.0, 20.0])
@pytest.mark.parametrize(
    ("algorithm", "element"), [("node-on-segment", "q1"), ("node-on-segment", "q2"), ("mortar-p1", "q2")]
)
def test_each_flank_takes_the_pressure_of_its_side(algorithm: str, element: str, turn: float) -> None:
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))

    def turned(*points: tuple[float, float]) -> list[list[float]]:
        return (np.array(points) @ [[c, s], [-s, c]]).tolist()

    corners = turned((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    scene = Scene.from_data({
        "time": {"end": "auto"},
        "integrator": {"use": "newton", "steps": 2},
        "materials": {"m": {"use": "linear-elastic", "young": 1000.0, "poisson": 0.0, "density": 1e-9}},
        "bodies": {"block": {
            "element": element, "material": "m", "mesh": {"use": "quad-block", "corners": corners, "cells": [4, 4]},
        }},
        "rigid": {"box": {"line": turned((1.0, 2.0), (1.0, 0.0), (-1.0, 0.0))}},
        "contacts": [{"slave": ["block.bottom", "block.right"], "master": "box", "algorithm": algorithm}],
        "loads": [{"on": "block.top", "pressure": 1.0}, {"on": "block.left", "pressure": 0.5}],
    })  # fmt: skip
    results = contactlab.simulate(scene)
    assert results.status == "finished", results.reason
    curve = results.contact["contacts.0"].last
    # exact: a state of constant stress. Edges of finite strain shorten by p / E: pressures follow them by 1e-6
    np.testing.assert_allclose(curve.nodal_pressure[curve.chain == 0], 1.0, rtol=1e-5)
    np.testing.assert_allclose(curve.nodal_pressure[curve.chain == 1], 0.5, rtol=1e-5)
    contact = results.summary["contacts"]["contacts.0"]
    np.testing.assert_allclose(contact["pressure_integral"], contact["resultant"], rtol=1e-6)
