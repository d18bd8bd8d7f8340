"""Nodes that supports hold along the surface together with what they touch: friction has no say in them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from contactlab_cases.dynamics import strip
from contactlab_cases.statics import static_job

from contactlab.api import Setup
from contactlab.cases.run_case import run_job, scene_of
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene


@pytest.mark.parametrize("algorithm", ["mortar-p0", "node-on-segment"])
@pytest.mark.parametrize("moved", [0.0, 0.02])
def test_only_what_is_held_on_both_sides_and_stays_passes_no_friction(algorithm: str, moved: float) -> None:
    """Halves of two blocks, the upper one softer: it spreads and sticks, but not on its plane of symmetry.

    Where the foot of the lower block is the floor's and is moved sideways under a node that is held, that node slides.
    """
    law = {"m": {"young": 100.0, "poisson": 0.4}, "stiff": {"young": 1000.0, "poisson": 0.0}}
    lower = strip((0.0, 4.0), (-1.0, 0.0), [4, 1]) | {"material": "stiff"}
    slide = {"ramp": "linear", "to": moved, "begin": 0.5, "duration": 0.5}
    job = static_job(
        "held", Setup(algorithm, element="q1"), law,
        {"upper": strip((0.0, 2.0), (0.0, 2.0), [2, 2]), "lower": lower},
        {"slave": "upper.bottom", "master": "lower.top", "friction": {"use": "coulomb", "mu": 0.8}},
        supports=[
            {"on": "upper.left", "ux": 0.0},
            {"on": "upper.top", "uy": {"ramp": "linear", "to": -0.01, "duration": 0.5}},
            {"on": "lower", "uy": 0.0, "ux": slide},
        ],
        time={"end": 1.0}, steps=2,
    )  # fmt: skip
    record = run_job(job, scene_of(job))
    assert record.finished, record.reason
    curve = record.curve()
    shear, pressure = (values[np.argsort(curve.x)] for values in (curve.shear, curve.pressure))
    if moved:
        assert shear == pytest.approx(0.8 * pressure, rel=1e-9)  # drawn along under all nodes, held or not
    elif algorithm == "node-on-segment":
        assert shear[0] == 0.0
        assert np.all(np.abs(shear[1:]) > 0.05 * pressure[1:])  # 0.14 and 0.62: they stick
    else:
        # its force is that of its own half cell: 3 eighths of its multiplier and 1 eighth of the next one's are none
        assert abs(3.0 * shear[0] + shear[1]) < 1e-12


def press_fit(algorithm: str, along: tuple[int, int], **contact: Any) -> Scene:
    """A quarter of a ring shrunk on a ring, with so many cells along the outer and the inner one."""
    rings = {"outer": ([10.0, 15.0], along[0]), "inner": ([5.0, 10.01], along[1])}
    return Scene.from_data(
        {
            "name": "fit",
            "integrator": {"use": "newton", "steps": 1, "stabilised": False},
            "materials": {"m": {"use": "linear-elastic", "young": 1000.0, "poisson": 0.3, "density": 1e-9}},
            "bodies": {
                name: {
                    "element": "q1",
                    "material": "m",
                    "mesh": {"use": "ring", "radii": radii, "cells": [cells, 1], "angles": [0.0, 90.0]},
                }
                for name, (radii, cells) in rings.items()
            },
            "contacts": [
                {
                    "slave": "outer.inner",
                    "master": "inner.outer",
                    "algorithm": algorithm,
                    "friction": {"use": "coulomb", "mu": 0.3},
                    "start": {"overlap": "ramp"},
                    **contact,
                }
            ],
            "supports": [
                {"on": f"{body}.{edge}", along: 0.0}
                for body in ("inner", "outer")
                for edge, along in {"start": "uy", "end": "ux"}.items()
            ],
        }
    )


@pytest.mark.parametrize("algorithm", ["mortar-p0", "mortar-p1"])
def test_curves_that_end_at_planes_of_symmetry_are_pressed_without_shear(algorithm: str) -> None:
    """Rings of like cells: all moves along radii.

    The facets at the ends lean by half of their turn, 11 degrees: along them the nodes at the planes approach.
    """
    results = simulate(press_fit(algorithm, (4, 4)))
    assert results.status == "finished", results.summary["reason"]
    curve = results.contact["contacts.0"].last
    assert np.all(curve.pressure > 0.2)
    assert np.abs(curve.shear).max() < 1e-6 * curve.pressure.max()  # 0.4 of it at the ends if these stuck


def test_nodes_that_friction_does_not_hold_are_free_in_the_equations_of_the_end() -> None:
    """Held to slip nowhere, they would be held twice along radii: `kept-gap` then found forces 4e5 times as large."""
    results = simulate(press_fit("mortar-dual", (10, 8), smooth=True))
    assert results.status == "finished", results.summary["reason"]
    assert "kept-gap" not in {warning.code for warning in results.warnings}
