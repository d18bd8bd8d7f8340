"""Checks of integrators: their duties, as numbered in `contactlab.api.Integrator`."""

from __future__ import annotations

import numpy as np

from contactlab.api import Enforcement, ExplicitIntegrator, Floats
from contactlab.testing.assertions import Check, NotApplicable, agree, identical, require, untouched
from contactlab.testing.integrator_contact import (
    contact_makes_no_energy,
    contact_stops_what_falls,
    friction_takes_the_energy_of_what_slides,
    pressed_masses_rest,
    statics_are_in_equilibrium,
)
from contactlab.testing.oscillator import AnyIntegrator, Oscillator, Ramp

MASS = np.array([2.0, 1.0, 0.5])
STIFFNESS = np.array([2.0, 4.0, 8.0])  # circular frequencies 1, 2 and 4
START = np.array([[1.0, 0.0], [0.0, -1.0], [0.5, 0.5]])
AT = np.array([[0.3, 0.0], [0.0, 0.2], [-0.1, 0.4]])  # displacements at the start
END = 2.0  # time at which errors are compared: between the zeros of all three solutions


def _moving(integrator: AnyIntegrator) -> AnyIntegrator:
    if not integrator.inertia:
        raise NotApplicable("the integrator has no inertia: nothing oscillates")
    return integrator


def declarations(integrator: AnyIntegrator) -> None:
    """An integrator needs an enforcement, names a default one, and its order is an integer (duty 1)."""
    require(
        isinstance(integrator.needs, type) and issubclass(integrator.needs, Enforcement), "needs: not an Enforcement"
    )
    require(bool(integrator.default_enforcement), "default_enforcement: not named")
    require(
        isinstance(integrator.order, int) and integrator.order >= 1,
        f"order: got {integrator.order!r}, allowed: a whole number of at least 1",
    )


def _exact(time: float, damping: float) -> Floats:
    """Displacement (N, 2) of u'' + damping u' + w^2 u = 0 with u(0) = AT and u'(0) = START."""
    root = np.sqrt(np.asarray(STIFFNESS / MASS - 0.25 * damping**2, complex))
    decay = np.exp(-0.5 * damping * time)
    of_speed = (decay * np.sin(root * time) / root).real[:, None]
    of_place = (decay * np.cos(root * time)).real[:, None]
    return np.asarray(AT * of_place + (START + 0.5 * damping * AT) * of_speed)


def _error(integrator: AnyIntegrator, steps: int, damping: float) -> float:
    model = Oscillator(integrator, MASS, STIFFNESS, velocity=START, displacement=AT, damping=damping)
    return float(np.abs(model.run(steps, END / steps)[-1] - _exact(END, damping)).max())


def converges_at_its_order(integrator: AnyIntegrator) -> None:
    """Halving the step divides the error of an oscillator, displaced and in motion, by 2 to the promised order."""
    _moving(integrator)
    for damping in (0.0, 0.5):
        coarse, fine = _error(integrator, 200, damping), _error(integrator, 400, damping)
        rate = np.log2(coarse / fine)
        # the next term of the error is some w dt = 4 * 0.01 of the first
        require(
            abs(rate - integrator.order) < 0.1,
            f"order of convergence {rate:.2f} with damping {damping}, promised: {integrator.order}",
        )


def free_flight_is_exact(integrator: AnyIntegrator) -> None:
    """Every node moves in a straight line at its speed without forces."""
    _moving(integrator)
    model = Oscillator(integrator, MASS, 0.0 * STIFFNESS, velocity=START)
    path = model.run(1000, 0.01)
    # velocities from differences of displacements lose eps u/dt in a step: 1000 * 2e-16 * 10/0.01 = 2e-10 after all
    agree(model.state["velocity"], START, 1e-9, "velocity after 1000 steps")
    agree(path[-1], 10.0 * START, 1e-8, "displacement after 1000 steps, ten units of time")


def constant_force_gives_the_parabola(integrator: AnyIntegrator) -> None:
    """The path under a constant force is a parabola, from the first step on."""
    _moving(integrator)
    if integrator.order < 2:
        raise NotApplicable("a first-order integrator is not exact on a parabola")
    force = np.array([[0.0, -20.0], [5.0, 0.0], [0.0, 0.0]])
    model = Oscillator(integrator, MASS, 0.0 * STIFFNESS, velocity=START, force=force)
    path = model.run(10, 0.1)
    times = 0.1 * np.arange(1, 11)[:, None, None]
    agree(path, START * times + 0.5 * times**2 * force / MASS[:, None], 1e-12, "displacement under a constant force")


