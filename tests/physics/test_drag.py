"""Ends and corners that drag on a flat plate: horizontal over vertical force is mu, whichever side is the slave."""

from __future__ import annotations

from typing import Any

import pytest
from tiers import some

import contactlab
from contactlab.scene.scene import Scene

MU = 0.2
BLOCK = {"use": "rectangle", "x": [-1.2, 0.0], "y": [0.0, 1.2], "cells": [8, 8]}
TIPS: dict[str, tuple[dict[str, Any], Any, str, float]] = {
    "end of a beam": (
        {"use": "rectangle", "x": [-6.0, 0.0], "y": [0.0, 0.6], "cells": [16, 2]}, "tip.bottom", "tip.left", -5.0,
    ),
    "edge of a block": (BLOCK, "tip.bottom", "tip.top", -20.0),
    "corner of a block": (BLOCK, ["tip.bottom", "tip.right"], "tip.top", -35.0),
}  # fmt: skip
"""By shape: mesh, surface, driven edge, rotation in degrees; the corner at the origin is lowest."""


def dragged(shape: str, algorithm: str, swap: bool) -> contactlab.Results:
    """Press the tip down on the plate, then drag it along, in statics."""
    mesh, surface, driven, turned = TIPS[shape]
    friction = {"use": "coulomb", "mu": MU}
    plate = {"use": "rectangle", "x": [-3.0, 3.013], "y": [-1.0, 0.0], "cells": [24, 4]}
    down = {"ramp": "linear", "to": -0.02 if "block" in shape else -0.3, "duration": 0.4}
    data: dict[str, Any] = {
        "format": 1,
        "name": shape,
        "integrator": {"use": "newton", "steps": 20},
        "materials": {
            "soft": {"use": "neo-hookean", "young": 2700.0, "poisson": 0.35, "density": 1.4e-9},
            "hard": {"use": "linear-elastic", "young": 210_000.0, "poisson": 0.3, "density": 7.8e-9},
        },
        "bodies": {
            "tip": {"element": "q1", "material": "soft", "mesh": mesh, "rotate": turned},
            "plate": {"element": "q1", "material": "hard", "mesh": plate},
        },
        "contacts": [
            {"slave": surface, "master": "plate.top", "algorithm": algorithm, "swap": swap, "friction": friction}
        ],
        "supports": [
            {"on": "plate.bottom", "ux": 0.0, "uy": 0.0},
            {"on": driven, "ux": {"ramp": "linear", "to": 0.3, "begin": 0.5, "duration": 0.4}, "uy": down},
        ],
    }
    return contactlab.simulate(Scene.from_data(data))


EACH = [(shape, name, swap) for shape in TIPS for name in ("mortar-p0", "mortar-p1", "node-on-segment")
        for swap in (False, True)]  # fmt: skip
"""By shape, algorithm, and whether the plate is the slave."""
SOME = [
    ("end of a beam", "mortar-p0", False), ("edge of a block", "mortar-p1", True),
    ("corner of a block", "node-on-segment", True),
]  # fmt: skip


@pytest.mark.parametrize(("shape", "algorithm", "swap"), some(EACH, SOME))
def test_friction_follows_the_plate(shape: str, algorithm: str, swap: bool) -> None:
    """To the angle by which the plate's surface leans where it is pressed in."""
    results = dragged(shape, algorithm, swap)
    assert results.status == "finished", results.reason
    fx, fy = results.summary["reactions"]["plate.bottom"]
    assert abs(fx / fy) == pytest.approx(MU, rel=5e-3)
