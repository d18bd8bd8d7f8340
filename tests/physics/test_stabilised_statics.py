"""Statics pass a loss of equilibrium by viscous forces: what is left at the end is in balance without them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from stops import stopped_at

import contactlab
from contactlab.results.results import Results
from contactlab.run.interruption import Interrupted
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
    # 18 % of the work, and a right end: nothing in it depends on the way
    assert took["share"] > 0.05
    assert "stabilised" not in {warning.code for warning in found.warnings}
    # with other steps Newton's method happens to jump as well, and an elastic arch has one place to end in
    other = arch(steps=10)
    assert "stabilisation" not in other.summary
    np.testing.assert_allclose(other.displacement, found.displacement, atol=1e-6)


@pytest.mark.full
def test_without_stabilisation_statics_stop_there_and_say_why() -> None:
    stopped = arch(steps=7, stabilised=False)
    assert stopped.status == "not-converged"
    assert "snaps through" in stopped.reason
    assert "stabilisation" not in stopped.summary


def clip(algorithm: str) -> Results:
    """A clip (a beam 16 by 2 with a hook that rises by 1.8 over 3) is pushed over the sharp edge of a coarse plate."""
    x = np.concatenate([np.linspace(0.0, 16.0, 9), [16.5, 17.0, 18.0, 19.0, 20.0]])
    rows, number = [], {}
    for i, at in enumerate(x):
        lower = max(0.0, 1.1 * (at - 16.0) / 4.0)
        heights = list(np.linspace(lower, 2.0, 3))
        if at >= 16.0:
            tip = -1.5 + 0.6 * max(0.0, at - 17.0)
            heights = [tip, 0.5 * (tip + lower), *heights]
        for j, y in enumerate(heights):
            number[i, j - (len(heights) - 3)] = len(rows)
            rows.append((at, y))
    cells = [
        [number[i, j], number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]]
        for i in range(len(x) - 1)
        for j in range(-2 if x[i] >= 16.0 else 0, 2)
    ]
    hook = [number[8, j] for j in (0, -1, -2)] + [number[i, -2] for i in range(9, len(x))]
    root = [number[0, j] for j in range(3)]
    edges = {name: np.array([line[:-1], line[1:]]).T for name, line in (("hook", hook), ("root", root))}
    mesh = contactlab.mesh(np.array(rows), np.array(cells), edges)
    plate = {"use": "rectangle", "x": [20.3, 24.0], "y": [-4.0, -0.4], "cells": [4, 4]}
    scene = {
        "format": 1, "name": "clip", "integrator": {"use": "newton"},
        "materials": {"soft": SOFT, "steel": {**SOFT, "young": 1e5}},
        "bodies": {
            "clip": {"element": "q1", "material": "soft", "mesh": mesh},
            "plate": {"element": "q1", "material": "steel", "mesh": plate},
        },
        "contacts": [{
            "slave": "clip.hook", "master": ["plate.left", "plate.top"], "algorithm": algorithm,
            "friction": {"use": "coulomb", "mu": 0.2},
        }],
        "supports": [
            {"on": "plate.bottom", "ux": 0.0, "uy": 0.0},
            {"on": "clip.root", "ux": {"ramp": "linear", "to": 5.5}, "uy": 0.0},
        ],
        "record": {"frames": 1},
    }  # fmt: skip
    return contactlab.simulate(Scene.from_data(scene))


def test_a_clip_passes_a_sharp_edge_and_rests_on_the_plate_with_the_force_of_friction() -> None:
    """Nothing snaps: the hook slides over the corner, which holds it all the way, so that nothing is stabilised."""
    found = clip("mortar-p1")
    assert found.status == "finished"
    assert "stabilisation" not in found.summary
    along, across = found.summary["reactions"]["clip.root"]
    # the plate is level, and the clip slides on it
    assert along == pytest.approx(-0.2 * across, rel=1e-3)
    np.testing.assert_allclose(clip("node-on-segment").summary["reactions"]["clip.root"], [along, across], rtol=1e-3)


@pytest.mark.full
def test_a_belt_slides_on_its_drum_by_stabilised_steps_and_a_resumed_run_takes_the_same(tmp_path: Path) -> None:
    """A thin belt is pulled round a rigid drum: the last of its steps tells how the next one is tried."""
    radius, thick, angle, mu = 10.0, 0.1, 90.0, 0.2
    belt = {"use": "ring", "radii": [radius, radius + thick], "cells": [12, 1]}
    scene = Scene.from_data({
        "time": {"history": True},
        "integrator": {"use": "newton", "steps": 6},
        "materials": {"m": {"use": "neo-hookean", "young": 2e4, "poisson": 0.0, "density": 1e-9}},
        "bodies": {"belt": {"element": "q2", "material": "m", "mesh": {**belt, "angles": [45.0, 45.0 + angle]}}},
        "rigid": {"drum": {"arc": {"centre": [0.0, 0.0], "radius": radius, "angles": [-30.0, 210.0]}, "segment": 0.9}},
        "contacts": [{
            "slave": "belt.inner", "master": "drum", "algorithm": "mortar-p0", "friction": {"use": "coulomb", "mu": mu},
        }],
        "supports": [{"on": "belt.end", "turn": {"to": 0.5, "about": [0.0, 0.0], "ramp": "linear"}}],
        "loads": [{"on": "belt.start", "pressure": -1.0 / thick}],
    })  # fmt: skip
    whole = contactlab.simulate(scene)
    assert whole.status == "finished", whole.reason
    assert whole.summary["stabilisation"]["steps"] > 4
    # with a plain attempt before each stabilised step it is 54
    assert whole.summary["iterations"] < 40 * whole.summary["steps"]
    # Euler, Eytelwein: tension on the middle of the belt; 2 %: it bends, and its ends stand off by half a facet
    pull = float(np.hypot(*whole.summary["reactions"]["belt.end"]))
    assert pull == pytest.approx(np.exp(mu * np.radians(angle) * radius / (radius + 0.5 * thick)), rel=0.02)
    with pytest.raises(Interrupted), stopped_at(5):
        contactlab.simulate(scene, out=tmp_path / "cut")
    resumed = contactlab.simulate(scene, out=tmp_path / "cut", resume=True)
    assert resumed.summary["resumed_at_steps"] == [5]
    assert resumed.summary["iterations"] == whole.summary["iterations"]
    assert np.array_equal(resumed.displacement, whole.displacement)
