"""Keys of a scene do what they say, seen in motion and equilibrium: each test fails if its key is read wrongly."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from contactlab.api import Floats
from contactlab.model.build import build
from contactlab.run.guards import EVERY
from contactlab.run.schedule import Schedule
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene

MORTARS = ("mortar-p0", "mortar-p1")
LAW = {"use": "linear-elastic", "young": 1000.0, "poisson": 0.0, "density": 1e-6}


def rectangle(x: list[float], y: list[float], cells: list[int], **more: Any) -> dict[str, Any]:
    grading = {"grading": more.pop("grading")} if "grading" in more else {}
    return {
        "element": "q1",
        "material": "m",
        "mesh": {"use": "rectangle", "x": x, "y": y, "cells": cells, **grading},
    } | more


def scene(bodies: dict[str, Any], **more: Any) -> Scene:
    return Scene.from_data(
        {
            "name": "words",
            "time": {"end": 1.0},
            "integrator": "central-difference",
            "materials": {"m": LAW},
            "bodies": bodies,
            **more,
        }
    )


class Steps:
    """The steps of a scene, one by one."""

    def __init__(self, scene: Scene) -> None:
        self.model = build(scene, scene.registry)
        self.state, self.schedule = self.model.state, Schedule(self.model, scene)
        self.advance = self.model.bound_integrator().step

    def step(self) -> None:
        self.advance(self.schedule.dt)
        if self.state.step % EVERY == 0:
            self.schedule.adapt()

    def until(self, time: float) -> None:
        while self.state.time < time - 0.5 * self.schedule.dt:
            self.step()

    def mean(self, field: Floats, body: str) -> Floats:
        """Mean by mass of a nodal field (N, 2) over a body."""
        own = self._nodes(body)
        mass = self.model.mass[own]
        return np.asarray(mass @ field[own] / mass.sum())

    def _nodes(self, body: str) -> slice:
        found = next(b for b in self.model.bodies if b.name == body)
        return slice(found.first, found.first + found.count)

    def force_on(self, body: str) -> Floats:
        """Contact force (2,) [N] on a body in the last step."""
        return np.asarray(self.state["contact_force"][self._nodes(body)].sum(axis=0))

    def momentum(self) -> Floats:
        return np.asarray(self.model.mass @ self.state["velocity"])

    def angular_momentum(self) -> float:
        """About the origin, with positions half a step after the velocities, which leapfrog keeps exactly."""
        r, v = self.model.position, self.state["velocity"]
        return float(self.model.mass @ (r[:, 0] * v[:, 1] - r[:, 1] * v[:, 0]))


def test_velocity_spin_and_damping() -> None:
    """A free body keeps its velocity and spin about its centre; damping takes (1 - a dt/2)/(1 + a dt/2) a step."""
    body = rectangle([1.0, 3.0], [0.0, 1.0], [4, 2], velocity=[3.0, -2.0], spin=0.5, rotate=90.0, shift=[5.0, 1.0])
    alpha, dt, count = 4e3, 1e-5, 50
    run = Steps(scene({"body": body}, time={"end": 1.0, "step": dt, "damping": alpha}))
    centre = run.mean(run.model.reference, "body")
    # (2, 0.5) turned by 90 degrees about the origin, then shifted
    assert centre == pytest.approx([4.5, 3.0])
    assert run.state["velocity"][0] == pytest.approx(
        [3.0, -2.0] + 0.5 * np.array([-1.0, 1.0]) * (run.model.reference[0] - centre)[::-1]
    )
    for _ in range(count):
        run.step()
    # the first step is half a one
    first = (1.0 - 0.25 * alpha * dt) / (1.0 + 0.25 * alpha * dt)
    factor = first * ((1.0 - 0.5 * alpha * dt) / (1.0 + 0.5 * alpha * dt)) ** (count - 1)
    assert run.mean(run.state["velocity"], "body") == pytest.approx(np.array([3.0, -2.0]) * factor, rel=1e-12)
    assert factor == pytest.approx(math.exp(-alpha * (count - 0.5) * dt), rel=1e-3)


def test_fixed_steps_and_fractions_of_the_stable_one() -> None:
    """A fixed step is taken as it is; a fraction times the stable step, rounded down so that the end is met."""
    body = {"body": rectangle([0.0, 1.0], [0.0, 1.0], [2, 2])}
    fixed = Steps(scene(body, time={"end": 1e-3, "step": 1.7e-6}))
    limit, end = fixed.model.stable_step(), 1e-3
    assert fixed.schedule.dt == 1.7e-6
    for fraction in (0.9, 0.3):
        results = simulate(scene(body, time={"end": end, "fraction": fraction}, record={"frames": 1}))
        assert results.summary["steps"] == math.ceil(end / (fraction * limit) * (1.0 - 1e-12))
    # c = sqrt(E/rho), nu = 0: square cells of 0.5 allow h/c of a chain of springs
    assert limit == pytest.approx(0.5 / math.sqrt(1000.0 / 1e-6), rel=0.01)


def test_pressure_on_a_part_of_an_edge_turns_a_body() -> None:
    """Force and moment are those of the part: pressure 3 on 0.5 of a free body's top, 0.75 from its centre."""
    body = rectangle([0.0, 2.0], [0.0, 1.0], [4, 2], sets={"end": {"of": "top", "x": [1.5, 2.0]}})
    load = {"on": "body.end", "pressure": 3.0, "follower": False}
    run = Steps(scene({"body": body}, loads=[load], time={"end": 1.0, "step": 1e-6}))
    for _ in range(10):
        run.step()
    time = 9.5 * 1e-6  # the first step is half a one
    assert run.momentum() == pytest.approx([0.0, -1.5 * time], abs=1e-12 * time)
    about_centre = run.angular_momentum() - 1.0 * run.momentum()[1] + 0.5 * run.momentum()[0]
    # the loaded nodes move sideways by 1e-6 of their distance meanwhile
    assert about_centre == pytest.approx(-1.5 * 0.75 * time, rel=1e-5)


