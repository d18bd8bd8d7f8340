"""Checks of contact by potentials: energy, its derivatives, and steps that may be taken."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats, FrictionBound, Potential, PotentialView
from contactlab.contact.potential_pair import differences
from contactlab.testing.assertions import Check, NotApplicable, agree, require, untouched
from contactlab.testing.surfaces import flat, pair_of, rotation

INSIDE = 0.05  # of a segment that surfaces overlap if the potential lets them
STEP = 1e-6  # of a segment: differences of energies and gradients
DIFFERENCES = 1e-4  # of the largest entry: differences across kinks of closest points, and round-off
ROUND_OFF = 1e-9  # of the largest force


def _pressed(potential: Potential, lift: float | None = None) -> tuple[PotentialView, Floats]:
    """A view, and positions at which surfaces press: within the clearance, or with some overlap."""
    at = flat()
    clearance = pair_of(potential, at)[0].potential.clearance(pair_of(potential, at)[0].view)
    by = lift if lift is not None else 0.5 * clearance if clearance > 0.0 else -INSIDE * at.spacing
    pair = pair_of(potential, at.lifted((0.0, by)))[0]
    wave = np.random.default_rng(5).uniform(-0.02, 0.02, pair.view.reference.shape) * abs(by)
    positions = pair.view.reference + wave
    pair.view.start[:], pair.view.lagged[:] = positions, positions
    return pair.view, positions


def _scale(potential: Potential, view: PotentialView, positions: Floats) -> float:
    largest = float(np.abs(potential.gradient(view, positions)).max())
    require(0.0 < largest < np.inf, f"surfaces that press have a largest force of {largest:.3g} N")
    return largest


def gradient_is_the_derivative(potential: Potential) -> None:
    """The gradient is the derivative of the energy."""
    view, at = _pressed(potential)
    largest, step = _scale(potential, view, at), STEP * float(view.length.max())
    step = min(step, 1e-4 * (potential.clearance(view) or np.inf))
    rng = np.random.default_rng(3)
    for _ in range(6):
        along = rng.normal(size=at.shape)
        rise = potential.energy(view, at + step * along) - potential.energy(view, at - step * along)
        work = float(np.vdot(potential.gradient(view, at), along))
        agree(rise / (2.0 * step), work, 10.0 * DIFFERENCES * largest, "derivative of the energy along a motion")


def hessian_is_the_derivative(potential: Potential) -> None:
    """The Hessian is symmetric and the derivative of the gradient."""
    view, at = _pressed(potential)
    given = potential.hessian(view, at)
    if given is None:
        raise NotApplicable("the core takes differences of its gradient")
    dense = given.toarray()
    step = min(STEP * float(view.length.max()), 1e-4 * (potential.clearance(view) or np.inf))
    found = differences(potential.gradient, view, at, step)
    largest = float(np.abs(dense).max())
    agree(dense, dense.T, ROUND_OFF * largest, "Hessian against its transpose")
    agree(dense, found, DIFFERENCES * largest + _scale(potential, view, at) * 1e-8 / step, "derivative of the gradient")


def forces_balance(potential: Potential) -> None:
    """Forces have no resultant and no moment, and push the slave away from the master."""
    view, at = _pressed(potential)
    largest, force = _scale(potential, view, at), -potential.gradient(view, at)
    agree(force.sum(axis=0), np.zeros(2), ROUND_OFF * largest * len(at), "resultant")
    moment = float((at[:, 0] * force[:, 1] - at[:, 1] * force[:, 0]).sum())
    agree(moment, 0.0, 10.0 * ROUND_OFF * largest * len(at) * float(np.abs(at).max()), "moment")
    require(force[: len(view.slave.nodes), 1].sum() > 0.0, "the slave is pulled towards the master")


def rigid_motions_keep_the_energy(potential: Potential) -> None:
    """A rigid motion of both surfaces leaves the energy as it is, and turns the forces."""
    view, at = _pressed(potential)
    largest, turn = _scale(potential, view, at), rotation(0.4).T
    moved = at @ turn + (3.0, -2.0)
    energy = potential.energy(view, at)
    agree(potential.energy(view, moved), energy, 1e-8 * abs(energy), "energy after a rigid motion")
    agree(potential.gradient(view, moved), potential.gradient(view, at) @ turn, 1e-7 * largest, "forces, turned")


def no_force_when_apart(potential: Potential) -> None:
    """Surfaces that are two segments apart have no force."""
    view, at = _pressed(potential, lift=2.0 * flat().spacing)
    agree(potential.gradient(view, at), np.zeros_like(at), 0.0, "force on surfaces that are apart")
    require(potential.largest_step(view, at, np.zeros_like(at)) == 1.0, "largest_step: it cuts no motion at all")


def steps_end_before_surfaces_meet(potential: Potential) -> None:
    """Of a motion through the master a part is allowed, after which the energy is finite; of others all."""
    view, at = _pressed(potential)
    if not potential.clearance(view) > 0.0:
        raise NotApplicable("surfaces may overlap: clearance is 0")
    through = np.zeros_like(at)
    through[: len(view.slave.nodes), 1] = -1.0
    share = potential.largest_step(view, at, through)
    require(0.0 < share < 1.0, f"largest_step: {share} of a motion through the master, needed: more than 0, below 1")
    require(np.isfinite(potential.energy(view, at + share * through)), "energy after the largest step is not finite")
    require(potential.largest_step(view, at, -through) == 1.0, "largest_step: surfaces that part are held back")


def friction_opposes_slip(potential: Potential) -> None:
    """Friction is zero without slip, takes energy, and is at most the bound."""
    view, at = _pressed(potential)
    if not potential.rubs:
        raise NotApplicable("it has no friction")
    view = view._replace(friction=FrictionBound(0.3, 0.0, np.inf))
    still = np.asarray(potential.friction_gradient(view, at))
    agree(still, np.zeros_like(at), ROUND_OFF * _scale(potential, view, at), "friction without slip since view.start")
    slip = np.zeros_like(at)
    slip[: len(view.slave.nodes), 0] = 0.1 * float(view.length.min())
    force = -potential.friction_gradient(view, at + slip)
    require(float(np.vdot(force, slip)) < 0.0, "friction does positive work in a slip")
    agree(force.sum(axis=0), np.zeros(2), 1e-7 * float(np.abs(force).max()) * len(at), "resultant of friction")
    pressed = np.abs(potential.gradient(view, at)[: len(view.slave.nodes)]).sum()
    require(np.abs(force[: len(view.slave.nodes), 0]).sum() <= 0.31 * pressed, "friction is above its bound")


def arrays_are_only_read(potential: Potential) -> None:
    """Positions and view stay as they are, and the same question has the same answer to the last bit."""
    view, at = _pressed(potential)
    with untouched(positions=at, reference=view.reference, length=view.length, start=view.start, lagged=view.lagged):
        first, again = (np.asarray(potential.gradient(view, at)) for _ in range(2))
        potential.energy(view, at)
        potential.hessian(view, at)
        potential.largest_step(view, at, np.zeros_like(at))
    require(np.array_equal(first, again), "gradient: two calls differ, bit-identical results are required")


CHECKS: tuple[Check, ...] = (
    gradient_is_the_derivative,
    hessian_is_the_derivative,
    forces_balance,
    rigid_motions_keep_the_energy,
    no_force_when_apart,
    steps_end_before_surfaces_meet,
    friction_opposes_slip,
    arrays_are_only_read,
)
