"""Tractions per length on a slave that overhangs its master: the drag is the slip stress times what is covered."""

from __future__ import annotations

from typing import Any

import pytest

import contactlab
from contactlab.scene.scene import Scene

STRESS, CELLS = 0.05, 10


def dragged(covered: float, algorithm: str, element: str = "q1", law: Any = None) -> contactlab.Results:
    """A block 1 mm wide lies with its first `covered` mm on a floor and is dragged along it by a little."""
    rough: dict[str, Any] = {"friction": {"use": "tresca", "stress": STRESS}} if law is None else {"enforcement": law}
    return contactlab.simulate(Scene.from_data({
        "format": 1, "name": "drag", "integrator": {"use": "newton", "steps": 2},
        "record": {"frames": 1, "recorders": []},
        "materials": {"m": {"use": "linear-elastic", "young": 1000.0, "poisson": 0.0, "density": 1e-9}},
        "bodies": {"b": {
            "material": "m", "element": element,
            "mesh": {"use": "rectangle", "x": [0.0, 1.0], "y": [0.0, 0.2], "cells": [CELLS, 1]},
        }},
        "rigid": {"floor": {"line": [[covered, 0.0], [-1.5, 0.0]]}},
        "contacts": [{"slave": "b.bottom", "master": "floor", "algorithm": algorithm, **rough}],
        "supports": [{
            "on": "b.top", "ux": {"ramp": "linear", "to": -0.001}, "uy": {"ramp": "linear", "to": -2e-5},
        }],
    }))  # fmt: skip


@pytest.mark.parametrize(("covered", "element"), [(0.501, "q1"), (0.331, "q1"), (0.371, "q1"), (0.331, "q2")])
def test_what_the_last_node_adds_to_the_drag_of_a_slip_stress_is_told(covered: float, element: str) -> None:
    found = dragged(covered, "node-on-segment", element)
    drag = abs(found.summary["reactions"]["b.top"][0])
    # the block is 1e-3 mm from where it lay
    exact = STRESS * (covered + 0.001)
    warning = {warning.code: warning.value for warning in found.warnings}["end-length"]
    assert warning == pytest.approx(1.0 - exact / drag, abs=2e-3)


@pytest.mark.parametrize("covered", [0.331, 0.371])
def test_a_mortar_integrates_over_the_cover(covered: float) -> None:
    """All of it slides at its bound, which moves with the forces that the corner of the floor takes."""
    found = dragged(covered, "mortar-p0")
    assert abs(found.summary["reactions"]["b.top"][0]) == pytest.approx(STRESS * (covered + 0.001), rel=1e-3)
    assert not {"end-length", "contact-pull"} & {warning.code for warning in found.warnings}
    assert found.summary["contacts"]["contacts.0"]["sticking"] == 0


def test_a_pressure_law_is_told_of_as_well() -> None:
    law = {"use": "linear-pressure", "stiffness": 10.0}
    found = dragged(0.331, "node-on-segment", law=law)
    # far softer than the block, so that the law presses by one pressure
    force = abs(found.summary["reactions"]["b.top"][1])
    warning = {warning.code: warning.value for warning in found.warnings}["end-length"]
    assert warning == pytest.approx(1.0 - 10.0 * 2e-5 * 0.332 / force, abs=5e-3)
