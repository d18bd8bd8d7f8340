"""Node updates of the central-difference scheme, with the energy ledger (docs/theory/explicit-scheme.md).

A step without contact is `move`, one with contact `predict` and, when the contact forces are known,
`correct`; both end with `book`. Fields are taken as flat arrays of degrees of freedom, `mobility` being the
inverse mass of each, 0 where motion is prescribed.
"""

from __future__ import annotations

from contactlab.api.kernel import kernel

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
def _trial(
    displacement, velocity, internal, external, loaded, mobility, alpha, dt, mean_dt, dof, scale, ramp, ramps, trial
):  # fmt: skip
    """v+ = [(1 - alpha dt/2) v- + dt M^-1 f]/(1 + alpha dt/2), and what is prescribed, into `trial`."""
    scaling = 1.0 / (1.0 + 0.5 * alpha * mean_dt)
    keep, gain = (1.0 - 0.5 * alpha * mean_dt) * scaling, mean_dt * scaling
    v, f, e = velocity.reshape(velocity.size), internal.reshape(internal.size), external.reshape(external.size)
    u, new = displacement.reshape(displacement.size), trial.reshape(trial.size)
    _velocities(v, f, e, loaded, mobility.reshape(mobility.size), keep, gain, new)
    for i in range(dof.size):
        new[dof[i]] = (scale[i] * ramps[ramp[i]] - u[dof[i]]) / dt


@kernel
def predict(
    reference, displacement, velocity, internal, external, loaded, mobility, alpha, dt, mean_dt, dof, scale, ramp,
    ramps, trial, predicted,
):  # fmt: skip
    """Velocities `trial` and positions `predicted` (N, 2) without contact forces; prescribed motion is exact."""
    _trial(
        displacement, velocity, internal, external, loaded, mobility, alpha, dt, mean_dt, dof, scale, ramp, ramps, trial
    )
    x, u = reference.reshape(reference.size), displacement.reshape(displacement.size)
    v, out = trial.reshape(trial.size), predicted.reshape(predicted.size)
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
def move(
    displacement, velocity, internal, external, loaded, mobility, alpha, dt, mean_dt, dof, scale, ramp, ramps, before,
    trial,
):  # fmt: skip
    """The whole step where nothing is in contact; `before` receives the old velocities of prescribed motion."""
    _trial(
        displacement, velocity, internal, external, loaded, mobility, alpha, dt, mean_dt, dof, scale, ramp, ramps, trial
    )
    u, v = displacement.reshape(displacement.size), velocity.reshape(velocity.size)
    for i in range(dof.size):
        before[i] = v[dof[i]]
    _advance(trial.reshape(trial.size), v, u, dt)


@kernel
def correct(contact, compliance, dt, dof, before, trial, displacement, velocity):
    """Add the contact forces' share of `trial` and move the nodes; `before` as in `move`."""
    new, v = trial.reshape(trial.size), velocity.reshape(velocity.size)
    for i in range(dof.size):
        before[i] = v[dof[i]]
    _push(new, compliance.reshape(compliance.size), contact.reshape(contact.size), 1.0 / dt)
    _advance(new, v, displacement.reshape(displacement.size), dt)


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
        total += mass[n] * (mean[n, 0] * mean[n, 0] + mean[n, 1] * mean[n, 1])
    return total


@kernel
def book(
    mass, external, loaded, contact, touching, internal, alpha, mean_dt, dof, before, velocity, trial, reaction, work,
    products,
):  # fmt: skip
    """Work of every force with the mean velocity, and reactions of prescribed motion.

    work = internal, external (with reactions), damping, contact, ... (see contactlab.api.WORK); only
    what acts is summed.
    """
    mean, f = trial.reshape(trial.size), internal.reshape(internal.size)
    e, y = external.reshape(external.size), contact.reshape(contact.size)
    v, r = velocity.reshape(velocity.size), reaction.reshape(reaction.size)
    work[0] += mean_dt * _power(mean, f, products)
    load = _power(mean, e, products) if loaded else 0.0
    if touching:
        work[3] += mean_dt * _power(mean, y, products)
    if alpha != 0.0:
        work[2] += mean_dt * alpha * _damped(mass, trial)
    for k in range(dof.size):
        i = dof[k]
        needed = mass[i // 2] * ((v[i] - before[k]) / mean_dt + alpha * mean[i]) + f[i]
        needed -= e[i] if loaded else 0.0
        needed -= y[i] if touching else 0.0
        r[i] = needed
        load += mean[i] * needed
    work[1] += mean_dt * load
