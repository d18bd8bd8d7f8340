"""Node updates of the central-difference scheme, with the energy ledger (docs/theory/explicit-scheme.md).

A step without contact is `move`, one with contact `predict` and, when the contact forces are known,
`correct`. Fields are flat arrays of degrees of freedom, `mobility` being the inverse mass of each, 0 where
motion is prescribed. `before` receives the old velocities of prescribed motion, `trial` becomes the mean velocity.
"""

from __future__ import annotations

from contactlab.api.compiled.kernel import kernel
from contactlab.api.compiled.unpack import unpack

ARRAYS = "d1 d1 d1 d1 d1 d1 d1 i1 d1 i1 d1 d1 d1 d1 d1 d1 d1 d1 d1 d1 d1"
"""reference, displacement, velocity, internal, external, mobility; mass by node; dof, scale, ramp and values of what is
prescribed; before, trial, predicted, contact, compliance, reaction, work, products; drift (or nothing) and the time in
which it follows."""
CHUNK = 512  # degrees of freedom summed at a time


@kernel
def _velocities(velocity, internal, external, loaded, mobility, keep, gain, trial):
    if loaded:
        for i in range(velocity.size):
            trial[i] = keep * velocity[i] + gain * ((external[i] - internal[i]) * mobility[i])
    else:
        for i in range(velocity.size):
            trial[i] = keep * velocity[i] - gain * (internal[i] * mobility[i])


@kernel
def _add(trial, drift, factor):
    for i in range(trial.size):
        trial[i] += factor * drift[i]


@kernel
def _trial(bound, loaded, alpha, dt, mean_dt):
    """v+ = [(1 - alpha dt/2) v- + dt (M^-1 f + alpha d)]/(1 + alpha dt/2), and what is prescribed, into `trial`."""
    found = unpack(bound, ARRAYS)
    _, u, velocity, internal, external, mobility, _, dof, scale, ramp, ramps, _, trial = found[:13]
    scaling = 1.0 / (1.0 + 0.5 * alpha * mean_dt)
    keep, gain = (1.0 - 0.5 * alpha * mean_dt) * scaling, mean_dt * scaling
    _velocities(velocity, internal, external, loaded, mobility, keep, gain, trial)
    drift = found[19]
    if drift.size > 0:
        _add(trial, drift, gain * alpha)
    for i in range(dof.size):
        trial[dof[i]] = (scale[i] * ramps[ramp[i]] - u[dof[i]]) / dt


@kernel
def predict(bound, loaded, alpha, dt, mean_dt):
    """Velocities `trial` and positions `predicted` without contact forces; prescribed motion is exact."""
    _trial(bound, loaded, alpha, dt, mean_dt)
    found = unpack(bound, ARRAYS)
    x, u, v, out = found[0], found[1], found[12], found[13]
    for i in range(x.size):
        out[i] = x[i] + (u[i] + dt * v[i])


@kernel
def _push(trial, compliance, contact, rate):
    for i in range(trial.size):
        trial[i] += rate * (compliance[i] * contact[i])


@kernel
def _advance(trial, velocity, displacement, dt):
    """Displacements and velocities from `trial`, which becomes the mean velocity."""
    for i in range(trial.size):
        after = trial[i]
        trial[i] = 0.5 * (velocity[i] + after)
        velocity[i] = after
        displacement[i] += dt * after


@kernel
def move(bound, loaded, alpha, dt, mean_dt):
    """Make the whole step where nothing is in contact."""
    _trial(bound, loaded, alpha, dt, mean_dt)
    found = unpack(bound, ARRAYS)
    u, v, dof, before, trial = found[1], found[2], found[7], found[11], found[12]
    for i in range(dof.size):
        before[i] = v[dof[i]]
    _advance(trial, v, u, dt)
    _book(bound, loaded, False, alpha, dt, mean_dt)


@kernel
def correct(bound, loaded, alpha, dt, mean_dt):
    """Add the contact forces' share of `trial`, move the nodes, and book the step."""
    found = unpack(bound, ARRAYS)
    u, v, dof, before, trial, contact, compliance = (
        found[1], found[2], found[7], found[11], found[12], found[14], found[15]
    )  # fmt: skip
    for i in range(dof.size):
        before[i] = v[dof[i]]
    _push(trial, compliance, contact, 1.0 / dt)
    _advance(trial, v, u, dt)
    _book(bound, loaded, True, alpha, dt, mean_dt)


@kernel
def _power(mean, force, products):
    """Sum of mean * force. Pairwise: vector additions, the same on every machine, and small errors."""
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
def _damped_beside(mass, mean, drift):
    total = 0.0
    for n in range(mass.size):
        x, y = 2 * n, 2 * n + 1
        total += mass[n] * (mean[x] * (mean[x] - drift[x]) + mean[y] * (mean[y] - drift[y]))
    return total


@kernel
def _follow(mean, drift, share):
    for i in range(mean.size):
        drift[i] += share * (mean[i] - drift[i])


@kernel
def _book(bound, loaded, touching, alpha, dt, mean_dt):
    """Work of every force with the mean velocity, and reactions of prescribed motion.

    work = internal, external (with reactions), damping, contact, ... (see contactlab.api.WORK); only
    what acts is summed.
    """
    (
        _, _, v, f, e, _, mass, dof, _, _, _, before, mean, _, y, _, r, work, products, drift, relaxation,
    ) = unpack(bound, ARRAYS)  # fmt: skip
    work[0] += mean_dt * _power(mean, f, products)
    load = _power(mean, e, products) if loaded else 0.0
    if touching:
        work[3] += mean_dt * _power(mean, y, products)
    if alpha != 0.0:
        work[2] += mean_dt * alpha * (_damped_beside(mass, mean, drift) if drift.size > 0 else _damped(mass, mean))
    for k in range(dof.size):
        i = dof[k]
        needed = mass[i // 2] * ((v[i] - before[k]) / mean_dt + alpha * mean[i]) + f[i]
        needed -= mass[i // 2] * alpha * drift[i] if drift.size > 0 else 0.0
        needed -= e[i] if loaded else 0.0
        needed -= y[i] if touching else 0.0
        r[i] = needed
        load += mean[i] * needed
    work[1] += mean_dt * load
    if drift.size > 0:
        _follow(mean, drift, mean_dt / (relaxation[0] + 0.5 * mean_dt))
