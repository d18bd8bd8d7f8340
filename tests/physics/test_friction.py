"""Friction: stopping distance, stick, the cone, and dissipation.

Either slave, the cone and the speed of loading on a disc are cells of the quick matrix (disc-with-friction).
"""

from __future__ import annotations

import numpy as np
import pytest
from contactlab_dynamics.gauss_seidel import solve_dense as solve

from contactlab.api import Solve
from contactlab.model.build import build
from contactlab.parts.registry import default_registry
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene, load_scene
from contactlab.testing.gap_rows import rows_from, turned

ALGORITHMS = ("node-on-segment", "mortar-p0", "mortar-p1")


def sliding_block(mu: float, speed: float, pressure: float, algorithm: str, rotate: float = 0.0) -> Scene:
    """A single stiff cell pressed on a held base by a prescribed top, sliding freely along it.

    The top's normal displacement is held, so the normal force is the elastic one of a given squeeze.
    """
    return Scene.from_data(
        {
            "name": "sliding-block",
            "time": {"end": 2e-3, "step": 1e-6},
            "integrator": "central-difference",
            "materials": {"soft": {"use": "linear-elastic", "young": 100.0, "poisson": 0.0, "density": 1e-6}},
            "bodies": {
                "block": {
                    "element": "q1",
                    "material": "soft",
                    "velocity": [speed, 0.0],
                    "mesh": {"use": "rectangle", "x": [0.0, 1.0], "y": [0.0, 1.0], "cells": [2, 1]},
                },
                "base": {
                    "element": "q1",
                    "material": "soft",
                    "mesh": {"use": "rectangle", "x": [-3.0, 5.0], "y": [-1.0, 0.0], "cells": [8, 1]},
                },
            },
            "contacts": [
                {
                    "slave": "block.bottom",
                    "master": "base.top",
                    "algorithm": algorithm,
                    "friction": {"use": "coulomb", "mu": mu},
                }
            ],
            "supports": [
                {"on": "base", "ux": 0.0, "uy": 0.0},
                {"on": "block.top", "uy": {"ramp": "constant", "to": -pressure / 100.0}},
            ],
        }
    )


def test_a_node_stops_when_friction_has_taken_its_momentum() -> None:
    """mass m at speed v0 under a load N stops after m v0/(mu N), within one step, and then stays put."""
    mass, speed, load, mu, dt = 2.0, 3.0, 5.0, 0.4, 1e-3
    position, velocity = np.zeros(2), np.array([speed, 0.0])
    compliance, normal = np.full((1, 2), dt * dt / mass), np.array([[[0.0, 1.0]]])
    multipliers, force = np.zeros((2, 1)), np.zeros((1, 2))
    stopped, resting = None, []
    for number in range(4000):
        velocity = velocity + dt / mass * np.array([0.0, -load])
        trial = position + dt * velocity
        # a wall y >= 0 with normal (0, 1); slip along x
        rows = rows_from(normal, trial[1:], tangent=turned(normal), slip=trial[:1] - position[:1], coefficient=mu)
        solve(rows.count, rows, compliance, multipliers, force, 1e-14, 50)
        moved = trial + compliance[0] * force[0]
        velocity, slip, position = (moved - position) / dt, moved[0] - position[0], moved
        if stopped is None and abs(slip) < 1e-15:
            stopped = number * dt
        elif stopped is not None:
            resting.append(abs(slip))
    assert stopped == pytest.approx(mass * speed / (mu * load), abs=dt)
    assert max(resting) < 1e-15  # no creep: friction is the force that stops the node within the step


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_friction_takes_exactly_the_momentum_the_block_loses(algorithm: str) -> None:
    """Momentum along the base changes by the contact impulse alone; the cone is kept; dissipation never falls."""
    mu, speed, pressure, dt = 0.2, 1.0, 1.0, 1e-6
    model = build(sliding_block(mu, speed, pressure, algorithm), default_registry())
    step = model.bound_integrator().step
    own = slice(model.bodies[0].first, model.bodies[0].first + model.bodies[0].count)
    momentum = model.mass[own].sum() * speed
    impulse, dissipated = 0.0, 0.0
    for number in range(500):
        step(dt)
        y = model.state["multipliers"]
        assert np.all(np.abs(y[1]) <= mu * y[0] * (1.0 + 1e-12) + 1e-15)
        assert model.state["work"][6] >= dissipated
        dissipated = model.state["work"][6]
        # half a step of acceleration starts the leapfrog
        impulse += (0.5 if number == 0 else 1.0) * dt * model.state["contact_force"][own, 0].sum()
    lost = momentum - model.mass[own] @ model.state["velocity"][own, 0]
    assert lost == pytest.approx(-impulse, rel=1e-9)  # round-off of 500 sums
    assert dissipated > 0.0


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_scene_without_friction_holds_nothing_tangential(algorithm: str) -> None:
    """No friction key: one row of multipliers, no tangent weights, no slip, no friction module."""
    model = build(load_scene("disc-on-block").with_({"contacts.0.algorithm": algorithm}), default_registry())
    assert model.contact is not None
    assert model.state["multipliers"].shape[0] == 1
    assert model.contact.rows.tangent_weight.shape == (0, 2)
    assert model.contact.rows.slip.size == model.contact.rows.bound.size == 0
    assert isinstance(model.contact.last, Solve)