def energy_is_bounded(integrator: AnyIntegrator) -> None:
    """An oscillator's amplitude does not grow over 2500 steps, and only falls if the scheme dissipates."""
    _moving(integrator)
    model = Oscillator(integrator, MASS[2:], STIFFNESS[2:], velocity=START[2:])
    dt = 0.2 * model.stable_step()
    path = model.run(2500, dt)
    amplitude = [float(np.abs(part).max()) for part in (path[:500], path[-500:])]
    change, text = amplitude[1] / amplitude[0] - 1.0, "in the first, {:.6f} in the last 500 of 2500 steps"
    # sixteen samples of each of thirty periods, at other phases in each: one is within 2e-4 of the crest
    require(change < 5e-4, f"the amplitude grows: {amplitude[0]:.6f} {text.format(amplitude[1])}")
    require(
        integrator.dissipates or change > -5e-4,
        f"the amplitude falls: {amplitude[0]:.6f} {text.format(amplitude[1])}; declare dissipates = True if it may",
    )


def ledger_closes(integrator: AnyIntegrator) -> None:
    """Kinetic energy and the work of springs, damping, loads and supports sum to a constant."""
    held = Ramp(np.array([2]), np.array([0.4]))
    model = Oscillator(
        integrator, MASS, STIFFNESS, velocity=START, damping=0.3, force=lambda time: time * START, prescribed=held
    )
    model.run(500, 0.02)
    agree(model.unexplained_energy(), 0.0, 1e-11, "energy balance after 500 steps (round-off of sums up to a hundred)")


def velocities_are_where_declared(integrator: AnyIntegrator) -> None:
    """Velocities belong to `time` less the fraction `velocity_lag` of a step; 0 for implicit integrators."""
    _moving(integrator)
    lag = integrator.velocity_lag if isinstance(integrator, ExplicitIntegrator) else 0.0
    frequency, errors = np.sqrt(STIFFNESS / MASS)[:, None], []
    for steps in (200, 400):
        dt = END / steps
        model = Oscillator(integrator, MASS, STIFFNESS, velocity=START)
        path = model.run(steps, dt)
        v = model.state["velocity"]
        errors.append(float(np.abs(v - START * np.cos(frequency * (END - lag * dt))).max()))
        if lag == 0.5:
            moved = dt * v - (path[-1] - path[-2])
            agree(moved, 0.0 * moved, 1e-15, "dt times the velocity less the last motion (which are one in a leapfrog)")
    rate = np.log2(errors[0] / errors[1])
    require(
        rate > min(integrator.order, 2) - 0.2,
        f"velocities with a lag of {lag:g} steps converge at order {rate:.2f}, promised: {integrator.order}",
    )


def forces_belong_to_the_end_of_the_step(integrator: AnyIntegrator) -> None:
    """Positions and internal forces after a step belong to its displacement."""
    model = Oscillator(integrator, MASS, STIFFNESS, velocity=START, force=START)
    for _ in range(3):
        model.advance(0.1)
        u = model.state["displacement"].copy()
        identical(model.position, model.reference + u, "positions and reference + displacement")
        identical(model.state["internal_force"], STIFFNESS[:, None] * u, "internal forces and spring forces")


def loads_act_at_their_time(integrator: AnyIntegrator) -> None:
    """A load that grows with time gives the exact path: F t^3/(6 m), or F t/k in statics."""
    force = np.array([[0.0, -20.0], [5.0, 0.0], [1.0, 2.0]])
    if not integrator.inertia:
        path = Oscillator(integrator, MASS, STIFFNESS, force=lambda time: time * force).run(10, 0.1)
        times = 0.1 * np.arange(1, 11)[:, None, None]
        agree(path, times * force / STIFFNESS[:, None], 1e-12, "displacement under a growing load")
        return
    errors = []
    for steps in (100, 200):
        path = Oscillator(integrator, MASS, 0.0 * STIFFNESS, force=lambda time: time * force).run(steps, END / steps)
        errors.append(float(np.abs(path[-1] - force * END**3 / 6.0 / MASS[:, None]).max()))
    # errors at round-off have no rate
    rate = np.log2(errors[0] / errors[1]) if errors[1] > 1e-12 else np.inf
    require(rate > integrator.order - 0.2, f"order {rate:.2f} under a growing load, promised: {integrator.order}")


