"""Friction of surfaces that close within a load step: the run knows by how much its shear is off."""

from __future__ import annotations

import pytest

import contactlab
from contactlab.results.results import Results
from contactlab.scene.scene import Scene

GAP, DOWN, ALONG, YOUNG = 0.0035, 0.01, 0.002, 1000.0


def landed(steps: int, algorithm: str) -> Results:
    """A square that moves down by DOWN and along by ALONG; it touches a rough floor after 0.35 of both."""
    return contactlab.simulate(Scene.from_data({
        "format": 1, "name": "landing", "integrator": {"use": "newton", "steps": steps},
        "record": {"frames": 1, "recorders": []},
        "materials": {"m": {"use": "linear-elastic", "young": YOUNG, "poisson": 0.0, "density": 1e-9}},
        "bodies": {"b": {
            "material": "m", "element": "q1",
            "mesh": {"use": "rectangle", "x": [0.0, 1.0], "y": [GAP, 1.0 + GAP], "cells": [2, 1]},
        }},
        "rigid": {"floor": {"line": [[2.0, 0.0], [-1.0, 0.0]]}},
        "contacts": [{
            "slave": "b.bottom", "master": "floor", "algorithm": algorithm, "friction": {"use": "coulomb", "mu": 2.0},
        }],
        "supports": [{
            "on": "b.top", "ux": {"ramp": "linear", "to": ALONG}, "uy": {"ramp": "linear", "to": -DOWN},
        }],
    }))  # fmt: skip


@pytest.mark.parametrize("algorithm", ["mortar-p1", "node-on-segment"])
def test_the_slip_before_a_touch_that_friction_holds_in_error_is_told_with_its_share_of_the_shear(
    algorithm: str,
) -> None:
    stiffness, touch = YOUNG / 2.0, GAP / DOWN
    coarse, exact = landed(10, algorithm), landed(20, algorithm)
    # the floor holds since the touch, which is the end of a step: simple shear of the square
    assert exact.summary["reactions"]["b.top"][0] == pytest.approx(stiffness * ALONG * (1.0 - touch), rel=1e-6)
    assert not exact.warnings
    # in ten steps since the start of the one in which it closes
    assert coarse.summary["reactions"]["b.top"][0] == pytest.approx(stiffness * ALONG * 0.7, rel=1e-6)
    (warning,) = coarse.warnings
    assert (warning.code, warning.key) == ("friction-steps", "integrator.steps")
    # all is linear: the estimate is the error
    assert warning.value == pytest.approx((touch - 0.3) / 0.7, rel=1e-6)
