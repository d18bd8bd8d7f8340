"""Explicit steps by primitives, and their node updates with the energy balance (docs/theory/explicit-scheme.md).

The core handles work, reactions, prescribed motion and positions. A kick and a drift without contact are `move`, with
contact `predict` and, when the contact forces are known, `correct`. Kernels see fields as flat arrays of degrees of
freedom, `mobility` being the inverse mass of each, 0 if motion is prescribed. `before` receives the old velocities of
prescribed motion, `trial` becomes the mean velocity.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from contactlab.api import ExplicitEquations, ExplicitIntegrator, Floats, State, Step
from contactlab.api.compiled.bound_arrays import BoundArrays, Floats1, Ints1
from contactlab.api.compiled.kernel import kernel
from contactlab.api.compiled.unpack import unpack
from contactlab.errors import WrongAnswer

ROUND_OFF = 1e-12  # relative: drifts of a step sum to its length up to round-off
CHUNK = 512  # products of forces and velocities that are summed at a time


class ExplicitMotion:
    """Implements `contactlab.api.Motion` on one run's arrays, bound at the first step.

    A kick is made together with the contact and the drift after it, so that prescribed motion ends as it
    should and every force works with the mean of the velocities before and after.

    mobility   (N, 2) [1/t] inverse masses 1/m, 0 if motion is prescribed
    compliance (N, 2) [mm/N] displacement per contact force: dt T/m, T the duration of the kick, less by its damping
    start      time [s] at the start of the step
    duration   of the pending kick [s]; 0 without one; `touched` of the last kick with contact
    moved      time [s] that positions have moved in this step; `kicked` the sum of its kicks
    ahead      time [s] after which the contact forces of this kick hold the gaps; 0 without
    """

    def __init__(self, integrator: ExplicitIntegrator, equations: ExplicitEquations, state: State) -> None:
        nodes, touching = len(equations.reference), equations.contact is not None
        self.scheme, self.name = integrator.step, type(integrator).__name__
        self.equations, self.state, self.pairs = equations, state, equations.contact
        self.loads, self.stresses, self.ramps = (
            equations.external_force, equations.internal_force, equations.prescribed.values
        )  # fmt: skip
        self.clock, self.work, self.reaction = state["clock"], state["work"], state["reaction"]
        inverse_mass = np.divide(1.0, equations.mass, out=np.zeros(nodes), where=equations.mass > 0.0)
        self.mobility: Floats = np.repeat(inverse_mass, 2).reshape(-1, 2)
        self.mobility.reshape(-1)[equations.prescribed.dof] = 0.0
        self.external, self.mean = np.zeros((nodes, 2)), np.zeros((nodes, 2))
        self.compliance, self.predicted = (np.zeros((nodes if touching else 0, 2)) for _ in range(2))
        self.compliance_factor = 0.0
        self.following = 0.5 / equations.relaxation if equations.relaxation else 0.0
        self.damping, self.loaded = 0.0, False
        self.force = state["contact_force"] if touching else np.zeros((0, 2))
        self.start = self.last_dt = self.moved = self.kicked = self.touched = self.duration = self.ahead = 0.0
        self.plain = self.done = Step(self.work, self.reaction)
        self.bound: BoundArrays | None = None

    def advance(self, dt: float) -> Step:
        """Make one step of length dt [s] by the integrator's primitives."""
        if self.bound is None:
            self._bind()
        clock = self.clock
        self.start, self.last_dt = float(clock[0]), float(clock[2])
        self.moved = self.kicked = 0.0
        self.done = self.plain
        error = self.scheme(self, dt)
        if self.duration > 0.0:
            self._move(0.0)
        if self.kicked != self.touched and self.done is not self.plain:
            raise WrongAnswer(f"{self.name}: its step kicks again with contact, needed: one kick a step")
        if self.moved != dt and abs(self.moved - dt) > ROUND_OFF * dt:
            raise WrongAnswer(f"{self.name}: its step of {dt:.6g} s drifts for {self.moved:.6g} s, needed: its length")
        return self.done if error is None else self.done._replace(error=error)

    def kick(self, duration: float) -> None:
        """Note a pending kick: `contact` predicts with it, and `drift` applies it; see `contactlab.api.Motion`."""
        if not duration > 0.0:
            raise WrongAnswer(f"{self.name}: its step kicks for {duration:.6g} s, needed: a positive time")
        if self.duration > 0.0:
            self._move(0.0)
        self.loaded = self.loads(self.start + self.moved, self.external)
        # the slow velocity starts at its value before the kick, and follows until the velocities' mean
        self.damping = self.equations.damping / (1.0 + duration * self.following)
        self.duration = duration
        self.kicked += duration

    def contact(self, ahead: float) -> None:
        """See `contactlab.api.Motion`."""
        if self.pairs is None:
            return
        duration, damping = self.duration, self.damping
        if duration == 0.0 or self.ahead > 0.0:
            raise WrongAnswer(f"{self.name}: its step asks for contact forces without a kick, needed: one kick before")
        if not ahead > 0.0:
            raise WrongAnswer(f"{self.name}: its step asks for contact {ahead:.6g} s ahead, needed: a positive time")
        self.ahead, self.touched = ahead, duration
        self.ramps(self.start + self.moved + ahead)
        predict(self.address, self.loaded, damping, ahead, duration)
        factor = ahead * duration / (1.0 + 0.5 * damping * duration)
        if factor != self.compliance_factor:
            self.compliance_factor = factor
            np.multiply(self.mobility, factor, out=self.compliance)
        solve = self.pairs.solve(self.predicted, self.equations.position, self.compliance, self.force)
        self.done = Step(self.work, self.reaction, sweeps=solve.sweeps, residual=solve.residual)

    def drift(self, duration: float) -> None:
        """See `contactlab.api.Motion`."""
        if self.duration == 0.0 or not duration > 0.0:
            raise WrongAnswer(f"{self.name}: its step drifts for {duration:.6g} s without a kick, needed: one before")
        if self.ahead == 0.0:
            self.ramps(self.start + self.moved + duration)
            self._move(duration)
        elif duration == self.ahead:
            correct(self.address, self.loaded, self.damping, duration, self.duration)
            self.duration = self.ahead = 0.0
            self._book_friction()
        else:
            raise WrongAnswer(
                f"{self.name}: its step drifts for {duration:.6g} s, and asked for contact {self.ahead:.6g} s ahead, "
                "needed: the same time"
            )
        self.moved += duration
        self.stresses(duration)

    def acceleration(self) -> Floats:
        """See `contactlab.api.Motion`."""
        loads = np.zeros_like(self.external)
        self.loads(self.start + self.moved, loads)
        return np.asarray(self.mobility * (loads - self.state["internal_force"]))

    def _move(self, drift: float) -> None:
        """Make the pending kick without contact, move positions for the time `drift`, and book both."""
        if self.ahead > 0.0:
            raise WrongAnswer(f"{self.name}: its step asks for contact and does not drift, needed: a drift after it")
        move(self.address, self.loaded, self.damping, drift, self.duration, self.duration / self.kicked)
        self.duration = 0.0

    def _book_friction(self) -> None:
        """Move the tangential share of the contact work to its own entries."""
        pairs: Any = self.pairs
        rubbed, dissipated = pairs.friction_work(self.mean, self.touched, self.compliance, self.force)
        if rubbed == dissipated == 0.0:
            return
        work = self.work
        work[3] -= rubbed
        work[4] += rubbed
        work[6] += dissipated

    def _bind(self) -> None:
        equations, state, prescribed = self.equations, self.state, self.equations.prescribed
        fields: dict[str, Any] = {
            "reference": equations.reference, "displacement": state["displacement"], "velocity": state["velocity"],
            "internal": state["internal_force"], "external": self.external, "mobility": self.mobility,
            "mass": equations.mass, "dof": prescribed.dof, "scale": prescribed.scale, "ramp": prescribed.ramp,
            "ramps": prescribed.values(0.0), "before": np.zeros(len(prescribed.dof)), "trial": self.mean,
            "predicted": self.predicted, "contact": self.force, "compliance": self.compliance,
            "reaction": self.reaction, "work": self.work, "products": np.zeros(CHUNK),
            "carried": state["drift"] if "drift" in state else np.zeros(0),
            "relaxation": np.array([equations.relaxation]),
        }  # fmt: skip
        table = MotionTable(**{name: field.reshape(-1) for name, field in fields.items()})
        self.bound = BoundArrays(MotionTable, *table)
        self.address = self.bound.address