@pytest.mark.parametrize("where", ["closed", "everywhere"])
def test_tresca_bounds_the_shear_where_it_says(where: str) -> None:
    """|y_t| <= s times length; "closed" rubs nowhere in the air, "everywhere" also where the gap is open."""
    scene = sliding_block(0.0, 5.0, 1.0, "mortar-p0").with_(
        {"contacts.0.friction": {"use": "tresca", "stress": 0.05, "where": where}}
    )
    lifted = scene.with_({"bodies.block.shift": [0.0, 0.02], "supports.1.uy": {"ramp": "constant", "to": 0.0}})
    for case, rubs in ((scene, True), (lifted, where == "everywhere")):
        model = build(case, default_registry())
        step = model.bound_integrator().step
        for _ in range(20):
            step(1e-6)
        contact = model.contact
        assert contact is not None
        (pair,) = contact.pairs
        tangential = np.abs(model.state["multipliers"][1, pair.own])
        assert np.all(tangential <= 0.05 * pair.cover * (1.0 + 1e-12))
        assert (tangential.max() > 0.0) == rubs


@pytest.mark.parametrize("algorithm", ["mortar-p0", "mortar-dual"])
def test_like_blocks_that_are_pressed_straight_stick_without_a_force(algorithm: str) -> None:
    """Plane strain, free sideways: E/(1 - nu^2) times the strain presses, and nothing slips."""
    body = {"element": "q1", "material": "m"}
    supports = [{"on": f"{name}.left", "ux": 0.0} for name in ("upper", "lower")]
    scene = Scene.from_data(
        {
            "integrator": "newton",
            "materials": {"m": {"use": "linear-elastic", "young": 1000.0, "poisson": 0.3, "density": 1000.0}},
            "bodies": {
                "upper": body | {"mesh": {"use": "rectangle", "x": [0.0, 2.0], "y": [0.0, 1.0], "cells": [4, 2]}},
                "lower": body | {"mesh": {"use": "rectangle", "x": [0.0, 2.0], "y": [-1.0, 0.0], "cells": [6, 2]}},
            },
            "contacts": [
                {
                    "slave": "upper.bottom",
                    "master": "lower.top",
                    "algorithm": algorithm,
                    "friction": {"use": "coulomb", "mu": 0.3},
                }
            ],
            "supports": [
                *supports,
                {"on": "lower.bottom", "uy": 0.0},
                {"on": "upper.top", "uy": -0.01},
            ],
            "record": {"recorders": []},
        }
    )
    results = simulate(scene)
    curve = results.contact["contacts.0"].last
    assert results.status == "finished"
    strain = 5e-3  # lengths change by it, and pressures with them
    np.testing.assert_allclose(curve.pressure, 1000.0 / (1.0 - 0.3**2) * strain, rtol=strain)
    assert np.abs(curve.shear).max() <= 1e-8 * curve.pressure.max()  # the tolerance of statics
