"""Runs with `end = "auto"`: what vibrates is damped, what is driven is not, and the way there is that of statics."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from contactlab_dynamics.central_difference import CentralDifference
from contactlab_statics.implicit_dynamics import ImplicitDynamics
from scipy.interpolate import CubicSpline
from scipy.linalg import expm
from tiers import some

from contactlab.api import Floats, Integrator
from contactlab.model.build import build
from contactlab.model.loading.ramps import ARRIVE, SET_OUT, Course, RampTime
from contactlab.results.results import Results
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene, load_scene
from contactlab.testing.oscillator import Oscillator

OMEGA, ALPHA, RELAXATION = 2.0, 0.4, 1.5


def exact(times: Floats) -> Floats:
    """Displacement, velocity and drift (t, 3) of an oscillator begun at speed 1, u' = v, v' = -w2 u - a (v - d)."""
    rates = np.array([[0.0, 1.0, 0.0], [-(OMEGA**2), -ALPHA, ALPHA], [0.0, 1.0 / RELAXATION, -1.0 / RELAXATION]])
    return np.array([expm(rates * time)[:, 1] for time in times])


@pytest.mark.parametrize("integrator", [CentralDifference(), pytest.param(ImplicitDynamics(), marks=pytest.mark.full)])
def test_a_vibration_fades_as_the_equations_say(integrator: Integrator) -> None:
    """Second order in the step, as without drift: (w dt)^2/12 of the phase at most, over 6 periods."""
    dt = 0.01
    mass = np.array([2.0])
    model = Oscillator(
        integrator, mass, OMEGA**2 * mass, velocity=np.array([[1.0, 0.0]]), damping=ALPHA, relaxation=RELAXATION
    )
    path = model.run(2000, dt)[:, 0, 0]
    expected = exact(dt * np.arange(1, 2001))[:, 0]
    assert path == pytest.approx(expected, abs=2e-4)
    assert np.abs(path[-320:]).max() < 0.03  # a period of w: damped, if a little less than without drift
    # what the spring held has gone into the damper, but for the little that moves yet
    internal, external, damping = model.state["work"][:3]
    assert model.kinetic_energy() + internal + damping - external == pytest.approx(1.0, abs=4.0 * dt)


def curve(results: Results) -> tuple[Floats, Floats, Floats]:
    """Way of the top, its force, and that of the bottom."""
    history = results.history
    return -history["disc.top.uy"], -history["disc.top.fy"], history["block.bottom.fy"]


def pressed(**changes: Any) -> Results:
    return simulate(load_scene("disc-on-block").with_({"level": 1} | changes))


def test_the_way_is_that_of_statics() -> None:
    """From 20 % of the way on within 1 % of load steps (0.4 found), top and bottom within 0.5 % (0.2).

    Damping takes 1e-5 of the work. With all motion damped the force is 24 % too large at 5 % of the way.
    """
    statics = pressed(**{"integrator": {"use": "newton", "steps": 10}, "record.frames": 1000})
    way, force, _ = curve(statics)
    explicit = pressed(**{"time.history": True})
    assert explicit.summary["history"]["curve"] == "quasi-static"
    moved, top, bottom = curve(explicit)
    late = moved >= 0.2 * moved.max()
    assert top[late] == pytest.approx(CubicSpline(way, force)(moved[late]), rel=0.01)
    assert top[late] == pytest.approx(bottom[late], rel=0.005)
    balance = explicit.summary["balance"]
    assert balance["damping"] < 1e-4 * balance["external"]
    assert not explicit.warnings


@pytest.mark.parametrize("algorithm", some(["node-on-segment", "mortar-p0", "mortar-p1"], ["mortar-p0", "mortar-p1"]))
def test_the_end_alone_is_that_of_statics(algorithm: str) -> None:
    """Without a history: the pressure to 1e-4 of its largest (1e-5 found), in a seventh of the steps of the way.

    What settled means bounds the reactions by 2e-4. The block is slave: nodes on segments chatter with the disc as one.
    """
    swap = {"contacts.0.swap": True, "contacts.0.algorithm": algorithm, "record.frames": 4}
    statics, explicit = (pressed(**swap, integrator=use) for use in ("newton", "central-difference"))
    assert explicit.status == "finished", explicit.reason
    assert explicit.summary["history"] == {"matters": False, "because": [], "curve": "the end only"}
    expected, found = (np.asarray(run.contact["contacts.0"].last.pressure) for run in (statics, explicit))
    # nodes on segments have several states: 2.5e-3 apart whatever the pace
    assert found == pytest.approx(expected, abs=(5e-3 if algorithm == "node-on-segment" else 1e-4) * expected.max())
    assert explicit.summary["reactions"]["disc.top"][1] == pytest.approx(
        statics.summary["reactions"]["disc.top"][1], rel=2e-4
    )
    assert explicit.summary["steps"] < 2000
    assert not {"damped-work", "contact-energy"} & {warning.code for warning in explicit.warnings}


def test_friction_asks_for_the_way_and_ends_as_statics_do() -> None:
    """tresca-block: stress under its load within 0.2 % of load steps (energy norm of displacements)."""
    # with the forces of load steps: consistent ones have another equilibrium, 1.5 % apart on this mesh
    frozen = {"use": "central-difference", "forces": "frozen"}
    statics, explicit = (simulate(load_scene("tresca-block").with_({"integrator": use})) for use in ("newton", frozen))
    assert explicit.status == "finished", explicit.reason
    assert explicit.summary["history"]["because"] == ["contacts.0.friction"]
    largest = np.abs(statics.displacement).max()
    assert explicit.displacement == pytest.approx(statics.displacement, abs=2e-3 * largest)


def test_what_a_scene_times_itself_is_followed() -> None:
    """A duration in seconds asks for the way, so that the run does not settle before it is over; statics need none."""
    keys = {"supports.1.uy": {"ramp": "parabola", "to": -0.1581, "duration": 1e-5}}
    scene = load_scene("disc-on-block").with_(keys)
    assert build(scene, scene.registry).history.because == ("supports.1.uy",)
    statics = scene.with_({"integrator": "newton"})
    assert not build(statics, statics.registry).history


def test_a_gentle_ramp_goes_along_its_shape_without_a_jolt() -> None:
    """Starts and ends at rest, and reaches the same states as the shape; and is hardly faster than the mean."""
    times = np.linspace(0.0, 2.0, 2001)
    run = RampTime(2.0, gentle=True)
    path = np.array([Course(1.0, "parabola").bind(run)(float(t)) for t in times])
    speed = np.gradient(path, times) * 2.0
    assert path[0] == pytest.approx(0.0, abs=1e-15)
    assert path[-1] == 1.0
    assert np.all(np.diff(path) >= 0.0)
    assert speed[:3] == pytest.approx(0.0, abs=1e-3)
    assert speed[-3:] == pytest.approx(0.0, abs=1e-3)
    assert speed.max() == pytest.approx(1.0 / (1.0 - 0.5 * (SET_OUT + ARRIVE)), rel=1e-6)
    # two shapes on one clock: where the parabola has come to 1 - (1 - q)^2, the line has come to q
    line = np.array([Course(1.0, "linear").bind(run)(float(t)) for t in times])
    assert path == pytest.approx(1.0 - (1.0 - line) ** 2, abs=1e-14)


def test_bodies_that_touch_are_paced_together() -> None:
    """Two flat blocks on each other, clamped below and driven above, vibrate as the one block of both heights does."""
    together, one = (build(scene, scene.registry).timing.period for scene in (stacked(2), stacked(1)))
    assert together == pytest.approx(one, rel=0.01)  # a hundredth of a cell's compliance lies in each tie
    apart = stacked(2, gap=0.1)
    # the taller one by itself: four of its heights are a wave's length, of the column two
    assert build(apart, apart.registry).timing.period == pytest.approx(1.5 * one, rel=0.1)


def stacked(blocks: int, gap: float = 0.0) -> Scene:
    """A column of 1 x 2, of one block or of two unlike ones with nodes of both sides in the same places."""
    body = {"element": "q1", "material": "m"}
    heights = [0.0, 0.5, 2.0] if blocks == 2 else [0.0, 2.0]
    data: dict[str, Any] = {
        "materials": {"m": {"use": "linear-elastic", "young": 1e3, "poisson": 0.3, "density": 1e-9}},
        "integrator": "central-difference",
        "bodies": {
            f"b{i}": {
                **body,
                "mesh": {"use": "rectangle", "x": [0.0, 1.0], "y": [low, high], "cells": [4, round(4 * (high - low))]},
                "shift": [0.0, gap * i],
            }
            for i, (low, high) in enumerate(pairwise(heights))
        },
        "supports": [
            {"on": "b0.bottom", "ux": 0.0, "uy": 0.0},
            {"on": f"b{blocks - 1}.top", "ux": 0.0, "uy": {"ramp": "parabola", "to": -0.01}},
        ],
    }
    if blocks == 2:
        data["contacts"] = [{"slave": "b1.bottom", "master": "b0.top", "algorithm": "mortar-p1"}]
    return Scene.from_data(data)


def test_too_fast_and_too_damped_runs_are_told() -> None:
    fast = pressed(**{"time.ramp": 3e-6, "time.hold": 1e-6})
    assert "unbalanced-reactions" in {warning.code for warning in fast.warnings}
    damped = pressed(**{"time.ramp": 1e-5, "time.hold": 1e-6, "time.relaxation": 0.0, "time.damping": 2e6})
    (told,) = [warning for warning in damped.warnings if warning.code == "damped-work"]
    assert told.value > told.limit == 0.02
    assert told.key == "time.ramp"


def test_a_column_that_is_let_go_is_at_rest() -> None:
    """Pressed and released: what vibrates on is judged by what has pressed, as nothing else is left to judge it by.

    Vibrations of the release are below a hundredth of the force, as inertia is with such a ramp.
    """
    times = {"ramp": "table", "to": -0.01, "points": [[0.0, 0.0], [2e-4, 1.0], [4e-4, 0.0]]}
    results = simulate(stacked(2).with_({"supports.1.uy": times}))
    assert results.status == "finished", results.reason
    assert "unbalanced-reactions" not in {warning.code for warning in results.warnings}
    history = results.history
    assert abs(history["energy.internal"][-1]) < 1e-4 * history["energy.internal"].max()  # 1 % of the motion, squared


@pytest.mark.parametrize("material", [None, {"use": "linear-hardening", "yield_stress": 1e-9, "hardening": 10.0}])
def test_damping_of_a_load_that_acts_at_once_is_told_where_the_way_matters(material: dict[str, Any] | None) -> None:
    """An elastic column has one place to rest in, however it falls there; a plastic one keeps what the fall made."""
    scene = stacked(1)
    changes: dict[str, Any] = {
        "supports": [{"on": "b0.bottom", "ux": 0.0, "uy": 0.0}],
        "effects": [{"use": "gravity", "acceleration": [0.0, -9810.0]}], "time.end": "auto",
    }  # fmt: skip
    if material is not None:
        changes["materials.m"] = scene.data["materials"]["m"] | material
    warnings = [warning for warning in simulate(scene.with_(changes)).warnings if warning.code == "damped-work"]
    assert [warning.key for warning in warnings] == ([] if material is None else ["effects.0.ramp"])