# --- kernels --------------------------------------------------------------------------------------------------------


class MotionTable(NamedTuple):
    """The arrays of one run, all flat.

    mass is by node; dof, scale, ramp and ramps (values) as in `contactlab.api.PrescribedMotion`; before,
    trial and products are scratch; carried is the slow velocity exempt from damping (or empty), relaxation its time
    constant.
    """

    reference: Floats1
    displacement: Floats1
    velocity: Floats1
    internal: Floats1
    external: Floats1
    mobility: Floats1
    mass: Floats1
    dof: Ints1
    scale: Floats1
    ramp: Ints1
    ramps: Floats1
    before: Floats1
    trial: Floats1
    predicted: Floats1
    contact: Floats1
    compliance: Floats1
    reaction: Floats1
    work: Floats1
    products: Floats1
    carried: Floats1
    relaxation: Floats1


@kernel
def _velocities(
    velocity: Floats, internal: Floats, external: Floats, loaded: bool, mobility: Floats, keep: float, gain: float,
    trial: Floats,
) -> None:  # fmt: skip
    if loaded:
        for i in range(velocity.size):
            trial[i] = keep * velocity[i] + gain * ((external[i] - internal[i]) * mobility[i])
    else:
        for i in range(velocity.size):
            trial[i] = keep * velocity[i] - gain * (internal[i] * mobility[i])


