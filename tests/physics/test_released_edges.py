"""Load steps that were cut free multipliers gradually, and the last one ends as they do."""

from __future__ import annotations

import numpy as np
import pytest

from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene

STRENGTH = 1.0  # MPa


def test_a_punch_goes_all_the_way_into_what_flows_beside_its_edge() -> None:
    """Prandtl: (2 + pi) of the shear strength under a smooth or rough punch in plane strain.

    The block is the slave. A multiplier beside the edge was free after steps that had to be cut, and the last step
    merged it again, however short the step was: the run stopped at 99.99 % of the displacement.
    """
    soil = {"use": "linear-hardening", "young": 3000.0, "poisson": 0.3, "density": 1.0, "yield_stress": STRENGTH}
    results = simulate(Scene.from_data({
        "integrator": {"use": "newton", "steps": 8, "stabilised": False},
        "materials": {
            "soil": soil | {"hardening": 0.0},
            "stiff": {"use": "linear-elastic", "young": 3e6, "poisson": 0.0, "density": 1.0},
        },
        "bodies": {
            "block": {"element": "q2", "material": "soil", "mesh": {
                "use": "rectangle", "x": [0.0, 1.0, 10.0], "y": [-10.0, 0.0], "cells": [[4, 8], 8],
                "grading": [[0.207, 39.4], 0.0254]}},
            "punch": {"element": "q2", "material": "stiff", "mesh": {
                "use": "rectangle", "x": [0.0, 1.0], "y": [0.0, 0.5], "cells": [4, 2], "grading": [0.207, 1.0]}},
        },
        "contacts": [{"slave": "block.top", "master": "punch.bottom", "algorithm": "mortar-dual"}],
        "supports": [
            {"on": "block.bottom", "ux": 0.0, "uy": 0.0}, {"on": "block.left", "ux": 0.0},
            {"on": "punch.top", "ux": 0.0, "uy": {"ramp": "linear", "to": -0.02}},
        ],
        "record": {"recorders": []},
    }))  # fmt: skip
    assert results.status == "finished", results.reason
    force = -results.summary["reactions"]["punch.top"][1]
    assert force == pytest.approx((2.0 + np.pi) * STRENGTH / np.sqrt(3.0), rel=0.05)
