"""Corners that are rounded within a segment of the slave, with nodes on segments."""

from __future__ import annotations

import pytest

import contactlab
from contactlab.scene.scene import Scene

YOUNG, HEIGHT, LIFT = 1000.0, 1.0, 0.2


@pytest.mark.parametrize("radius", [0.2, 1.5])
@pytest.mark.parametrize("place", [15.0, 15.5, 15.7])
def test_a_small_roll_bends_a_cantilever_alike_under_a_node_and_between_two(radius: float, place: float) -> None:
    """3 E I w / a^3, with segments of length 1: the arc used to sink in by R - sqrt(R^2 - 1/4), all of it if small."""
    scene = Scene.from_data({
        "integrator": {"use": "newton", "steps": 2},
        "materials": {"steel": {"use": "linear-elastic", "young": YOUNG, "poisson": 0.0, "density": 1e-9}},
        "bodies": {
            "beam": {
                "element": "q2",
                "material": "steel",
                "mesh": {"use": "rectangle", "x": [0.0, 20.0], "y": [0.0, HEIGHT], "cells": [10, 1]},
            }
        },
        "rigid": {
            "roll": {
                "arc": {"centre": [place, -radius], "radius": radius, "angles": [0.0, 180.0]},
                "segment": 0.1 * radius,
                "uy": {"ramp": "linear", "to": LIFT},
            }
        },
        "contacts": [{"slave": "beam.bottom", "master": "roll", "algorithm": "node-on-segment"}],
        "supports": [{"on": "beam.left", "ux": 0.0, "uy": 0.0}],
    })  # fmt: skip
    results = contactlab.simulate(scene)
    assert results.status == "finished", results.reason
    bending = YOUNG * HEIGHT**3 / 12.0
    force = results.summary["reactions"]["roll"][1]
    # 1 %: the beam shears by 0.7 % of its deflection, and the roll touches up to 1.5 w R / a off its top
    assert abs(force) == pytest.approx(3.0 * bending * LIFT / place**3, rel=0.01)