def prescribed_motion_is_exact(integrator: AnyIntegrator) -> None:
    """A prescribed degree of freedom is where it should be after every step, the others do not feel it."""
    held = Ramp(np.array([1, 2]), np.array([0.7, -0.3]))
    model = Oscillator(integrator, MASS, STIFFNESS, velocity=START, prescribed=held)
    lengths = np.where(np.arange(50) % 3, 0.02, 0.013)
    path, times = _in_steps(model, lengths), np.cumsum(lengths)
    agree(path[:, 0, 1], 0.7 * times, 1e-13, "displacement of a prescribed degree of freedom")
    agree(path[:, 1, 0], -0.3 * times, 1e-13, "displacement of another")
    free = _in_steps(Oscillator(integrator, MASS, STIFFNESS, velocity=START), lengths)
    agree(path[:, 2], free[:, 2], 1e-13, "displacement of a node that is not prescribed")


def _in_steps(model: Oscillator, lengths: Floats) -> Floats:
    """Displacements (steps, N, 2) after steps of these lengths [s]."""
    return np.concatenate([model.run(1, float(dt)) for dt in lengths])


def reaction_balances(integrator: AnyIntegrator) -> None:
    """The reaction of a slow prescribed motion is the force of the spring that it stretches, less the load there."""
    load = np.array([[0.3, 0.0], [0.0, 0.0], [0.0, 0.0]])
    for force, share in ((None, 0.0), (load, 0.3)):
        model = Oscillator(integrator, MASS, STIFFNESS, force=force, prescribed=Ramp(np.array([0]), np.array([0.5])))
        # the first step sets the mass in motion; after it the speed is constant and only spring and load act
        model.run(20, 0.05)
        # at any time of the last step, as the integrator has it; 1e-12 for the round-off of 20 steps
        least, most = (STIFFNESS[0] * 0.5 * 0.05 * steps - share for steps in (19, 20))
        found = model.state["reaction"].copy()
        require(
            least - 1e-12 <= found[0, 0] <= most + 1e-12,
            f"reaction: got {found[0, 0]:.15g}, spring less load in the last step are {least:.15g} to {most:.15g}",
        )
        found[0, 0] = 0.0
        agree(found, 0.0 * found, 0.0, "reaction where nothing is prescribed")


def restart_is_exact(integrator: AnyIntegrator) -> None:
    """The state is all that a run needs: restored and bound again it continues with the same bits."""
    model, again = (
        Oscillator(integrator, MASS, STIFFNESS, velocity=START, damping=0.1, force=lambda time: time * START)
        for _ in range(2)
    )
    model.run(37, 0.03)
    saved = model.state.snapshot()
    model.run(40, 0.03)
    again.state.restore(saved)
    again.internal_force(0.03)
    again.bind()
    again.run(40, 0.03)
    identical(again.state.buffer, model.state.buffer, "state after a restart")


def the_clock_is_left_alone(integrator: AnyIntegrator) -> None:
    """A step of any length is accepted and counted once, and time advances by its length, by the core alone."""
    model = Oscillator(integrator, MASS, STIFFNESS, velocity=START)
    for dt in (0.01, 0.02, 0.01):
        model.run(1, dt)
    agree(model.state.time, 0.04, 1e-15, "time after three steps")
    require(model.state.step == 3, f"number of steps: got {model.state.step} after 3")


def refused_steps_leave_the_state(integrator: AnyIntegrator) -> None:
    """A step without finite forces is not accepted, gives the reason, and leaves the state unchanged for the next."""
    if isinstance(integrator, ExplicitIntegrator):
        raise NotApplicable("explicit steps are always accepted")
    whole = Oscillator(integrator, MASS, STIFFNESS, velocity=START, force=lambda time: time * START)
    whole.run(6, 0.1)
    calls, accepted = 0, False
    while not accepted:
        accepted = _interrupted(integrator, calls, whole)
        require(not accepted or calls > 0, "a step without a single finite force was accepted")
        calls += 1