@kernel
def _add(trial: Floats, carried: Floats, factor: float) -> None:
    for i in range(trial.size):
        trial[i] += factor * carried[i]


@kernel
def _trial(m: MotionTable, loaded: bool, alpha: float, dt: float, duration: float) -> None:
    """Compute v+ = [(1 - alpha T/2) v- + T (M^-1 f + alpha d)]/(1 + alpha T/2), and prescribed motion, into `trial`.

    T is the `duration` of the kick, `dt` the time of the following motion of positions; 0 without.
    """
    scaling = 1.0 / (1.0 + 0.5 * alpha * duration)
    keep, gain = (1.0 - 0.5 * alpha * duration) * scaling, duration * scaling
    velocity, trial, u, dof, scale, ramp, ramps = m.velocity, m.trial, m.displacement, m.dof, m.scale, m.ramp, m.ramps
    _velocities(velocity, m.internal, m.external, loaded, m.mobility, keep, gain, trial)
    if m.carried.size > 0:
        _add(trial, m.carried, gain * alpha)
    for i in range(dof.size):
        trial[dof[i]] = (scale[i] * ramps[ramp[i]] - u[dof[i]]) / dt if dt > 0.0 else velocity[dof[i]]


@kernel
def predict(bound: int, loaded: bool, alpha: float, dt: float, duration: float) -> None:
    """Compute velocities `trial` and positions `predicted` without contact forces; prescribed motion is exact."""
    m: MotionTable = unpack(bound, MotionTable)  # type: ignore[call-arg]
    _trial(m, loaded, alpha, dt, duration)
    x, u, v, out = m.reference, m.displacement, m.trial, m.predicted
    for i in range(x.size):
        out[i] = x[i] + (u[i] + dt * v[i])


@kernel
def _add_contact_velocity(trial: Floats, compliance: Floats, contact: Floats, rate: float) -> None:
    for i in range(trial.size):
        trial[i] += rate * (compliance[i] * contact[i])


@kernel
def _advance(trial: Floats, velocity: Floats, displacement: Floats, dt: float) -> None:
    """Update displacements and velocities from `trial`, which becomes the mean velocity."""
    for i in range(trial.size):
        after = trial[i]
        trial[i] = 0.5 * (velocity[i] + after)
        velocity[i] = after
        displacement[i] += dt * after


