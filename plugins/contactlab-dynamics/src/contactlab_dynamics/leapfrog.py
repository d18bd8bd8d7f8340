"""Node updates of the central-difference scheme, with the energy ledger (formulation 1.1 and 1.5)."""

from __future__ import annotations

from contactlab.api.kernel import kernel


@kernel
def predict(
    reference, displacement, velocity, internal, external, inverse_mass, alpha, dt, mean_dt,
    dof, scale, ramp, ramp_values, trial, predicted,
):  # fmt: skip
    """Velocities `trial` and positions `predicted` (N, 2) without contact forces; prescribed motion is exact.

    v+ = [(1 - alpha dt/2) v- + dt M^-1 f]/(1 + alpha dt/2), x* = x + dt v+
    """
    keep, gain = 1.0 - 0.5 * alpha * mean_dt, mean_dt
    scaling = 1.0 / (1.0 + 0.5 * alpha * mean_dt)
    for n in range(displacement.shape[0]):
        for c in range(2):
            acceleration = (external[n, c] - internal[n, c]) * inverse_mass[n]
            trial[n, c] = (keep * velocity[n, c] + gain * acceleration) * scaling
    for i in range(dof.size):
        n, c = dof[i] // 2, dof[i] % 2
        trial[n, c] = (scale[i] * ramp_values[ramp[i]] - displacement[n, c]) / dt
    for n in range(displacement.shape[0]):
        for c in range(2):
            predicted[n, c] = reference[n, c] + (displacement[n, c] + dt * trial[n, c])


@kernel
def correct(
    mass, external, contact, compliance, alpha, dt, mean_dt, dof, trial, displacement, velocity, internal,
    reaction, work,
):  # fmt: skip
    """Add the contact forces' share, move the nodes, and book the work of every force with the mean velocity.

    work = internal, external (with reactions), damping, contact, ... (see contactlab.api.WORK)
    """
    stress, load, damped, pressed = 0.0, 0.0, 0.0, 0.0
    for n in range(mass.size):
        for c in range(2):
            before = velocity[n, c]
            after = trial[n, c] + compliance[n, c] * contact[n, c] / dt
            mean = 0.5 * (before + after)
            stress += mean * internal[n, c]
            load += mean * external[n, c]
            pressed += mean * contact[n, c]
            damped += alpha * mass[n] * mean * mean
            trial[n, c] = mean
            reaction[n, c] = mass[n] * ((after - before) / mean_dt + alpha * mean)
            velocity[n, c] = after
            displacement[n, c] += dt * after
    supported = 0.0
    for i in range(dof.size):
        n, c = dof[i] // 2, dof[i] % 2
        needed = reaction[n, c] - external[n, c] + internal[n, c] - contact[n, c]
        supported += trial[n, c] * needed
    work[0] += mean_dt * stress
    work[1] += mean_dt * (load + supported)
    work[2] += mean_dt * damped
    work[3] += mean_dt * pressed
    for n in range(mass.size):
        for c in range(2):
            reaction[n, c] += internal[n, c] - external[n, c] - contact[n, c]
