"""What every integrator must do."""

from __future__ import annotations

import numpy as np

from contactlab.api import Enforcement, Floats, Integrator, StepStatus
from contactlab.testing.assertions import Check, NotApplicable, agree, identical, require
from contactlab.testing.oscillator import Oscillator, Ramp

MASS = np.array([2.0, 1.0, 0.5])
STIFFNESS = np.array([2.0, 4.0, 8.0])  # circular frequencies 1, 2 and 4
START = np.array([[1.0, 0.0], [0.0, -1.0], [0.5, 0.5]])
END = 2.0  # time at which errors are compared: between the zeros of all three solutions


def _moving(integrator: Integrator) -> Integrator:
    if not integrator.inertia:
        raise NotApplicable("the integrator has no inertia: nothing oscillates")
    return integrator


def declarations(integrator: Integrator) -> None:
    """What it needs is an enforcement, its default is named, and its order is a whole number."""
    require(
        isinstance(integrator.needs, type) and issubclass(integrator.needs, Enforcement), "needs: not an Enforcement"
    )
    require(bool(integrator.default_enforcement), "default_enforcement: not named")
    require(
        isinstance(integrator.order, int) and integrator.order >= 1,
        f"order: got {integrator.order!r}, allowed: a whole number of at least 1",
    )


def _exact(time: float, damping: float) -> Floats:
    """Displacement (N, 2) of u'' + damping u' + w^2 u = 0 with u(0) = 0 and u'(0) = START."""
    root = np.sqrt(np.asarray(STIFFNESS / MASS - 0.25 * damping**2, complex))
    factor = np.exp(-0.5 * damping * time) * np.sin(root * time) / root
    return np.asarray(START * factor.real[:, None])


def _error(integrator: Integrator, steps: int, damping: float) -> float:
    model = Oscillator(integrator, MASS, STIFFNESS, velocity=START, damping=damping)
    return float(np.abs(model.run(steps, END / steps)[-1] - _exact(END, damping)).max())


def converges_at_its_order(integrator: Integrator) -> None:
    """Halving the step divides the error of an oscillator by 2 to the promised order, with damping too."""
    _moving(integrator)
    for damping in (0.0, 0.5):
        coarse, fine = _error(integrator, 200, damping), _error(integrator, 400, damping)
        rate = np.log2(coarse / fine)
        # the next term of the error is some w dt = 4 * 0.01 of the first
        require(
            abs(rate - integrator.order) < 0.1,
            f"order {integrator.order} is promised, {rate:.2f} is seen with damping {damping}",
        )


def free_flight_is_exact(integrator: Integrator) -> None:
    """Without forces every node moves in a straight line at its speed."""
    _moving(integrator)
    model = Oscillator(integrator, MASS, 0.0 * STIFFNESS, velocity=START)
    path = model.run(1000, 0.01)
    agree(path[-1], 10.0 * START, 1e-12, "displacement after 1000 steps (their round-off adds up)")
    agree(model.state["velocity"], START, 1e-14, "velocity")


def constant_force_gives_the_parabola(integrator: Integrator) -> None:
    """Under a constant force the path is a parabola, from the first step on."""
    _moving(integrator)
    if integrator.order < 2:
        raise NotApplicable("a first-order integrator is not exact on a parabola")
    force = np.array([[0.0, -20.0], [5.0, 0.0], [0.0, 0.0]])
    model = Oscillator(integrator, MASS, 0.0 * STIFFNESS, velocity=START, force=force)
    path = model.run(10, 0.1)
    times = 0.1 * np.arange(1, 11)[:, None, None]
    agree(path, START * times + 0.5 * times**2 * force / MASS[:, None], 1e-12, "displacement under a constant force")


def energy_is_bounded(integrator: Integrator) -> None:
    """An oscillator keeps its amplitude over 10000 steps: no growth and no loss beyond what one period shows."""
    _moving(integrator)
    model = Oscillator(integrator, MASS[2:], STIFFNESS[2:], velocity=START[2:])
    dt = 0.2 * model.stable_step()
    path = model.run(10_000, dt)
    amplitude = [float(np.abs(part).max()) for part in (path[:1000], path[-1000:])]
    require(
        abs(amplitude[1] / amplitude[0] - 1.0) < 2e-3,
        f"amplitude {amplitude[0]:.6f} in the first, {amplitude[1]:.6f} in the last 1000 of 10000 steps",
    )


