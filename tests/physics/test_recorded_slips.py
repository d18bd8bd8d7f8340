"""Every contact algorithm with friction leaves its slips, node by node and step by step, under every integrator."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from contactlab.parts.registry import default_registry
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene

ASIDE = 0.1
IMPLICIT = "newton", "implicit-dynamics"
WAYS = {"newton": {"steps": 4}, "implicit-dynamics": {"steps": 40}, "central-difference": {}}
POTENTIALS = "barrier", "midplane"


def dragged(algorithm: str, integrator: str) -> Scene:
    """A block that lies on a floor and is dragged aside while it is pressed; it is at rest where there is inertia."""
    heavy = 1e-9 if integrator == "newton" else 1e-2  # waves take 0.02 s across: the loading is slow
    return Scene.from_data({
        "time": {"end": 1.0 if integrator != "newton" else "auto"},
        "integrator": {"use": integrator, **WAYS[integrator]},
        "materials": {"m": {"use": "neo-hookean", "young": 100.0, "poisson": 0.3, "density": heavy}},
        "bodies": {"b": {"element": "q1", "material": "m", "mesh": {
            "use": "rectangle", "x": [0.0, 4.0], "y": [0.0, 2.0], "cells": [4, 2]}}},
        "rigid": {"floor": {"line": [[9.0, 0.0], [-5.0, 0.0]]}},
        "supports": [{"on": "b.top", "ux": {"ramp": "linear", "to": ASIDE}, "uy": {"ramp": "linear", "to": -0.1}}],
        "contacts": [{"slave": "b.bottom", "master": "floor", "algorithm": algorithm,
                      "friction": {"use": "coulomb", "mu": 0.05}}],
    })  # fmt: skip


def every() -> Iterator[tuple[str, str]]:
    """Names of algorithms and integrators."""
    for name in default_registry().names("contact"):
        for integrator in IMPLICIT if name in POTENTIALS else WAYS:
            yield name, integrator


@pytest.mark.parametrize(("algorithm", "integrator"), list(every()))
def test_slips_of_all_steps_add_up_to_the_drag(algorithm: str, integrator: str, tmp_path: Path) -> None:
    """On a flat floor the slips of a node that never leaves it add up to its motion, to single precision of each."""
    results = simulate(dragged(algorithm, integrator), tmp_path / "run")
    assert results.status == "finished", results.reason
    slips = np.concatenate([rows["slip"] for block in results.contact_step_blocks() for rows in block.values()])
    total = slips.sum(axis=0, dtype=float)[1:-1]
    (contact,) = results.contact.values()
    moved = np.sort(contact.last.x - np.round(contact.last.x))[1:-1]  # nodes were at 0, 1, .. 4 mm
    assert np.all(moved > 0.5 * ASIDE)
    np.testing.assert_allclose(np.sort(np.abs(total)), moved, rtol=1e-4)
