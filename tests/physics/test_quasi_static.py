"""Runs with `end = "auto"`: what vibrates is damped, what is driven is not, and the way there is that of statics."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from contactlab_dynamics.central_difference import CentralDifference
from contactlab_statics.implicit_dynamics import ImplicitDynamics
from scipy.interpolate import CubicSpline
from scipy.linalg import expm

from contactlab.api import Floats, Integrator
from contactlab.results.results import Results
from contactlab.run.simulation import simulate
from contactlab.scene.scene import load_scene
from contactlab.testing.oscillator import Oscillator

OMEGA, ALPHA, RELAXATION = 2.0, 0.4, 1.5


def exact(times: Floats) -> Floats:
    """Displacement, velocity and drift (t, 3) of an oscillator begun at speed 1, u' = v, v' = -w2 u - a (v - d)."""
    rates = np.array([[0.0, 1.0, 0.0], [-(OMEGA**2), -ALPHA, ALPHA], [0.0, 1.0 / RELAXATION, -1.0 / RELAXATION]])
    return np.array([expm(rates * time)[:, 1] for time in times])


@pytest.mark.parametrize("integrator", [CentralDifference(), ImplicitDynamics()])
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
    """From 20 % of the way on within 2 % of load steps, top and bottom within 1 %; damping takes 0.06 % of the work.

    With all motion damped the force is 24 % too large at 5 % of the way and 4.6 % at 20 %.
    """
    statics = pressed(**{"integrator": {"use": "newton", "steps": 20}, "record.frames": 1000})
    way, force, _ = curve(statics)
    explicit = pressed()
    moved, top, bottom = curve(explicit)
    late = moved >= 0.2 * moved.max()
    assert top[late] == pytest.approx(CubicSpline(way, force)(moved[late]), rel=0.02)
    assert top[late] == pytest.approx(bottom[late], rel=0.01)
    balance = explicit.summary["balance"]
    assert balance["damping"] < 1e-3 * balance["external"]
    assert not explicit.warnings


def test_too_fast_and_too_damped_runs_are_told() -> None:
    fast = pressed(**{"time.ramp": 3e-6, "time.hold": 1e-6})
    assert "unbalanced-reactions" in {warning.code for warning in fast.warnings}
    damped = pressed(**{"time.ramp": 1e-5, "time.hold": 1e-6, "time.relaxation": 0.0, "time.damping": 2e6})
    (told,) = [warning for warning in damped.warnings if warning.code == "damped-work"]
    assert told.value > told.limit == 0.02
    assert told.key == "time.ramp"
