"""Checks of contact by potentials: energy, its derivatives, and steps that may be taken."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats, FrictionBound, Potential, PotentialView
from contactlab.contact.potential_pair import differences
from contactlab.testing.assertions import Check, NotApplicable, agree, require, untouched
from contactlab.testing.surfaces import chains, consistent_loads, flat, pair_of, rotation, stations

INSIDE = 0.05  # of a segment that surfaces overlap if the potential lets them
STEP = 1e-6  # of a segment: differences of energies and gradients
DIFFERENCES = 1e-4  # of the largest entry: differences across kinks of closest points, and round-off
ROUND_OFF = 1e-9  # of the largest force
EVEN = 1e-11  # of the largest force: round-off of sums over segments


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
    require(0.0 < largest < np.inf, f"the largest force of pressed surfaces is {largest:.3g} N")
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


def patch_test(potential: Potential) -> None:
    """A uniform overlap of sides of one length presses both evenly whatever the meshes, if the part declares so."""
    if not potential.passes_patch_test:
        raise NotApplicable("the part declares that it fails the patch test")
    for order, edges in ((1, (6, 5)), (1, (3, 8)), (2, (3, 4))):
        x = (stations(0.0, 2.0, count, order, seed) for seed, count in enumerate(edges))
        slave, master = (np.stack([side, np.zeros_like(side)], axis=1) for side in x)
        at = chains(slave, master, order)
        at = at.lifted((0.0, -INSIDE * at.spacing))
        pair = pair_of(potential, at)[0]
        m, force = len(at.slave.nodes), np.zeros_like(at.nodes)
        force[pair.nodes] = -potential.gradient(pair.view, pair.view.reference)
        loads = consistent_loads(at, at.slave, 0.0, 2.0) - consistent_loads(at, at.master, 0.0, 2.0)
        even = np.stack([np.zeros(len(loads)), loads * 0.5 * force[at.slave.nodes, 1].sum()], axis=1)
        what = (
            f"forces of a uniform overlap, {edges[0]} {'straight' if order == 1 else 'quadratic'} edges on {edges[1]}"
        )
        agree(force, even, EVEN * np.abs(even).max(), what)
        found = potential.nodal_forces(pair.view, pair.view.reference)
        if found is not None:
            pressure = found.push[:, 1] / pair.full[:m]
            mean = float(pressure.mean())
            agree(pressure, np.full(m, mean), EVEN * abs(mean), f"pressures of a uniform overlap, order {order}")


def shown_forces_sum_to_those_that_act(potential: Potential) -> None:
    """Shown forces of slave nodes sum to the acting forces, however far the slave hangs over the master's end."""
    view, at = _pressed(potential)
    m = len(view.slave.nodes)
    view = view._replace(friction=FrictionBound(0.3, 0.0, np.inf) if potential.rubs else None)
    close = ROUND_OFF * m * _scale(potential, view, at)
    for beyond in np.linspace(0.0, float(np.ptp(at[:m, 0])), 12, endpoint=False):
        slid = at + np.outer(np.arange(len(at)) < m, [beyond, 0.0])
        view.start[:] = view.lagged[:] = slid
        slid[:m, 0] += 0.1 * float(view.length.min())
        found = potential.nodal_forces(view, slid)
        if found is None:
            raise NotApplicable("the core shows the forces that act")
        force = -potential.gradient(view, slid)[:m]
        agree(found.push.sum(axis=0), force.sum(axis=0), close, "sum of the forces of the energy")
        if potential.rubs:
            rub = -potential.friction_gradient(view, slid)[:m]
            agree(found.rub.sum(axis=0), rub.sum(axis=0), close, "sum of the forces of friction")


def no_force_when_apart(potential: Potential) -> None:
    """Surfaces that are two segments apart have no force."""
    view, at = _pressed(potential, lift=2.0 * flat().spacing)
    agree(potential.gradient(view, at), np.zeros_like(at), 0.0, "force on surfaces that are apart")
    require(potential.largest_step(view, at, np.zeros_like(at)) == 1.0, "largest_step: it cuts a motion of zero")


def steps_end_before_surfaces_meet(potential: Potential) -> None:
    """A motion through the master is cut to a part after which the energy is finite; other motions are not cut."""
    view, at = _pressed(potential)
    if not potential.clearance(view) > 0.0:
        raise NotApplicable("surfaces may overlap: clearance is 0")
    through = np.zeros_like(at)
    through[: len(view.slave.nodes), 1] = -1.0
    share = potential.largest_step(view, at, through)
    require(0.0 < share < 1.0, f"largest_step: {share} of a motion through the master, needed: more than 0, below 1")
    require(np.isfinite(potential.energy(view, at + share * through)), "energy after the largest step is not finite")
    require(potential.largest_step(view, at, -through) == 1.0, "largest_step: it cuts a separating motion")


def friction_opposes_slip(potential: Potential) -> None:
    """Friction is zero without slip, takes energy, and is nearly the bound after a slip, at most."""
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
    rubbed = np.abs(force[: len(view.slave.nodes), 0]).sum()
    require(rubbed <= 0.31 * pressed, "friction is above its bound")
    require(
        rubbed >= 0.2 * pressed,
        f"friction of a slip of a tenth of a segment is {rubbed / (0.3 * pressed):.2g} of its bound",
    )


def friction_hessian_is_the_derivative(potential: Potential) -> None:
    """The Hessian of friction is the derivative of its gradient, whether points stick or slide."""
    view, at = _pressed(potential)
    if not potential.rubs:
        raise NotApplicable("it has no friction")
    view = view._replace(friction=FrictionBound(0.3, 0.0, np.inf))
    if potential.friction_hessian(view, at) is None:
        raise NotApplicable("the core takes differences of its gradient")
    small = 1e-4 * (potential.clearance(view) or float(view.length.min()))
    stiffest = float(np.abs(potential.friction_hessian(view, at).toarray()).max())
    for slip in (0.0, small, 100.0 * small):
        moved = at.copy()
        moved[: len(view.slave.nodes), 0] += slip
        dense = potential.friction_hessian(view, moved).toarray()
        agree(dense, dense.T, ROUND_OFF * stiffest, "Hessian of friction against its transpose")
        found = differences(potential.friction_gradient, view, moved, 1e-3 * small)
        agree(dense, found, 1e-2 * stiffest, f"derivative of friction after a slip of {slip:.3g} mm")


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
    patch_test,
    shown_forces_sum_to_those_that_act,
    rigid_motions_keep_the_energy,
    no_force_when_apart,
    steps_end_before_surfaces_meet,
    friction_opposes_slip,
    friction_hessian_is_the_derivative,
    arrays_are_only_read,
)
