"""Energy of the explicit scheme: what is conserved exactly, what to second order, and when a run is stopped."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import contactlab
from contactlab.api import Floats
from contactlab.errors import SimulationFailure
from contactlab.model.build import build
from contactlab.model.model import Model
from contactlab.parts.registry import default_registry
from contactlab.results.energies import energies
from contactlab.run.guards import Guards
from contactlab.scene.scene import Scene


def square(cells: int = 3, law: str = "linear-elastic", **more: Any) -> Scene:
    """A free unit square of h = 1/cells with E = 1, nu = 0.3, rho = 1: c_p = 1.16."""
    mesh = {"use": "rectangle", "x": [0.0, 1.0], "y": [0.0, 1.0], "cells": [cells, cells]}
    return Scene.from_data(
        {
            "name": "square",
            "time": {"end": 1e9},
            "integrator": "central-difference",
            "materials": {"m": {"use": law, "young": 1.0, "poisson": 0.3, "density": 1.0}},
            "bodies": {"square": {"element": "q1", "material": "m", "mesh": mesh}},
            **more,
        }
    )


def shaken(scene: Scene, speed: float, seed: int = 1) -> Model:
    """The model with random velocities up to `speed`, smooth enough for a mesh: of single nodes."""
    model = build(scene, default_registry())
    model.state["velocity"][:] = np.random.default_rng(seed).uniform(-speed, speed, model.reference.shape)
    model.start.energy = model.kinetic_energy()
    return model


def hold_in_place(model: Model) -> None:
    """Take the rigid motion out of the velocities: far from its place a body has fewer digits for its strains."""
    x, y = (model.reference - 0.5).T
    modes = np.stack([np.stack([x**0, 0 * x], 1), np.stack([0 * x, x**0], 1), np.stack([-y, x], 1)])
    momenta = np.einsum("n,kni,lni->kl", model.mass, modes, modes)
    v = model.state["velocity"]
    v -= np.tensordot(np.linalg.solve(momenta, np.einsum("n,kni,ni->k", model.mass, modes, v)), modes, 1)
    model.start.energy = model.kinetic_energy()


def discrete_energy(model: Model, internal: Floats) -> float:
    """H = 1/2 v M v + 1/2 u_n K u_{n+1}, with `internal` = K u_n."""
    return model.kinetic_energy() + 0.5 * float((internal * model.state["displacement"]).sum())


def test_h_is_kept_over_a_hundred_thousand_steps() -> None:
    """1.5 (a): drift of the energy that leapfrog conserves is round-off, 1e5 steps at 0.9 of the limit, no trend."""
    model = shaken(square(), 0.1)
    hold_in_place(model)
    advance = model.bound_integrator().step
    dt = 0.9 * model.stable_step()
    seen = []
    for i in range(100_000):
        if i % 1000 == 0:
            internal = model.state["internal_force"].copy()
            advance(dt)
            seen.append(discrete_energy(model, internal))
        else:
            advance(dt)
    drift = np.array(seen) / seen[0] - 1.0
    # round-off of single evaluations, which a trend of one unit per step would exceed a thousand times
    assert np.abs(drift).max() < 1e-12
    halves = drift[:50].mean(), drift[50:].mean()
    assert abs(halves[1] - halves[0]) < 1e-13


@pytest.mark.parametrize("law", ["linear-elastic", "neo-hookean"])
def test_ledger_closes_to_round_off(law: str) -> None:
    """Kinetic energy and the work of the stresses, with mean velocities and forces at one time, sum to a constant."""
    model = shaken(square(law=law), 0.1)
    advance = model.bound_integrator().step
    dt = 0.9 * model.stable_step()
    for _ in range(500):
        advance(dt)
    assert energies(model)["error"] < 1e-12


@pytest.mark.parametrize("law", ["linear-elastic", "neo-hookean"])
def test_stored_energy_is_the_ledgers_to_second_order(law: str) -> None:
    """1.5 (b): halving dt divides the difference of stored energy and booked work by 4 within 10 %.

    Work booked with mean velocities belongs to the middle of the last step, stored energy to its ends.
    """
    differences = []
    for halving in range(5):
        model = shaken(square(law=law), 0.0)
        smooth = np.sin(np.pi * model.reference)  # resolved by the mesh and by the step
        model.state["velocity"][:] = 0.1 * smooth
        model.start.energy = model.kinetic_energy()
        advance = model.bound_integrator().step
        dt = 0.4 * 0.2 / 2**halving
        for _ in range(4 * 2**halving - 1):
            advance(dt)
        before = energies(model)["stored"]
        advance(dt)
        found = energies(model)
        differences.append(abs(0.5 * (before + found["stored"]) - found["internal"]))
    ratios = np.array(differences[:-1]) / differences[1:]
    assert ratios[-1] == pytest.approx(4.0, rel=0.1)


def test_translation_takes_no_work() -> None:
    """1.5 (c): a body in free flight, finite strain, 1000 steps: nothing is booked and nothing is stored."""
    model = build(square(law="neo-hookean"), default_registry())
    model.state["velocity"][:] = [3.0, -2.0]
    advance = model.bound_integrator().step
    for _ in range(1000):
        advance(0.01)
    # stresses are round-off of the moduli; velocities of order one make that the work
    np.testing.assert_allclose(model.state["work"], 0.0, atol=1e-12)
    np.testing.assert_allclose(model.state["displacement"], np.tile([30.0, -20.0], (16, 1)), atol=1e-10)


def test_rotation_by_any_angle_takes_no_work() -> None:
    """A finite law in a body turned rigidly has no stress, so no nodal force and no energy."""
    model = build(square(law="neo-hookean"), default_registry())
    for angle in (0.1, 1.0, 3.0):
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        model.state["displacement"][:] = model.reference @ turn - model.reference
        model.internal_force(0.0)
        np.testing.assert_allclose(model.state["internal_force"], 0.0, atol=1e-14)
        assert energies(model)["stored"] == pytest.approx(0.0, abs=1e-14)


def test_a_spinning_body_keeps_its_angular_momentum() -> None:
    """Internal forces of a symmetric stress have no moment: free spin with finite deformation."""
    model = build(square(law="neo-hookean"), default_registry())
    x = model.reference - 0.5
    model.state["velocity"][:] = np.stack([-x[:, 1], x[:, 0]], axis=1) * 0.3
    advance = model.bound_integrator().step

    def momentum() -> float:
        # v half a step before the position: leapfrog keeps x_{n+1} x v_{n+1/2} exactly
        r, v = model.position, model.state["velocity"]
        return float(model.mass @ (r[:, 0] * v[:, 1] - r[:, 1] * v[:, 0]))

    advance(0.02)
    start = momentum()
    for _ in range(2000):
        advance(0.02)
    assert momentum() == pytest.approx(start, rel=1e-11)


# --- beyond the limit -------------------------------------------------------------------------------


def test_growth_beyond_the_limit_is_that_of_theory_and_is_flagged() -> None:
    """1.5 (d): at 1.02 of the limit of a single square the fastest mode grows by s + sqrt(s^2 - 1) = 1.49 a step."""
    model = shaken(square(cells=1), 1e-6)
    advance, guards = model.bound_integrator().step, Guards(model)
    dt = 1.02 * model.stable_step()
    s = 2.0 * 1.02**2 - 1.0
    guards.check()  # speeds of 1e-6 are nothing to stop for
    speeds = []
    for _ in range(60):
        advance(dt)
        speeds.append(float(np.abs(model.state["velocity"]).max()))
    growth = np.array(speeds[31:]) / speeds[30:-1]
    np.testing.assert_allclose(growth, s + np.sqrt(s * s - 1.0), rtol=1e-3)
    assert s + np.sqrt(s * s - 1.0) == pytest.approx(1.49, abs=0.005)
    with pytest.raises(SimulationFailure, match="moves at"):
        guards.check()


def test_below_the_limit_nothing_grows() -> None:
    model = shaken(square(cells=1), 1e-6)
    advance = model.bound_integrator().step
    dt = 0.999 * model.stable_step()
    for _ in range(2000):
        advance(dt)
    assert np.abs(model.state["velocity"]).max() < 1e-4


def test_too_long_a_step_is_refused_by_the_number_that_is_stable() -> None:
    """The whole way from a scene."""
    scene = square(cells=4, supports=[{"on": "square.bottom", "ux": 0.0, "uy": 0.0}])
    limit = build(scene, default_registry()).stable_step()
    wrong = scene.with_({"time.end": 400 * limit, "time.step": 1.3 * limit, "bodies.square.velocity": [0.0, 0.01]})
    with pytest.raises(contactlab.ContactlabError, match=f"at most {limit:.6g}"):
        contactlab.simulate(wrong)
    right = wrong.with_({"time.step": 0.95 * limit})
    assert contactlab.simulate(right).status == "finished"
