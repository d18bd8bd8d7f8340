"""Loads that change as nodes move: their derivatives are part of Newton's matrix."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import contactlab
from contactlab.api import IterationRow
from contactlab.errors import SceneError
from contactlab.model.build import build
from contactlab.model.loading.load_stiffness import LoadStiffness
from contactlab.results.results import Results
from contactlab.run.simulation import simulate

BEAM = """
format = 1
name = "beam"

[integrator]
use = "newton"
steps = 2

[time]
end = 1.0

[materials.soft]
use = "neo-hookean"
young = 1000.0
poisson = 0.3
density = 1e-6

[bodies.beam]
element = "{element}"
material = "soft"
mesh = {{ use = "rectangle", x = [0.0, 10.0], y = [0.0, 1.0], cells = [20, 2] }}

[[supports]]
on = "beam.left"
ux = 0.0
uy = 0.0
"""
FOLLOWER = {
    "bodies.beam.mesh": {"use": "rectangle", "x": [0.0, 3.0], "y": [0.0, 1.0], "cells": [12, 4]},
    "loads": [{"on": "beam.top", "pressure": {"ramp": "linear", "to": 10.0}}],
    "integrator": {"use": "newton", "steps": 4},
}
SPRING = {
    "effects": [{"use": "spring", "on": "beam.right", "stiffness": [0.0, 50.0]}],
    "loads": [{"on": "beam.top", "ty": {"ramp": "linear", "to": -1.0}}],
}


def beam(tmp_path: Path, element: str = "q2", **changes: Any) -> Any:
    (tmp_path / "beam.toml").write_text(BEAM.format(element=element))
    return contactlab.load_scene(tmp_path / "beam.toml").with_(changes)


def squares(rows: Sequence[IterationRow]) -> bool:
    """Whether the last iteration of every step leaves no more than ten times the square of the residual before it.

    Two in a row may fall unevenly where a slender body bends, so that ratios of logarithms say little.
    """
    last = [pair for pair in pairwise(rows) if pair[1].step == pair[0].step]
    ends = {after.step: (before.force, after.force) for before, after in last}
    return all(after <= max(10.0 * before**2, 1e-11) for before, after in ends.values())


@pytest.mark.parametrize("element", ["q1", "q2"])
@pytest.mark.parametrize("kind", ["pressure", "shear"])
def test_derivatives_of_follower_loads_are_exact(tmp_path: Path, element: str, kind: str) -> None:
    """Forces are linear in positions, so that differences over any length are derivatives, up to round-off."""
    model: Any = build(*_with_registry(beam(tmp_path, element, loads=[{"on": "beam.top", kind: 0.7}])))
    draw = np.random.default_rng(1)
    model.state["displacement"][:] = draw.uniform(-0.1, 0.1, model.reference.shape)
    model.internal_force(0.0)
    matrix = model.stiffness(0.0)
    matrix.data[:] = 0.0
    model.add_load_stiffness(1.0, matrix, 1.0, 0.0)
    motion = draw.uniform(-0.1, 0.1, model.reference.shape)
    forces = []
    for side in (1.0, -1.0):
        model.state["displacement"][:] += side * motion
        model.internal_force(0.0)
        forces.append(np.zeros_like(motion))
        model.external_force(1.0, forces[-1])
        model.state["displacement"][:] -= side * motion
    change = 0.5 * (forces[0] - forces[1]).ravel()
    assert np.abs(change).max() > 1e-3
    np.testing.assert_allclose(-matrix @ motion.ravel(), change, atol=1e-12)


def test_follower_pressure_converges_quadratically(tmp_path: Path) -> None:
    """The beam is bent by half of its length."""
    results = simulate(beam(tmp_path, **FOLLOWER))
    assert results.status == "finished"
    assert not results.events
    assert results.displacement[:, 1].min() < -1.2
    assert squares(results.iterations)
    assert len(results.iterations) <= 20


def test_without_the_derivatives_it_does_not(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Otherwise the test before would prove nothing."""
    monkeypatch.setattr(LoadStiffness, "add", lambda *_: None)
    results = simulate(beam(tmp_path, **FOLLOWER))
    assert not squares(results.iterations)
    assert len(results.iterations) > 30


