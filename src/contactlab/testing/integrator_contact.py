"""Checks of integrators with contact: masses that press on, fall on and slide along rigid floors."""

from __future__ import annotations

import numpy as np

from contactlab.testing.assertions import NotApplicable, agree, require
from contactlab.testing.oscillator import AnyIntegrator, Oscillator

MASS = np.array([2.0, 1.0, 0.5])
STIFFNESS = np.array([2.0, 4.0, 8.0])  # circular frequencies 1, 2 and 4
NONE = np.zeros(3)
DOWN = np.array([0.0, -1.0])
LOAD = np.array([3.0, 1.0, 2.0])
STANDS = 1e-9  # speed of what stands, of speeds of order one
DECAYS = 1e-4  # the same in schemes that dissipate: rho^n after the some hundred steps n since it stopped, rho = 0.9
CLOSES = 1e-11  # energy ledgers: round-off of sums of order one over a few hundred steps


def pressed_masses_rest(integrator: AnyIntegrator) -> None:
    """Masses pressed onto a floor stay at rest, and contact carries the load."""
    model = Oscillator(integrator, MASS, STIFFNESS, force=LOAD[:, None] * DOWN, clearance=NONE)
    dt, borne = 0.05, np.zeros(3)
    path = model.run(400, dt)
    for _ in range(100):
        model.run(1, dt)
        borne += model.state["contact_force"][:, 1] / 100.0
    # a scheme that corrects itself a step later moves by what the load does within a step
    a_step = dt * LOAD / MASS
    lowest = -path[:, :, 1].min(axis=0)
    require(
        (lowest <= dt * a_step).all(),
        f"pressed masses penetrate by {lowest.max():.3e} mm, allowed {dt * a_step.max():.1e} mm",
    )
    if integrator.inertia:
        speed = np.abs(model.state["velocity"]).max(axis=1)
        require(
            (speed <= 2.0 * a_step).all(),
            f"pressed masses have speeds up to {speed.max():.3e} after 500 steps, allowed {2.0 * a_step.max():.1e}: "
            "contact forces must act on velocities, too",
        )
    agree(borne, LOAD, 0.01 * LOAD.max(), "contact forces in `contact_force`, mean over 100 steps, and the load")
    agree(model.unexplained_energy(), 0.0, CLOSES, "energy balance")


def contact_stops_what_falls(integrator: AnyIntegrator) -> None:
    """A mass that hits the floor penetrates no deeper than in a step, and loses the momentum that contact took."""
    _moving(integrator)
    model = _fallen(integrator)
    dt, impulse, before = 0.01, np.zeros((3, 2)), MASS[:, None] * DOWN
    for _ in range(60):
        model.run(1, dt)
        impulse += dt * model.state["contact_force"]
    lowest = float(model.state["displacement"][:, 1].min())
    require(lowest >= -0.1 - dt, f"masses that fall at speed 1 are {-0.1 - lowest:.3e} below the floor, allowed {dt:g}")
    after = MASS[:, None] * model.state["velocity"]
    agree(after - before, impulse, 1e-9, "change of momentum, and the sum of contact forces times the step")
    agree(model.unexplained_energy(), 0.0, CLOSES, "energy balance")
    damped = _fallen(integrator, damping=5.0)
    damped.run(60, dt)
    agree(damped.unexplained_energy(), 0.0, CLOSES, "energy balance with damping")


def _fallen(integrator: AnyIntegrator, damping: float = 0.0) -> Oscillator:
    """Masses that fall freely on a floor."""
    speed, below = np.tile(DOWN, (3, 1)), 0.1 * np.ones(3)
    return Oscillator(integrator, MASS, 0.0 * STIFFNESS, velocity=speed, clearance=below, damping=damping)


def contact_makes_no_energy(integrator: AnyIntegrator) -> None:
    """Masses on springs that hit a floor once a period rise no higher than before, and the energy balance closes."""
    _moving(integrator)
    upward = np.array([0.0, 1.0])
    model = Oscillator(integrator, MASS, STIFFNESS, velocity=np.tile(upward, (3, 1)), clearance=0.1 * np.ones(3))
    path = model.run(4000, 0.02)[:, :, 1]
    first, last = path[:400].max(axis=0), path[-400:].max(axis=0)
    # of an amplitude of one over the frequency; 1e-2 for crests that are met between two steps
    require((last <= 1.01 * first).all(), f"amplitudes grow from {first} to {last} by meeting a floor")
    agree(model.unexplained_energy(), 0.0, CLOSES, "energy balance after 4000 steps")


def friction_takes_the_energy_of_what_slides(integrator: AnyIntegrator) -> None:
    """A mass that slides on a floor stops after v^2 m/(2 mu N), and its energy is counted as friction."""
    _moving(integrator)
    mu, dt = 0.25, 0.005
    speed = np.array([[1.0, 0.0], [0.5, 0.0], [-0.8, 0.0]])
    model = Oscillator(
        integrator, MASS, 0.0 * STIFFNESS, velocity=speed, force=LOAD[:, None] * DOWN, clearance=NONE, friction=mu
    )
    path = model.run(600, dt)
    exact = np.sign(speed[:, 0]) * speed[:, 0] ** 2 * MASS / (2.0 * mu * LOAD)
    # within the way of the first step, in which it begins, and the last, in which it ends
    agree(path[-1, :, 0], exact, 2.0 * dt, "way until friction has stopped the masses")
    left = model.state["velocity"][:, 0].copy()
    if integrator.dissipates and float(np.abs(left).max()) > STANDS:
        # a scheme that damps what oscillates from step to step lets it decay, and does not end it
        model.run(300, dt)
        later = float(np.abs(model.state["velocity"][:, 0]).max())
        text = (
            f"speeds of {np.abs(left).max():.1e} after friction has stopped the masses, of {later:.1e} 300 steps later"
        )
        require(later < 0.5 * float(np.abs(left).max()) and float(np.abs(left).max()) < DECAYS, text)
    else:
        agree(left, NONE, STANDS, "speed after friction has stopped the masses")
    energy = float(0.5 * MASS @ speed[:, 0] ** 2)
    friction, slip = float(model.state["work"][4]), float(model.state["work"][6])
    # normal forces do no work along a floor: what is booked there was taken at another velocity than friction's
    agree(float(model.state["work"][3]), 0.0, 1e-4 * energy, "work of contact in the energy balance, without friction")
    agree(friction, -energy, 0.02 * energy, "friction in the energy balance, and the kinetic energy that it took")
    agree(slip, energy, 0.02 * energy, "dissipation in the energy balance (-y_t times slip)")
    agree(model.unexplained_energy(), 0.0, CLOSES, "energy balance")


def statics_are_in_equilibrium(integrator: AnyIntegrator) -> None:
    """Internal forces after a load step balance loads, contact forces with their friction, and reactions."""
    if integrator.inertia:
        raise NotApplicable("with inertia forces need not balance")
    load = LOAD[:, None] * np.array([0.1, -1.0])
    model = Oscillator(integrator, MASS, STIFFNESS, force=load, clearance=NONE, friction=0.3)
    model.run(2, 0.5)
    state = model.state
    left = state["internal_force"] - load - state["contact_force"] - state["reaction"]
    agree(left, 0.0 * left, 1e-6 * LOAD.max(), "internal forces less loads, contact forces and reactions")
    borne = state["contact_force"][:, 0]
    require(float(np.abs(borne).max()) > 0.01, "friction carries no part of a load along the floor")


def _moving(integrator: AnyIntegrator) -> None:
    if not integrator.inertia:
        raise NotApplicable("the integrator has no inertia: nothing falls")
