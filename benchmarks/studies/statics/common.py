"""What the static scenes with exact answers share: scenes, figures of merit, the mortars and their slaves."""

from __future__ import annotations

from typing import Any

import numpy as np

from contactlab.api import Floats
from contactlab.scene.scene import Scene
from contactlab.testing.cases.figures import Figure

INF = float("inf")


def scene(name: str, steps: int, materials: dict[str, Any], contact: dict[str, Any], **more: Any) -> Scene:
    """Materials are linear elastic unless they say otherwise."""
    base = {"use": "linear-elastic", "density": 1.0}
    data = {
        "name": name,
        "integrator": {"use": "newton", "steps": steps},
        "materials": {key: base | values for key, values in materials.items()},
        "contacts": [contact],
        "record": {"recorders": [], "frames": 1},
    }
    return Scene.from_data(data | more)


def percent(says: str, value: float, most: float = INF) -> Figure:
    """A fraction, shown in percent; its criterion too."""
    return Figure(f"{says} %", 100.0 * value, -most, most)


def ordered(x: Floats, *values: Floats) -> tuple[Floats, ...]:
    """By increasing x."""
    order = np.argsort(x)
    return x[order], *(v[order] for v in values)
