"""Node updates of explicit steps, with the energy balance (docs/theory/explicit-scheme.md).

A kick and a drift without contact are `move`, with contact `predict` and, when the contact forces are known,
`correct`. Fields are flat arrays of degrees of freedom, `mobility` being the inverse mass of each, 0 if
motion is prescribed. `before` receives the old velocities of prescribed motion, `trial` becomes the mean velocity.
"""

from __future__ import annotations

from typing import NamedTuple

from contactlab.api.compiled.bound_arrays import Floats1, Ints1
from contactlab.api.compiled.kernel import kernel
from contactlab.api.compiled.unpack import unpack

CHUNK = 512  # degrees of freedom summed at a time; `products` has as many entries


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
def _velocities(velocity, internal, external, loaded, mobility, keep, gain, trial):
    if loaded:
        for i in range(velocity.size):
            trial[i] = keep * velocity[i] + gain * ((external[i] - internal[i]) * mobility[i])
    else:
        for i in range(velocity.size):
            trial[i] = keep * velocity[i] - gain * (internal[i] * mobility[i])


@kernel
def _add(trial, carried, factor):
    for i in range(trial.size):
        trial[i] += factor * carried[i]


@kernel
def _trial(m, loaded, alpha, dt, duration):
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
def predict(bound, loaded, alpha, dt, duration):
    """Compute velocities `trial` and positions `predicted` without contact forces; prescribed motion is exact."""
    m = unpack(bound, MotionTable)
    _trial(m, loaded, alpha, dt, duration)
    x, u, v, out = m.reference, m.displacement, m.trial, m.predicted
    for i in range(x.size):
        out[i] = x[i] + (u[i] + dt * v[i])


@kernel
def _push(trial, compliance, contact, rate):
    for i in range(trial.size):
        trial[i] += rate * (compliance[i] * contact[i])


@kernel
def _advance(trial, velocity, displacement, dt):
    """Update displacements and velocities from `trial`, which becomes the mean velocity."""
    for i in range(trial.size):
        after = trial[i]
        trial[i] = 0.5 * (velocity[i] + after)
        velocity[i] = after
        displacement[i] += dt * after


@kernel
def _keep(m):
    velocity, dof, before = m.velocity, m.dof, m.before
    for i in range(dof.size):
        before[i] = velocity[dof[i]]


@kernel
def move(bound, loaded, alpha, dt, duration, share):
    """Kick and drift without contact; `share` of the reaction belongs to this kick, the rest to earlier kicks."""
    m = unpack(bound, MotionTable)
    _trial(m, loaded, alpha, dt, duration)
    _keep(m)
    _advance(m.trial, m.velocity, m.displacement, dt)
    _book(m, loaded, False, alpha, duration, share)


@kernel
def correct(bound, loaded, alpha, dt, duration):
    """Add the contact forces' share of `trial`, move the nodes, and book the only kick of a step."""
    m = unpack(bound, MotionTable)
    _keep(m)
    _push(m.trial, m.compliance, m.contact, 1.0 / dt)
    _advance(m.trial, m.velocity, m.displacement, dt)
    _book(m, loaded, True, alpha, duration, 1.0)


@kernel
def _power(mean, force, products):
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
def _damped(mass, mean):
    total = 0.0
    for n in range(mass.size):
        total += mass[n] * (mean[2 * n] * mean[2 * n] + mean[2 * n + 1] * mean[2 * n + 1])
    return total


@kernel
def _damped_beside(mass, mean, carried):
    total = 0.0
    for n in range(mass.size):
        x, y = 2 * n, 2 * n + 1
        total += mass[n] * (mean[x] * (mean[x] - carried[x]) + mean[y] * (mean[y] - carried[y]))
    return total


@kernel
def _follow(mean, carried, share):
    for i in range(mean.size):
        carried[i] += share * (mean[i] - carried[i])


@kernel
def _book(m, loaded, touching, alpha, duration, share):
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