def steps_are_begun_and_accepted(integrator: AnyIntegrator) -> None:
    """Every step is begun with its length and, if accepted, accepted once: laws keep their history by that."""
    if isinstance(integrator, ExplicitIntegrator):
        raise NotApplicable("explicit steps have no trial")
    model = Oscillator(integrator, MASS, STIFFNESS, velocity=START, force=lambda time: time * START, clearance=MASS)
    for number, dt in enumerate((0.1, 0.1, 0.05, 0.02, 0.1)):
        model.begun.clear()
        model.run(1, dt)
        told = f"step {number + 1}, of {dt:g} s"
        require(dt in model.begun, f"{told}: begin_step got {model.begun}")
        require(model.accepted == number + 1, f"{told}: accept was called {model.accepted - number} times")
    model.calls_left = 0
    with np.errstate(invalid="ignore"):
        model.advance(0.1)
    require(model.accepted == 5, "accept was called in a rejected step")


def _interrupted(integrator: AnyIntegrator, calls: int, whole: Oscillator) -> bool:
    """Return whether a step with finite forces in only so many calls is accepted; later steps must match `whole`."""
    model = Oscillator(integrator, MASS, STIFFNESS, velocity=START, force=lambda time: time * START)
    model.run(3, 0.1)
    before, model.calls_left = model.state.snapshot(), calls
    with np.errstate(invalid="ignore"):
        done = model.advance(0.1)
    if not done.status.value:
        return True
    require(done.reason, "a rejected step gives no reason")
    model.calls_left = np.inf
    # forces are the model's own: they were requested while it had none
    model.internal_force(0.0)
    when = f"a step that found no forces after {calls} calls"
    identical(model.state.buffer, before, f"state after {when}")
    model.run(3, 0.1)
    identical(model.state.buffer, whole.state.buffer, f"state of a run with {when}, and without")
    return False


def inputs_are_untouched(integrator: AnyIntegrator) -> None:
    """Reference positions, masses and prescribed motions are only read."""
    held = Ramp(np.array([1]), np.array([0.5]))
    model = Oscillator(integrator, MASS, STIFFNESS, velocity=START, prescribed=held, clearance=0.1 * MASS)
    given = {"reference": model.reference, "mass": model.mass, "floors": model.contact.level}
    with untouched(**given, prescribed_dof=held.dof, prescribed_scale=held.scale, prescribed_ramp=held.ramp):
        model.run(20, 0.05)


def changing_steps_keep_the_order(integrator: AnyIntegrator) -> None:
    """Steps of changing length lose no accuracy beyond one order, as when a mesh is compressed."""
    _moving(integrator)
    errors = []
    for steps in (200, 400):
        model = Oscillator(integrator, MASS, STIFFNESS, velocity=START, displacement=AT)
        lengths = 1.0 + 0.3 * np.sin(np.arange(steps) * 2.0 * np.pi / steps)
        lengths *= END / lengths.sum()
        for dt in lengths:
            model.advance(float(dt))
        errors.append(float(np.abs(model.state["displacement"] - _exact(END, 0.0)).max()))
    rate = np.log2(errors[0] / errors[1])
    require(rate > integrator.order - 0.2, f"order of convergence {rate:.2f} with steps of slowly changing length")


DUTIES: dict[int, tuple[Check, ...]] = {
    1: (declarations,),
    2: (
        converges_at_its_order,
        free_flight_is_exact,
        constant_force_gives_the_parabola,
        changing_steps_keep_the_order,
        velocities_are_where_declared,
    ),
    3: (forces_belong_to_the_end_of_the_step,),
    4: (prescribed_motion_is_exact,),
    5: (loads_act_at_their_time,),
    6: (
        pressed_masses_rest,
        contact_stops_what_falls,
        friction_takes_the_energy_of_what_slides,
        statics_are_in_equilibrium,
    ),
    7: (ledger_closes,),
    8: (reaction_balances,),
    9: (the_clock_is_left_alone,),
    10: (restart_is_exact,),
    11: (refused_steps_leave_the_state, steps_are_begun_and_accepted),
    12: (energy_is_bounded, contact_makes_no_energy),
    13: (inputs_are_untouched,),
}
"""The checks that hold each duty of `contactlab.api.Integrator`."""

CHECKS: tuple[Check, ...] = tuple(check for checks in DUTIES.values() for check in checks)