def test_springs_hold_what_they_should(tmp_path: Path) -> None:
    """Stiff springs at the end of a soft beam: without their derivatives this diverges however small the step is.

    The loads rest on the clamp and on the springs, whose stiffness of 50 N/mm is spread over the edge: Simpson's rule.
    """
    results = simulate(beam(tmp_path, **SPRING))
    assert results.status == "finished"
    assert not results.events
    assert squares(results.iterations)
    right = np.flatnonzero(np.isclose(results.layout.nodes[:, 0], 10.0))
    right = right[results.layout.nodes[right, 1].argsort()]
    pull = -50.0 * float(np.array([1.0, 4.0, 2.0, 4.0, 1.0]) @ results.displacement[right, 1]) / 12.0
    # 1 MPa on 10 mm; what the iteration leaves unbalanced is 1e-8 of the largest force at each of 200 nodes
    assert results.summary["reactions"]["beam.left"][1] + pull == pytest.approx(10.0, abs=1e-4)


def test_weight_in_statics(tmp_path: Path) -> None:
    """Masses are assembled for it although there is no inertia; weight = density times area times g."""
    results = simulate(beam(tmp_path, effects=[{"use": "gravity", "acceleration": [0.0, -1e4]}]))
    assert results.status == "finished"
    assert results.summary["reactions"]["beam.left"] == pytest.approx([0.0, 0.1], abs=1e-8)


def test_loads_near_round_off_converge(tmp_path: Path) -> None:
    """Steel under its own weight: forces are 1e-8 of those of a strain of one over the distance to the origin.

    Round-off of positions is then more than the tolerance. Both laws agree as far as the strains of 1e-8 let them, and
    the linear one knows no such round-off.
    """
    changes = {"effects": [{"use": "gravity", "acceleration": [0.0, -9810.0]}]}
    steel = {"young": 210000.0, "poisson": 0.3, "density": 7.85e-9}
    found = []
    for law in ("neo-hookean", "linear-elastic"):
        results = simulate(beam(tmp_path, **changes, **{"materials.soft": {"use": law} | steel}))
        assert results.status == "finished"
        assert not results.events
        found.append(results.displacement)
    np.testing.assert_allclose(found[0], found[1], atol=1e-6 * np.abs(found[1]).max())


def test_damping_of_vibrations_is_refused_in_statics(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="nothing vibrates in statics"):
        simulate(beam(tmp_path, **FOLLOWER, effects=[{"use": "vibration-damping", "rate": 10.0}]))


def test_an_effect_between_distant_nodes_is_not_mistaken(tmp_path: Path) -> None:
    """Differences of single nodes say nothing of a force that depends on centres of mass: nothing is added."""
    far = {
        "element": "q1",
        "material": "soft",
        "mesh": {"use": "rectangle", "x": [20.0, 21.0], "y": [3.0, 4.0], "cells": [2, 2]},
    }
    scene = beam(
        tmp_path, **{
            "bodies.far": far, "supports": [{"on": f"{body}.left", "ux": 0.0, "uy": 0.0} for body in ("beam", "far")],
            "effects": [{"use": "attraction", "between": ["beam", "far"], "force": 0.3}],
        }
    )  # fmt: skip
    model: Any = build(*_with_registry(scene))
    matrix = model.stiffness(0.0)
    before = matrix.data.copy()
    model.add_load_stiffness(1.0, matrix, 1.0, 0.0)
    np.testing.assert_array_equal(matrix.data, before)
    results = simulate(scene)
    assert results.status == "finished"
    pulls = [np.array(results.summary["reactions"][f"{body}.left"]) for body in ("beam", "far")]
    np.testing.assert_allclose(pulls[0], -pulls[1], atol=1e-7)
    assert np.hypot(*pulls[0]) == pytest.approx(0.3, rel=1e-6)


def test_steps_in_time_have_the_derivatives_too(tmp_path: Path) -> None:
    """Stiff springs against a soft, light beam in steps a hundred times the stable one."""
    results: Results = simulate(beam(tmp_path, **SPRING, integrator={"use": "implicit-dynamics", "steps": 10}))
    assert results.status == "finished"
    assert not [event for event in results.events if "rejected after" in event.text]
    assert results.summary["iterations"] <= 5 * results.summary["steps"]


def _with_registry(scene: Any) -> tuple[Any, Any]:
    return scene, scene.registry