def ledger_closes(integrator: Integrator) -> None:
    """Kinetic energy and the work of all forces sum to a constant."""
    _moving(integrator)
    model = Oscillator(
        integrator,
        MASS,
        STIFFNESS,
        velocity=START,
        damping=0.3,
        force=0.1 * START,
        prescribed=Ramp(np.array([2]), np.array([0.4])),
    )
    model.run(500, 0.02)
    internal, external, damping, contact, friction, numerical, _ = model.state["work"]
    change = model.kinetic_energy() + internal + damping + numerical - external - contact - friction
    agree(change, model.initial_energy, 1e-12, "energy ledger after 500 steps (round-off of a sum of order one)")


def prescribed_motion_is_exact(integrator: Integrator) -> None:
    """A prescribed degree of freedom is where it should be after every step, the others do not feel it."""
    _moving(integrator)
    held = Ramp(np.array([1, 2]), np.array([0.7, -0.3]))
    model = Oscillator(integrator, MASS, STIFFNESS, velocity=START, prescribed=held)
    path = model.run(50, 0.02)
    times = 0.02 * np.arange(1, 51)
    agree(path[:, 0, 1], 0.7 * times, 1e-13, "displacement of a prescribed degree of freedom")
    agree(path[:, 1, 0], -0.3 * times, 1e-13, "displacement of another")
    free = Oscillator(integrator, MASS, STIFFNESS, velocity=START).run(50, 0.02)
    agree(path[:, 2], free[:, 2], 1e-13, "displacement of a node that is not prescribed")


def reaction_balances(integrator: Integrator) -> None:
    """The reaction of a slow prescribed motion is the force of the spring that it stretches."""
    _moving(integrator)
    model = Oscillator(integrator, MASS, STIFFNESS, prescribed=Ramp(np.array([0]), np.array([0.5])))
    if "reaction" not in model.state:
        raise NotApplicable("the integrator keeps no reactions")
    # the first step sets the mass in motion; after it the speed is constant and only the spring acts
    model.run(20, 0.05)
    # at any time of the last step, as the integrator has it; 1e-12 for the round-off of 20 steps
    least, most = (STIFFNESS[0] * 0.5 * 0.05 * steps for steps in (19, 20))
    found = float(model.state["reaction"][0, 0])
    require(
        least - 1e-12 <= found <= most + 1e-12,
        f"reaction: got {found:.15g}, the spring's force in the last step is {least:.15g} to {most:.15g}",
    )


def restart_is_exact(integrator: Integrator) -> None:
    """The state is all that a run needs: restored and bound anew it goes on with the same bits."""
    _moving(integrator)
    model, again = (
        Oscillator(integrator, MASS, STIFFNESS, velocity=START, damping=0.1, force=0.2 * START) for _ in range(2)
    )
    model.run(37, 0.03)
    saved = model.state.snapshot()
    model.run(40, 0.03)
    again.state.restore(saved)
    again.internal_force(0.03)
    again.advance = integrator.bind(again, again.state)
    again.run(40, 0.03)
    identical(again.state.buffer, model.state.buffer, "state after a restart")


def clock_counts_steps(integrator: Integrator) -> None:
    """Time and number of steps advance with each accepted step, and the step says that it was accepted."""
    _moving(integrator)
    model = Oscillator(integrator, MASS, STIFFNESS, velocity=START)
    for dt in (0.01, 0.02, 0.01):
        done = model.advance(dt)
        require(done.status is StepStatus.accepted, f"step: got {done.status}")
    agree(model.state.time, 0.04, 1e-15, "time after three steps")
    require(model.state.step == 3, f"number of steps: got {model.state.step} after 3")


def changing_steps_keep_the_order(integrator: Integrator) -> None:
    """Steps of changing length lose no accuracy beyond one order, as when a mesh is compressed."""
    _moving(integrator)
    errors = []
    for steps in (200, 400):
        model = Oscillator(integrator, MASS, STIFFNESS, velocity=START)
        lengths = 1.0 + 0.3 * np.sin(np.arange(steps) * 2.0 * np.pi / steps)
        lengths *= END / lengths.sum()
        for dt in lengths:
            model.advance(float(dt))
        errors.append(float(np.abs(model.state["displacement"] - _exact(END, 0.0)).max()))
    rate = np.log2(errors[0] / errors[1])
    require(rate > integrator.order - 0.2, f"rate {rate:.2f} with steps of slowly changing length")


CHECKS: tuple[Check, ...] = (
    declarations,
    converges_at_its_order,
    free_flight_is_exact,
    constant_force_gives_the_parabola,
    energy_is_bounded,
    ledger_closes,
    prescribed_motion_is_exact,
    reaction_balances,
    restart_is_exact,
    clock_counts_steps,
    changing_steps_keep_the_order,
)