@pytest.mark.parametrize("algorithm", [*MORTARS, "node-on-segment"])
def test_a_moving_rigid_surface_presses_as_its_table_says(algorithm: str) -> None:
    """A plate goes down on a held block by 0.01, waits, and comes back by half: pressures E u/H = 10, then 5."""
    points = [[0.0, 0.0], [0.01, 1.0], [0.02, 1.0], [0.03, 0.5], [1.0, 0.5]]
    run = Steps(
        scene(
            {"block": rectangle([0.0, 1.0], [0.0, 1.0], [3, 2])},
            rigid={
                "plate": {"line": [[-0.5, 1.0], [1.5, 1.0]], "uy": {"ramp": "table", "to": -0.01, "points": points}}
            },
            contacts=[{"slave": "block.top", "master": "plate", "algorithm": algorithm}],
            supports=[{"on": "block.bottom", "ux": 0.0, "uy": 0.0}],
            time={"end": 1.0, "damping": 1e4},
        )
    )
    for time, force in ((0.02, -10.0), (0.04, -5.0)):
        run.until(time)
        # damped by exp(-1e4 t/2) for 0.01 s; consistent forces keep overlaps that solves leave, 1e-10 of a segment each
        assert run.force_on("block") == pytest.approx([0.0, force], abs=1e-7)
        assert run.model.reactions()["plate"][1] == pytest.approx(force, abs=1e-7)


@pytest.mark.parametrize("algorithm", MORTARS)
def test_two_masters_and_a_chain_of_graded_bodies_carry_a_uniform_pressure(algorithm: str) -> None:
    """A beam is slave on two bases and master of a block on it, all with graded meshes that do not match.

    nu = 0, heights 1 and 0.02 of shortening in 3: E u/H = 1000 x 0.02/3 everywhere, to the tolerance of the steps.
    """
    bodies = {
        "left": rectangle([0.0, 1.3], [0.0, 1.0], [5, 2], grading=[3.0, 1.0]),
        "right": rectangle([1.3, 3.0], [0.0, 1.0], [4, 2], grading=[0.4, 2.0]),
        "beam": rectangle([0.0, 3.0], [1.0, 2.0], [7, 2], grading=[0.3, 0.5]),
        "block": rectangle([0.0, 3.0], [2.0, 3.0], [6, 3], grading=[2.0, 1.0]),
    }
    results = simulate(
        scene(
            bodies,
            integrator={"use": "newton", "steps": 1, "tolerance": 1e-11},
            time={"end": "auto"},
            contacts=[
                {"slave": "beam.bottom", "master": ["left.top", "right.top"], "algorithm": algorithm},
                {"slave": "block.bottom", "master": "beam.top", "algorithm": algorithm},
            ],
            supports=[
                {"on": "left.bottom", "uy": 0.0}, {"on": "right.bottom", "uy": 0.0}, {"on": "left.left", "ux": 0.0},
                {"on": "right.left", "ux": 0.0}, {"on": "beam.left", "ux": 0.0}, {"on": "block.left", "ux": 0.0},
                {"on": "block.top", "uy": {"ramp": "linear", "to": -0.02}},
            ],
        )
    )  # fmt: skip
    assert results.status == "finished", results.reason
    for name in ("contacts.0", "contacts.1"):
        pressure = results.contact[name].last.pressure
        assert pressure == pytest.approx(np.full(len(pressure), 1000.0 * 0.02 / 3.0), rel=1e-8)


def test_nodes_beside_the_end_of_a_master_are_held() -> None:
    """Blocks of one width spread differently under load: their ends must not lose each other by that.

    A node up to two per cent of a segment beyond is held itself, and takes its share of what the end of the master
    presses on its segment from there on.
    """
    for beyond in (0.0, 1e-6, 0.015, 0.05, 0.3):
        run = Steps(
            scene(
                {
                    "upper": rectangle([0.0, 1.0 + 0.25 * beyond], [0.0, 1.0], [4, 1], velocity=[0.0, -10.0]),
                    "lower": rectangle([0.0, 1.0], [-1.0, 0.0], [4, 1]),
                },
                contacts=[{"slave": "upper.bottom", "master": "lower.top", "algorithm": "node-on-segment"}],
                supports=[{"on": "lower", "ux": 0.0, "uy": 0.0}],
                time={"end": 1.0, "step": 1e-6},
            )
        )
        run.step()
        end = int(np.argmax(run.model.reference[:, 0] - run.model.reference[:, 1] ** 2 * 100.0))
        assert run.state["contact_force"][end, 1] > 0.0
