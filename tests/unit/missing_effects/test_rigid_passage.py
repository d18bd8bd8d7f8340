"""Bodies that go through a rigid surface beside their contact with it."""

from __future__ import annotations

import contactlab
from contactlab.scene.scene import Scene


def test_an_outline_that_is_slave_in_part_only() -> None:
    """Half of a bottom is in contact with a floor, the other half goes through it: the cure is more of the slave."""
    results = contactlab.simulate(
        Scene.from_data(
            {
                "integrator": {"use": "newton", "steps": 1},
                "materials": {"m": {"use": "linear-elastic", "young": 1000.0, "poisson": 0.3, "density": 1e-9}},
                "bodies": {
                    "block": {
                        "element": "q1",
                        "material": "m",
                        "mesh": {"use": "rectangle", "x": [0.0, 4.0], "y": [0.0, 1.0], "cells": [4, 1]},
                        "sets": {"half": {"of": "bottom", "x": [0.0, 2.0]}},
                    }
                },
                "rigid": {"floor": {"line": [[6.0, -0.01], [-2.0, -0.01]]}},
                "contacts": [{"slave": "block.half", "master": "floor", "algorithm": "node-on-segment"}],
                "supports": [{"on": "block.top", "ux": 0.0, "uy": {"ramp": "linear", "to": -0.6}}],
            }
        )
    )
    (warning,) = (warning for warning in results.warnings if warning.code == "contact")
    assert warning.key == "contacts.0.slave"
    assert "which is in no contact with it" in warning.text
    assert 'the edges there, which are in "block.' in warning.text
