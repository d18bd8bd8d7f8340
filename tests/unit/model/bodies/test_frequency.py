"""The pace of a run does not depend on how its equations are solved."""

from __future__ import annotations

from typing import Any

import pytest

from contactlab.model.bodies import frequency
from contactlab.model.build import build
from contactlab.scene.scene import Scene, load_scene

COARSE = {"bodies.disc.mesh.cells": [8, 2], "bodies.block.mesh.cells": [12, 2]}
SEVERAL = {"bodies.billet.mesh.cells": [7, 4]}


def of_scene(name: str, changes: dict[str, Any]) -> Scene:
    return load_scene(name).with_({"time.end": "auto", **changes})


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("disc-on-block", COARSE),  # tied by joints of the two bodies
        ("disc-on-block", {**COARSE, "contacts": []}),  # each for itself
        ("three-body-forging", SEVERAL),
        ("stack", {}),  # bodies that only those beneath them hold
    ],
)
def test_dense_and_sparse_systems_give_the_same_pace(
    name: str, changes: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = of_scene(name, changes)
    periods = []
    for largest in (10**6, 0):
        monkeypatch.setattr(frequency, "SMALL", largest)
        periods.append(build(scene, scene.registry).timing.period)
    assert periods[0] > 0.0
    assert periods[0] == pytest.approx(periods[1], rel=1e-7)
