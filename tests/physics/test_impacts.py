"""Impacts in implicit steps: a bar against a wall and against its like, however few steps its contact is wished.

Contact lasts 2 L/c; the bar leaves the wall with the speed that it came with, and stops where it meets its like. Lumped
masses slow waves: the mesh of 50 cells takes 2 to 3 % of the speed, whatever the step (4 times as many cells: 1 %).
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
import pytest
from contactlab_cases.series import Series
from statics.bars import BAR, ENERGY, LENGTH, SOUND, SPEED, strip
from tiers import some

from contactlab.api import Floats
from contactlab.parts.registry import default_registry
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene
from contactlab.testing.scenarios.invariance import rotation_turns_the_answers
from contactlab.testing.subject import Subject

CELLS, CONTACT, ARRIVAL = 50, 2.0 * LENGTH / SOUND, 0.237
SHORT = {"frames": 4, "recorders": []}  # a watch keeps what tests look at, of every step


def found(steps: float, like: bool = False, impacts: bool = True) -> Mapping[str, Floats]:
    return run(steps, like, impacts)[0]


@cache
def run(steps: float, like: bool = False, impacts: bool = True) -> tuple[Mapping[str, Floats], dict[str, float]]:
    """Energies and speeds after every step of a run with so many wished `steps` in 2 L/c, and its warnings."""
    bodies: dict[str, Any] = {
        "bar": strip((0.0, LENGTH), (0.0, 1.0), [CELLS, 1], velocity=[-SPEED, 0.0], shift=[SPEED * ARRIVAL, 0.0])
    }
    more: dict[str, Any] = {}
    if like:
        bodies["wall"] = strip((-LENGTH, 0.0), (0.0, 1.0), [CELLS, 1])
    else:
        more["rigid"] = {"wall": {"line": [[0.0, -1.0], [0.0, 2.0]]}}
    data = {
        "name": "impact",
        "time": {"end": ARRIVAL + 1.5 * CONTACT, "step": CONTACT / steps},
        "integrator": {"use": "implicit-dynamics", "impacts": impacts},
        "materials": {"m": {"use": "linear-elastic"} | BAR},
        "bodies": bodies,
        "contacts": [{"slave": "bar.left", "master": "wall.right" if like else "wall", "algorithm": "mortar-p0"}],
        "supports": [{"on": name, "uy": 0.0} for name in bodies],
        "record": SHORT,
    }
    kept = Series(("time", "energy", "work.contact", *(f"velocity.{name}.x" for name in bodies)))
    results = simulate(Scene.from_data(data | more), watch={"kept": kept})
    assert results.status == "finished"
    return results.watched["kept"], {warning["code"]: warning["value"] for warning in results.summary["warnings"]}


@pytest.mark.parametrize("cells", [4, 40])
def test_energy_that_impacts_on_coarse_cells_take_is_told(cells: int) -> None:
    """The exact bar leaves with its energy and its speed; the bounds of the lost speed are those of the docs."""
    bar = strip((0.0, LENGTH), (0.0, 1.0), [cells, 1], velocity=[-SPEED, 0.0], shift=[SPEED * ARRIVAL, 0.0])
    scene = Scene.from_data({
        "time": {"end": ARRIVAL + 1.5 * CONTACT}, "integrator": "central-difference", "bodies": {"bar": bar},
        "materials": {"m": {"use": "linear-elastic"} | BAR}, "rigid": {"wall": {"line": [[0.0, -1.0], [0.0, 2.0]]}},
        "contacts": [{"slave": "bar.left", "master": "wall", "algorithm": "mortar-p0"}],
        "supports": [{"on": "bar", "uy": 0.0}], "record": SHORT,
    })  # fmt: skip
    results = simulate(scene, watch={"kept": Series(("work.contact", "velocity.bar.x"))})
    lost = -float(results.watched["kept"]["work.contact"][-1]) / ENERGY
    slower = 1.0 - float(results.watched["kept"]["velocity.bar.x"][-1]) / SPEED
    assert lost <= slower <= 3.0 * lost
    told = [warning.value for warning in results.warnings if warning.code == "impact-loss"]
    assert told == ([pytest.approx(lost, rel=1e-6)] if lost > 0.03 else [])
    assert bool(told) == (cells == 4)


@pytest.mark.parametrize(("wished", "after"), [({"steps": 86}, 0.0), ({"steps": 180}, 0.0), ({"steps": 86}, -1.0)])
def test_a_load_that_drops_at_once_sends_the_bar_off_at_its_speed(wished: dict[str, int], after: float) -> None:
    """p/(rho c), once the wave has reached the wall: a bar pressed slowly onto it, its load gone in 1e-9 of the time.

    A load that turns to the other side pulls in addition: 2 p/(rho c), and 1.4 p/(rho c) more in the time that is left.
    The tolerance is twice that of impacts: vibrations of the slow load have 1 %, and steps between waves are long. With
    equal steps alone 0.90 is left for 86 (0.92 of the load that turns), 0.93 for 180; and those that follow each way
    in ten steps found no equilibrium in 1e-13 s. The load rises and rests for whole periods of the bar, 2 CONTACT.
    """
    drop, pressure = 10.0 * CONTACT, 1e-3 * BAR["young"]
    points = [[0.0, 0.0], [0.8 * drop, 1.0], [drop, 1.0], [drop * (1.0 + 1e-9), after]]
    scene = Scene.from_data({
        "time": {"end": drop + 1.2 * CONTACT}, "integrator": {"use": "implicit-dynamics"} | wished,
        "materials": {"m": {"use": "linear-elastic"} | BAR},
        "bodies": {"bar": strip((0.0, LENGTH), (0.0, 1.0), [40, 1])},
        "rigid": {"wall": {"line": [[0.0, -1.0], [0.0, 2.0]]}},
        "contacts": [{"slave": "bar.left", "master": "wall", "algorithm": "mortar-p0"}],
        "supports": [{"on": "bar", "uy": 0.0}],
        "loads": [{"on": "bar.right", "pressure": {"to": pressure, "ramp": "table", "points": points}}],
        "record": SHORT,
    })  # fmt: skip
    results = simulate(scene, watch={"kept": Series(("velocity.bar.x",))})
    assert results.status == "finished"
    speed = results.watched["kept"]["velocity.bar.x"][-1] * BAR["density"] * SOUND / pressure
    assert speed == pytest.approx(1.0 - 2.4 * after, rel=0.02)


@pytest.mark.parametrize(
    ("wished", "pulse", "within"),
    [
        ({}, [[150.0, 0.0], [150.0 + 1e-6, 1.0], [160.0, 1.0], [160.0 + 1e-6, 0.0]], 1e-3),
        ({"steps": 500}, [[150.2, 0.0], [150.2 + 1e-6, 1.0], [150.7, 1.0], [150.7 + 1e-6, 0.0]], 1e-3),
        ({}, [[150.0, 0.0], [150.05, 1.0], [150.1, 0.0]], 0.05),
    ],
    ids=["ten steps", "half a step", "spike"],
)
def test_a_pulse_gives_its_impulse(wished: dict[str, int], pulse: list[list[float]], within: float) -> None:
    """I/m of a free bar, for pulses in units of a 500th of the time, longer and shorter than a step.

    Steps take the mean of both ends, and the one after a jump is a 32nd of a step: what a pulse loses where it begins
    it gains where it ends. The ten steps of each way of a spike begin up to half of one too late. Equal steps gave 0.95
    (ten steps), 0.86 (half a step) and 9 times the impulse (spike). A jump in 2e-9 of the time is one, not two with a
    step of its own between them, in which round-off left no equilibrium of a sliding block.
    """
    step = CONTACT / 10.0
    times, factors = np.array(pulse).T
    points = [[0.0, 0.0], *([step * time, factor] for time, factor in pulse)]
    scene = Scene.from_data({
        "time": {"end": 500.0 * step}, "integrator": {"use": "implicit-dynamics"} | wished,
        "materials": {"m": {"use": "linear-elastic"} | BAR},
        "bodies": {"bar": strip((0.0, LENGTH), (0.0, 1.0), [4, 1])},
        "loads": [{"on": "bar.left", "tx": {"to": 1.0, "ramp": "table", "points": points}}],
        "record": SHORT,
    })  # fmt: skip
    results = simulate(scene, watch={"kept": Series(("time", "velocity.bar.x"))})
    assert np.diff(results.watched["kept"]["time"]).min() > 1e-4 * step
    impulse = results.watched["kept"]["velocity.bar.x"][-1] * BAR["density"] * LENGTH
    assert impulse == pytest.approx(step * float(np.trapezoid(factors, times)), rel=within)


@pytest.mark.parametrize("steps", [10.0, 0.6])
def test_bar_leaves_a_wall_as_fast_as_it_came(steps: float) -> None:
    """Within what the mesh leaves of it, 2.6 %: for 10 steps and for half of one; contact takes half a cell."""
    kept = found(steps)
    assert kept["velocity.bar.x"][-1] / SPEED == pytest.approx(0.974, abs=2e-3)
    # the stopped node is 1/2N of the bar, and what is left open when a step ends where surfaces meet is below 1e-4
    assert -kept["work.contact"][-1] / ENERGY == pytest.approx(0.5 / CELLS, abs=1e-4)
    assert np.diff(kept["energy"]).max() < 1e-9 * ENERGY


@pytest.mark.full
def test_equal_bars_exchange_their_speeds() -> None:
    kept = found(10.0, like=True)
    assert -kept["velocity.wall.x"][-1] / SPEED == pytest.approx(1.0, abs=0.02)
    assert kept["velocity.bar.x"][-1] / SPEED == pytest.approx(0.0, abs=0.02)


def test_steps_as_they_are_lose_the_impact() -> None:
    """Ten steps: the midpoint rule smears fronts over 2/10 of the bar, and it leaves with 0.87 of its speed."""
    assert found(10.0, impacts=False)["velocity.bar.x"][-1] / SPEED < 0.9


def test_only_the_impact_is_cut() -> None:
    """Steps before it, and from some after it on, are those that the scene wishes."""
    lengths, wished = np.diff(found(10.0)["time"], prepend=0.0), CONTACT / 10.0
    np.testing.assert_allclose(lengths[:3], wished, rtol=1e-12)
    assert lengths[-3] == pytest.approx(wished, rel=1e-12)
    assert lengths.min() < 0.1 * wished


@pytest.mark.parametrize(("steps", "impacts"), [(0.6, True), (10.0, False)])
def test_few_wished_steps_in_a_contact_are_told(steps: float, impacts: bool) -> None:
    """With their number, by the time 2 L/c; waves slowed by the mesh and steps make it a little longer."""
    assert run(steps, False, impacts)[1]["few-steps-in-contact"] == pytest.approx(steps, rel=0.1 if impacts else 0.3)


def test_enough_steps_in_a_contact_are_not_told() -> None:
    assert "few-steps-in-contact" not in run(10.0, False, True)[1]


OBLIQUE = [("mortar-p0", 0.0), ("mortar-p0", 30.0), ("node-on-segment", 0.0)]


@pytest.mark.parametrize(("algorithm", "angle"), some(OBLIQUE, [OBLIQUE[1]]))
def test_friction_of_an_oblique_impact_is_mu_times_the_normal_impulse(algorithm: str, angle: float) -> None:
    """A block thrown on a rigid floor slides all the time: whatever it vibrates, it loses mu times what it turns round.

    The forces that are reported have these impulses.

    Momentum is kept to round-off and the floor is flat. What is left is that forces act along normals of a side that
    bends: 1e-6 here. Before impulses had their friction, the ratio was 0.105. The whole scene is turned by an angle.
    """
    along = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    up = np.array([-along[1], along[0]])
    scene = Scene.from_data({
        "name": "oblique", "time": {"end": 6e-5, "step": 4e-6}, "integrator": {"use": "implicit-dynamics"},
        "materials": {"m": {"use": "neo-hookean", "young": 5e4, "poisson": 0.3, "density": 1e-6}},
        "bodies": {"b": {
            "element": "q1", "material": "m",
            "velocity": (500.0 * (along - up)).tolist(), "shift": (0.01 * up).tolist(), "rotate": angle,
            "mesh": {"use": "rectangle", "x": [0.0, 1.0], "y": [0.0, 1.0], "cells": [4, 4]},
        }},
        "rigid": {"floor": {"line": [(9.0 * along).tolist(), (-9.0 * along).tolist()]}},
        "contacts": [{"slave": "b.bottom", "master": "floor", "algorithm": algorithm,
                      "friction": {"use": "coulomb", "mu": 0.1}}],
        "record": {"recorders": [], "frames": 1000},
    })  # fmt: skip
    results = simulate(scene)
    nodes = results.nodes[:25] @ np.stack([along, up], axis=1)
    share = np.prod(np.where(np.isclose(np.abs(nodes - nodes.mean(axis=0)), 0.5), 0.5, 1.0), axis=1) / 16.0
    gained = share @ results.velocity[:25] @ np.stack([along, up], axis=1) - [500.0, -500.0]
    assert gained[1] > 500.0  # it goes up again
    assert -gained[0] == pytest.approx(0.1 * gained[1], rel=1e-5)
    time = results.history["time"]
    pushed = np.stack([results.history[f"contacts.0.f{axis}"] for axis in "xy"], axis=1) @ up
    assert len(time) == results.summary["steps"] + 1
    assert (pushed[1:] * np.diff(time)).sum() == pytest.approx(1e-6 * gained[1], rel=1e-5)
    ledger = {name: results.history[f"energy.{name}"][-1] for name in ("friction", "error")}
    assert ledger["friction"] < 0.0
    assert abs(ledger["error"]) < 1e-8  # as iterations end


@pytest.mark.full
def test_steps_around_an_impact_do_not_depend_on_the_frame() -> None:
    """A scene that is turned takes the same steps and gives turned reactions, to 1e-6 of them."""
    rotation_turns_the_answers(Subject(default_registry(), "integrator", "implicit-dynamics"))


def unlike(enforcement: dict[str, Any], steps: int, angle: float = 0.0) -> tuple[Floats, Floats]:
    """Time over that in which waves run through both bars and back, and force over the exact one, of bars head on.

    Impedances z = (E rho)^(1/2) give the pressure 100 z1 z2/(z1 + z2) from the first touch to 1.
    """
    along = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    bodies: dict[str, Any] = {}
    for name, x, high, v in (("a", (-10.0, 0.0), 2, 60.0), ("b", (0.0, 10.0 * 2.0**0.5), 3, -40.0)):
        bodies[name] = strip(x, (0.0, 1.0), [40, high], velocity=(v * along).tolist(), rotate=angle, material=name)
    stuff = {"a": (1000.0, 1e-7), "b": (4000.0, 2e-7)}
    results = simulate(Scene.from_data({
        "name": "unlike", "time": {"end": 3.2e-4}, "integrator": {"use": "implicit-dynamics", "steps": steps},
        "materials": {name: {"use": "neo-hookean", "young": young, "poisson": 0.0, "density": density}
                      for name, (young, density) in stuff.items()},
        "bodies": bodies, "record": {"recorders": [], "frames": steps},
        "contacts": [{"slave": "b.left", "master": "a.right", "algorithm": "mortar-p0", "enforcement": enforcement}],
    }))  # fmt: skip
    assert results.status == "finished"
    z1, z2 = (float(np.sqrt(young * density)) for young, density in stuff.values())
    force = np.hypot(results.history["contacts.0.fx"], results.history["contacts.0.fy"])
    return results.history["time"] / 2e-4, force / (100.0 * z1 * z2 / (z1 + z2))


@pytest.mark.parametrize(
    ("enforcement", "steps", "angle"),
    [
        ({"use": "penalty"}, 50, 37.0),
        pytest.param({"use": "penalty"}, 100, 37.0, marks=pytest.mark.full),
        pytest.param({"use": "penalty", "factor": 1.0}, 100, 0.0, marks=pytest.mark.full),
        pytest.param({"use": "linear-pressure", "factor": 100.0}, 100, 0.0, marks=pytest.mark.full),
    ],
)
def test_stiff_springs_press_evenly(enforcement: dict[str, Any], steps: int, angle: float) -> None:
    """Without impulses they press with 0.28 to 1.84 times the pressure in turn.

    What is left is the ripple behind the front, which rises over a step: of first order, 5 % with 50 steps, 2.3 % with
    100. Exact multipliers cut their steps and have 1.2 %.
    """
    time, force = unlike(enforcement, steps, angle)
    inside = (time > 0.1) & (time < 0.9)
    np.testing.assert_allclose(force[inside], 1.0, atol=3.0 / steps)
    assert force[inside].mean() == pytest.approx(1.0, abs=0.2 / steps)  # the ripple goes to both sides


def test_a_wall_that_sets_a_bar_at_rest_in_motion_is_no_impact() -> None:
    """Round-off of the motion before counted as one, and steps were cut to 1e-21 s. The bar leaves at twice its speed.

    The tolerance is that of impacts and of steps that are not cut, some cells long.
    """
    rest, speed = 1e-5, 1e3  # times and stresses at which round-off had more energy than nothing
    steel = {"use": "linear-elastic", "young": 1000.0, "poisson": 0.3, "density": 1e-9}
    motion = {"to": 0.1, "ramp": "table", "points": [[0.0, 0.0], [rest, 0.0], [rest + 0.1 / speed, 1.0]]}
    scene = Scene.from_data({
        "time": {"end": 4e-5}, "integrator": {"use": "implicit-dynamics", "steps": 200}, "materials": {"m": steel},
        "bodies": {"bar": strip((0.0, 10.0), (0.0, 1.0), [40, 1])},
        "rigid": {"wall": {"line": [[0.0, -1.0], [0.0, 2.0]], "ux": motion}},
        "contacts": [{"slave": "bar.left", "master": "wall", "algorithm": "mortar-p1"}],
        "supports": [{"on": "bar", "uy": 0.0}], "record": SHORT,
    })  # fmt: skip
    results = simulate(scene, watch={"kept": Series(("velocity.bar.x",))})
    assert results.status == "finished", results.reason
    assert results.watched["kept"]["velocity.bar.x"][-1] / speed == pytest.approx(2.0, abs=0.08)
