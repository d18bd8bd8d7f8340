"""Statics pass a loss of equilibrium by viscous forces: what is left at the end is in balance without them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import contactlab
from contactlab.results.results import Results
from contactlab.scene.scene import Scene

RISE, HALF, LOAD = 0.5, 5.0, 0.02
SOFT = {"use": "neo-hookean", "young": 1000.0, "poisson": 0.3, "density": 1e-9}
ARCH: dict[str, Any] = {
    "format": 1,
    "name": "arch",
    "integrator": {"use": "newton"},
    "materials": {"soft": SOFT},
    "bodies": {
        "arch": {
            "element": "q2",
            "material": "soft",
            "mesh": {
                "use": "quad-block",
                "corners": [[-HALF, -0.1], [HALF, -0.1], [HALF, 0.0], [-HALF, 0.0]],
                "bulge": [-RISE, 0.0, RISE, 0.0],
                "cells": [16, 1],
            },
        }
    },
    "supports": [{"on": f"arch.{side}", "ux": 0.0, "uy": 0.0} for side in ("left", "right")],
    "loads": [{"on": "arch.top", "ty": {"ramp": "linear", "to": -LOAD}}],
}


def arch(**changes: Any) -> Results:
    return contactlab.simulate(Scene.from_data(ARCH).with_({f"integrator.{key}": of for key, of in changes.items()}))


def test_an_arch_snaps_through_under_its_load_and_ends_where_it_would_without_viscous_forces() -> None:
    found = arch(steps=7)
    assert found.status == "finished"
    took, balance = found.summary["stabilisation"], found.summary["balance"]
    assert took["steps"] == 1
    assert took["work"] == balance["numerical"]
    # the jump: what the load did and the arch does not store; 15 % for works by the trapezoidal rule in a few substeps
    assert took["work"] == pytest.approx(balance["external"] - balance["stored"], rel=0.15)
    assert balance["ledger_error"] < 1e-8
    # supports carry the load alone, on the length of chords of 16 quadratic edges
    radius = (HALF**2 + RISE**2) / (2.0 * RISE)
    length = 2.0 * radius * np.arcsin(HALF / radius)
    held = np.add(found.summary["reactions"]["arch.left"], found.summary["reactions"]["arch.right"])
    np.testing.assert_allclose(held, [0.0, LOAD * length], atol=1e-6 * LOAD * length)
    assert {warning.code: warning.value for warning in found.warnings}["stabilised"] == took["share"] > 0.05
    # with other steps Newton's method happens to jump as well, and an elastic arch has one place to end in
    other = arch(steps=10)
    assert "stabilisation" not in other.summary
    np.testing.assert_allclose(other.displacement, found.displacement, atol=1e-6)


def test_without_stabilisation_statics_stop_there_and_say_why() -> None:
    stopped = arch(steps=7, stabilised=False)
    assert stopped.status == "not-converged"
    assert "snaps through" in stopped.reason
    assert "stabilisation" not in stopped.summary