@kernel
def _keep(m: MotionTable) -> None:
    velocity, dof, before = m.velocity, m.dof, m.before
    for i in range(dof.size):
        before[i] = velocity[dof[i]]


@kernel
def move(bound: int, loaded: bool, alpha: float, dt: float, duration: float, share: float) -> None:
    """Kick and drift without contact; `share` of the reaction belongs to this kick, the rest to earlier kicks."""
    m: MotionTable = unpack(bound, MotionTable)  # type: ignore[call-arg]
    _trial(m, loaded, alpha, dt, duration)
    _keep(m)
    _advance(m.trial, m.velocity, m.displacement, dt)
    _book(m, loaded, False, alpha, duration, share)


@kernel
def correct(bound: int, loaded: bool, alpha: float, dt: float, duration: float) -> None:
    """Add the contact forces' share of `trial`, move the nodes, and book the only kick of a step."""
    m: MotionTable = unpack(bound, MotionTable)  # type: ignore[call-arg]
    _keep(m)
    _add_contact_velocity(m.trial, m.compliance, m.contact, 1.0 / dt)
    _advance(m.trial, m.velocity, m.displacement, dt)
    _book(m, loaded, True, alpha, duration, 1.0)


@kernel
def _power(mean: Floats, force: Floats, products: Floats) -> float:
    """Return the sum of mean * force. Pairwise: vector additions, equal on every machine, and small errors."""
    total = 0.0
    for begin in range(0, mean.size, CHUNK):
        count = min(CHUNK, mean.size - begin)
        part, push = mean[begin : begin + count], force[begin : begin + count]
        for i in range(count):
            products[i] = part[i] * push[i]
        for i in range(count, CHUNK):
            products[i] = 0.0
        half = CHUNK // 2
        while half > 0:
            low, high = products[:half], products[half : 2 * half]
            for i in range(half):
                low[i] += high[i]
            half //= 2
        total += products[0]
    return total


@kernel
def _damped(mass: Floats, mean: Floats) -> float:
    total = 0.0
    for n in range(mass.size):
        total += mass[n] * (mean[2 * n] * mean[2 * n] + mean[2 * n + 1] * mean[2 * n + 1])
    return total


@kernel
def _damped_beside(mass: Floats, mean: Floats, carried: Floats) -> float:
    total = 0.0
    for n in range(mass.size):
        x, y = 2 * n, 2 * n + 1
        total += mass[n] * (mean[x] * (mean[x] - carried[x]) + mean[y] * (mean[y] - carried[y]))
    return total


@kernel
def _follow(mean: Floats, carried: Floats, share: float) -> None:
    for i in range(mean.size):
        carried[i] += share * (mean[i] - carried[i])


@kernel
def _book(m: MotionTable, loaded: bool, touching: bool, alpha: float, duration: float, share: float) -> None:
    """Add work of every force with the mean velocity, and reactions of prescribed motion.

    work = internal, external (with reactions), damping, contact, ... (see contactlab.api.WORK); only
    acting forces are summed.
    """
    velocity, f, e, mass, dof, before, mean = m.velocity, m.internal, m.external, m.mass, m.dof, m.before, m.trial
    y, r, work, products, carried = m.contact, m.reaction, m.work, m.products, m.carried
    work[0] += duration * _power(mean, f, products)
    load = _power(mean, e, products) if loaded else 0.0
    if touching:
        work[3] += duration * _power(mean, y, products)
    if alpha != 0.0:
        work[2] += duration * alpha * (_damped_beside(mass, mean, carried) if carried.size > 0 else _damped(mass, mean))
    for k in range(dof.size):
        i = dof[k]
        needed = mass[i // 2] * ((velocity[i] - before[k]) / duration + alpha * mean[i]) + f[i]
        needed -= mass[i // 2] * alpha * carried[i] if carried.size > 0 else 0.0
        needed -= e[i] if loaded else 0.0
        needed -= y[i] if touching else 0.0
        r[i] = needed if share == 1.0 else r[i] + share * (needed - r[i])
        load += mean[i] * needed
    work[1] += duration * load
    if carried.size > 0:
        _follow(mean, carried, duration / (m.relaxation[0] + 0.5 * duration))
