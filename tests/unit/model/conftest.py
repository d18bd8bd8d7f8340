"""Two small blocks, one on the other, to which tests add what they are about."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from contactlab.model.build import build
from contactlab.model.model import Model
from contactlab.parts.registry import default_registry
from contactlab.scene.scene import Scene

LAW = {"use": "linear-elastic", "young": 1000.0, "poisson": 0.25, "density": 1e-6}

Make = Callable[..., Model]


def blocks(**more: Any) -> Scene:
    """upper on lower, 2 x 1 each, meshes that do not match; `more` replaces tables of the scene."""
    body = {"element": "q1", "material": "m"}
    return Scene.from_data(
        {
            "name": "blocks",
            "time": {"end": 1e-3},
            "integrator": "central-difference",
            "materials": {"m": LAW},
            "bodies": {
                "upper": {**body, "mesh": {"use": "rectangle", "x": [0.0, 2.0], "y": [0.0, 1.0], "cells": [4, 2]}},
                "lower": {**body, "mesh": {"use": "rectangle", "x": [0.0, 2.0], "y": [-1.0, 0.0], "cells": [5, 2]}},
            },
            "contacts": [{"slave": "upper.bottom", "master": "lower.top", "algorithm": "mortar-p1"}],
            "supports": [{"on": "lower.bottom", "ux": 0.0, "uy": 0.0}],
            **more,
        }
    )


@pytest.fixture
def make() -> Make:
    """make(changes, **tables): the built model of `blocks`."""

    def made(changes: dict[str, Any] | None = None, **tables: Any) -> Model:
        return build(blocks(**tables).with_(changes or {}), default_registry())

    return made
