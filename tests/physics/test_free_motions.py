"""Statics of bodies that nothing holds along a direction, and nothing drives: they move least."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tiers import some

from contactlab.results.results import Results
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene

GRAVITY: dict[str, Any] = {"effects": [{"use": "gravity", "acceleration": [0.0, -5e8]}]}
PRESSED: dict[str, Any] = {"supports": [{"on": "upper.top", "uy": {"ramp": "linear", "to": -0.01}}]}


def stacked(algorithm: str, loading: dict[str, Any], turned: float = 0.0) -> Results:
    """Two blocks of other meshes on a rigid floor, all without friction; turned by an angle [degrees]."""
    cos, sin = np.cos(np.radians(turned)), np.sin(np.radians(turned))
    blocks = {
        name: {
            "element": "q1", "material": "soft", "rotate": turned,
            "mesh": {"use": "rectangle", "x": [-1.0, 1.0], "y": [y, y + 1.0], "cells": [cells, 2]},
        }
        for name, y, cells in (("lower", 0.0, 4), ("upper", 1.0, 5))
    }  # fmt: skip
    return simulate(Scene.from_data({
        "integrator": {"use": "newton"},
        "materials": {"soft": {"use": "neo-hookean", "young": 1000.0, "poisson": 0.3, "density": 1e-9}},
        "bodies": blocks,
        "rigid": {"floor": {"line": [[5.0 * cos, 5.0 * sin], [-5.0 * cos, -5.0 * sin]]}},
        "contacts": [
            {"slave": "lower.bottom", "master": "floor", "algorithm": algorithm},
            {"slave": "upper.bottom", "master": "lower.top", "algorithm": algorithm},
        ],
        "record": {"frames": 1, "recorders": []},
    } | loading))  # fmt: skip


LOADINGS = {"gravity": GRAVITY, "pressed": PRESSED}
CASES = [("mortar-p0", "gravity"), ("mortar-p1", "pressed"), ("node-on-segment", "gravity"), ("gauss-point", "pressed")]


@pytest.mark.parametrize(("algorithm", "loading"), some(CASES, CASES[:2]))
def test_bodies_that_may_slide_without_resistance_do_not(algorithm: str, loading: str) -> None:
    """Meshes and loads are symmetric: so is the state of least motion, to round-off."""
    results = stacked(algorithm, LOADINGS[loading])
    assert results.status == "finished", results.reason
    x, u = results.layout.nodes, results.displacement
    assert np.abs(u[:, 1]).max() > 1e-4  # mm
    for body in results.layout.bodies:
        own = np.unique(body.cells)
        opposite = np.lexsort((x[own, 1].round(9), -x[own, 0].round(9)))
        order = np.lexsort((x[own, 1].round(9), x[own, 0].round(9)))
        mirrored = u[own][opposite] * [-1.0, 1.0]
        np.testing.assert_allclose(u[own][order], mirrored, rtol=0.0, atol=1e-8)


@pytest.mark.full
def test_directions_that_nothing_holds_may_lean() -> None:
    """A frame turned by 37 degrees: no body moves along its floor."""
    turn = np.radians(37.0)
    results = stacked("mortar-p1", {"effects": [
        {"use": "gravity", "acceleration": [5e8 * np.sin(turn), -5e8 * np.cos(turn)]}
    ]}, 37.0)  # fmt: skip
    assert results.status == "finished", results.reason
    u = results.displacement @ [np.cos(turn), np.sin(turn)]
    for body in results.layout.bodies:
        assert abs(float(u[np.unique(body.cells)].mean())) < 1e-9


def test_a_load_along_what_nothing_holds_is_told() -> None:
    """It has no equilibrium, however small it is."""
    results = stacked("mortar-p1", GRAVITY | {"loads": [{"on": "upper.top", "tx": 1e-4}], "integrator": {
        "use": "newton", "steps": 1, "stabilised": False
    }})  # fmt: skip
    assert results.status == "not-converged"
    assert "no support holds" in results.reason
    assert "against sliding along x" in results.reason
