"""Checks of enforcements for implicit integrators: conditions on single springs, solved by Newton's method."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import NamedTuple

import numpy as np

from contactlab.api import Conditions, Enforcement, Floats, ImplicitEnforcement, Response
from contactlab.testing.assertions import Check, Expected, NotApplicable, agree, identical, require, tell, untouched
from contactlab.testing.other_values import without_effect
from contactlab.testing.scales import scale_of
from contactlab.testing.units import FORCE, LONG, STRESS, in_other_units, same_in_other_units

COUNT, MU = 60, 0.3
STEP = 1e-7  # of gaps and forces of order one: differences of piecewise linear functions, round-off over it is 1e-9
NEWTON, AUGMENTATIONS = 30, 60
CLOSED = 1e-9  # mm, of overlaps of order one


def some_conditions(count: int = COUNT, friction: bool = True, seed: int = 1) -> tuple[Conditions, Response]:
    """Conditions of both signs of gap, some absent, with forces of both sides of every bound; room for the response."""
    rng, rows = np.random.default_rng(seed), 2 if friction else 1
    present = rng.uniform(size=count) > 0.1
    force = np.stack([rng.uniform(0.0, 2.0, count), rng.uniform(-1.0, 1.0, count)][:rows])
    force[:, ~present] = 0.0
    slots = count if friction else 0
    bound = np.tile([[MU], [0.2], [2.0]], slots)
    conditions = Conditions(
        present, rng.uniform(-1.0, 1.0, count), rng.uniform(-1.0, 1.0, slots), force, force * 0.9,
        rng.uniform(0.5, 1.5, count), np.ones(count), bound, rng.uniform(0.5, 2.0, count),
    )  # fmt: skip
    return conditions, _garbage(rows, count)


def _garbage(rows: int, count: int) -> Response:
    """Room that has to be filled."""
    out = Response.allocate(rows, count)
    for array in (out.residual, out.by_force, out.by_gap, out.cross_force, out.cross_gap):
        array[:] = np.nan
    out.status[:] = 7
    return out


def _implicit(enforcement: Enforcement) -> ImplicitEnforcement:
    if not isinstance(enforcement, ImplicitEnforcement):
        raise NotApplicable("the enforcement is not for implicit integrators")
    return enforcement


def _respond(enforcement: ImplicitEnforcement, conditions: Conditions) -> Response:
    out = _garbage(*conditions.force.shape)
    enforcement.respond(conditions, out)
    return out


class Solved(NamedTuple):
    """Springs after Newton's method: gaps, slips (k,) and forces (r, k), and iterations of the last round."""

    gap: Floats
    slip: Floats
    force: Floats
    iterations: int
    status: Floats


def _solve(enforcement: ImplicitEnforcement, friction: bool, seed: int = 1) -> tuple[Solved, Conditions]:
    """Every slot has its own spring: gap = g0 + y_n/k, slip = d0 + y_t/k, from no force at all."""
    given, _ = some_conditions(friction=friction, seed=seed)
    given.gap[:] *= scale_of(enforcement, "length_scale", 1.0)
    free = replace(given, force=np.zeros_like(given.force), anchor=np.zeros_like(given.force))
    now, iterations = free, 0
    for _ in range(AUGMENTATIONS if enforcement.augments else 1):
        now, iterations = _iterated(enforcement, free, now)
        moved = float(np.abs(now.force - now.anchor).max())
        now.anchor[:] = now.force
        if moved < 1e-13:
            break
    return Solved(now.gap, now.slip, now.force, iterations, _respond(enforcement, now).status), free


def _iterated(enforcement: ImplicitEnforcement, free: Conditions, now: Conditions) -> tuple[Conditions, int]:
    k, force = free.stiffness, now.force.copy()
    for iteration in range(NEWTON):
        gap, slip = free.gap + force[0] / k, free.slip + (force[1] / k if len(force) > 1 else 0.0)
        now = replace(now, gap=gap, slip=slip, force=force.copy())
        found = _respond(enforcement, now)
        require(np.all(np.isfinite(found.residual)), "residual: not filled, or not finite")
        if float(np.abs(found.residual).max()) < 1e-12:
            return now, iteration
        # gaps follow the force of their own slot
        normal = -found.residual[0] / (found.by_force[0] + found.by_gap[0] / k)
        force[0] += normal
        if len(force) > 1:
            cross = (found.cross_force + found.cross_gap / k) * normal
            force[1] -= (found.residual[1] + cross) / (found.by_force[1] + found.by_gap[1] / k)
    left = float(np.abs(found.residual).max())
    raise AssertionError(
        f"Newton's method on single springs leaves a residual of {left:.1e} N after {NEWTON} iterations"
    )


def response_is_filled(enforcement: Enforcement) -> None:
    """Residuals, their derivatives and the status of every slot are written, with friction and without."""
    part = _implicit(enforcement)
    for friction in (True, False):
        conditions, _ = some_conditions(friction=friction)
        found = _respond(part, conditions)
        for entry in ("residual", "by_force", "by_gap", "cross_force", "cross_gap"):
            require(np.all(np.isfinite(getattr(found, entry))), f"{entry}: a slot was left unfilled, or is not finite")
        allowed = (0, 1, 2) if friction else (0, 2)
        got = sorted(set(found.status.tolist()))
        text = f"status {'with' if friction else 'without'} friction: got {got}, allowed {', '.join(map(str, allowed))}"
        require(set(got) <= set(allowed), text)


def response_is_linearised(enforcement: Enforcement) -> None:
    """`by_force`, `by_gap`, `cross_force` and `cross_gap` are the derivatives of the residuals."""
    part = _implicit(enforcement)
    for seed in range(3):
        conditions, _ = some_conditions(seed=seed)
        conditions.gap[:] *= scale_of(enforcement, "length_scale", 1.0)
        found, expected = _respond(part, conditions), {}
        for name, row in (("force", 0), ("force", 1), ("gap", 0), ("slip", 0)):
            # forward and backward differences (2, k) of both residuals by a change of every slot
            sides = []
            size = STEP * (scale_of(part, "length_scale", 1.0) if name == "gap" else 1.0)
            for sign in (1.0, -1.0):
                moved = np.array(getattr(conditions, name))
                moved[(row,) if name == "force" else ()] += sign * size
                residual = _respond(part, replace(conditions, **{name: moved})).residual
                sides.append(sign * (residual - found.residual) / size)
            expected[name, row] = sides[0], sides[1]
        _agree_where_smooth(found.by_force[0], expected["force", 0], 0, "by_force of normal rows")
        _agree_where_smooth(found.by_force[1], expected["force", 1], 1, "by_force of tangential rows")
        _agree_where_smooth(found.by_gap[0], expected["gap", 0], 0, "by_gap of normal rows")
        _agree_where_smooth(found.by_gap[1], expected["slip", 0], 1, "by_gap of tangential rows")
        _agree_where_smooth(found.cross_force, expected["force", 0], 1, "cross_force")
        _agree_where_smooth(found.cross_gap, expected["gap", 0], 1, "cross_gap")


def _agree_where_smooth(got: Floats, expected: tuple[Floats, Floats], row: int, what: str) -> None:
    forward, backward = expected[0][row], expected[1][row]
    smooth = np.abs(forward - backward) < 1e-6
    require(int(smooth.sum()) > COUNT // 2, f"{what}: the residual has jumps or kinks at most slots")
    agree(got[smooth], forward[smooth], 1e-6, f"{what} against differences of the residual")


def closed_gaps_bear_forces(enforcement: Enforcement) -> None:
    """Overlaps of springs are removed by pushing forces; open or absent conditions have no force."""
    part = _implicit(enforcement)
    done, free = _solve(part, friction=False)
    overlapping = free.present & (free.gap < 0.0)
    require(np.all(done.force[0] >= -1e-12), f"a condition pulls with {-done.force[0].min():.1e} N")
    require(np.all(done.force[0][overlapping] > 0.0), "an overlap has no force")
    gone = ~free.present if part.pressure_before_contact else ~overlapping
    agree(done.force[0][gone], 0.0 * done.force[0][gone], 1e-12, "force of an open or absent condition")
    if part.pressure_before_contact:
        order = np.argsort(free.gap[overlapping] * free.stiffness[overlapping])
        require(bool(done.force[0][overlapping][order[0]] > 0.0), "the deepest overlap has no force")
        raise NotApplicable("assumes that open conditions have no force: pressure_before_contact is True")
    full = -free.gap * free.stiffness
    require(
        np.all(done.force[0][overlapping] <= full[overlapping] * (1.0 + 1e-9)), "a force exceeds what closes its gap"
    )
    require(np.all(done.status[overlapping] > 0), "status: a closed condition is reported as open")
    require(np.all(done.status[~overlapping] == 0), "status: an open condition is reported as closed")


def exactness_is_declared(enforcement: Enforcement) -> None:
    """Closed gaps are zero if the part declares that it is `exact`; springs leave an overlap."""
    part = _implicit(enforcement)
    if part.pressure_before_contact:
        require(not part.exact, "pressure_before_contact is True, so closed gaps are not zero; declare exact = False")
        raise NotApplicable("assumes that pressure begins where the gap closes: pressure_before_contact is True")
    done, free = _solve(part, friction=False)
    closed = done.force[0] > 0.0
    left = float(np.abs(done.gap[closed]).max())
    if part.exact:
        require(left <= CLOSED, f"a closed gap is {left:.1e} mm, allowed {CLOSED:.0e} mm: exact is True")
    elif left <= CLOSED:
        tell("closed gaps are zero; declare exact = True")
    else:
        worst = float(np.abs(free.gap[closed]).max())
        text = f"an overlap of {left:.1e} mm is left of {worst:.1e} mm, allowed: a tenth of it"
        require(bool(part.length_scale) or left < 0.1 * worst, text)  # a curve gives way by its own length
        raise Expected(f"a closed gap is {left:.1e} mm; exact is False")


def friction_keeps_its_bound(enforcement: Enforcement) -> None:
    """Tangential forces stay within the bound; sticking conditions do not slip, slipping forces oppose it."""
    part = _implicit(enforcement)
    done, free = _solve(part, friction=True)
    normal, rub = done.force
    adhesion = np.minimum(0.2 * free.measure, 2.0 * normal)
    limit = np.where(free.present, MU * normal + adhesion, 0.0)
    over = float((np.abs(rub) - limit).max())
    require(over <= 1e-9, f"a tangential force exceeds its bound by {over:.1e} N")
    sliding = (np.abs(rub) >= limit - 1e-9) & (limit > 0.0)
    sticking = (limit > 0.0) & ~sliding
    require(bool(sliding.any()) or bool(part.time_scale), "no force is at its bound, but some slots move far")
    require(bool(sticking.any()) or bool(part.length_scale), "every force is at its bound, but some slots hardly move")
    if part.time_scale:
        raise NotApplicable("assumes that what slips carries its whole bound: it depends on the rate (time_scale)")
    require(np.all((rub * done.slip)[sliding] <= 1e-9), "friction of a slipping condition acts along its slip")
    slip = float(np.abs(done.slip[sticking]).max(initial=0.0))
    allowed = CLOSED if part.exact else 0.1
    require(slip <= allowed, f"a sticking condition slips by {slip:.1e} mm, allowed {allowed:.0e} mm")
    require(np.all(done.status[sticking] == 1), "status: a sticking condition is not reported as 1")
    require(np.all(done.status[sliding] == 2), "status: a slipping condition is not reported as 2")


def what_rests_keeps_its_friction(enforcement: Enforcement) -> None:
    """A condition that has not slipped since the last step carries the friction that it had there."""
    part = _implicit(enforcement)
    if part.time_scale:
        raise NotApplicable("assumes that friction at rest does not change: it depends on the rate (time_scale)")
    conditions, _ = some_conditions()
    conditions.slip[:], conditions.gap[:] = 0.0, -np.abs(conditions.gap) * scale_of(part, "length_scale", 1.0)
    conditions.force[1] = 0.3 * MU * conditions.force[0] * np.sign(conditions.force[1])
    conditions.anchor[1] = conditions.force[1]
    held = conditions.present & (conditions.force[0] > 0.1)
    found = _respond(part, conditions).residual[1][held]
    agree(found, 0.0 * found, 1e-9, "residual of the last step's friction, without slip")


def numbers_change_the_response(enforcement: Enforcement) -> None:
    """Another number for a field changes some residual; of exact forces it may change how they are found alone."""
    part = _implicit(enforcement)
    for name in without_effect(part, lambda other: _all_of(other)):
        if part.exact:
            raise NotApplicable(f"exact is True, so the field {name} need not change a residual")
        raise AssertionError(f"the field {name} never changes a residual or a status")


def _all_of(part: ImplicitEnforcement) -> list[Floats]:
    found = []
    for size in (scale_of(part, "length_scale", 1.0), 1e-4, 1e-9):
        conditions, _ = some_conditions()
        conditions.gap[:] *= size
        conditions.slip[:] *= size
        response = _respond(part, conditions)
        found += [np.array(getattr(response, f.name)) for f in fields(response)]
    return found


def units_do_not_matter_to_it(enforcement: Enforcement) -> None:
    """Forces are the same in m, ms and kPa as in mm, s and MPa, by the units of the docstring."""
    part = _implicit(enforcement)
    other, (conditions, _) = in_other_units(part), some_conditions()
    scale = scale_of(part, "length_scale", 1e-3)
    conditions.gap[:] *= scale
    conditions.slip[:] *= scale
    bound = conditions.bound * [[1.0], [STRESS], [1.0]]
    scaled = replace(
        conditions, gap=LONG * conditions.gap, slip=LONG * conditions.slip, force=FORCE * conditions.force,
        anchor=FORCE * conditions.anchor, measure=LONG * conditions.measure, size=LONG * conditions.size,
        stiffness=STRESS * conditions.stiffness, bound=bound,
    )  # fmt: skip
    found, wanted = _respond(other, scaled), _respond(part, conditions)
    for name, by in {"residual": FORCE, "by_gap": STRESS, "by_force": 1.0}.items():
        for row, which in enumerate(("normal", "tangential")):
            what = f"{name} of {which} rows"
            same_in_other_units(getattr(found, name)[row], getattr(wanted, name)[row], by, what)


def few_iterations(enforcement: Enforcement) -> None:
    """Newton's method on single springs needs a handful of iterations, some more if the law is curved."""
    part = _implicit(enforcement)
    # whether the force of some slot follows its gap with more slopes than the few of a piecewise linear law
    conditions, _ = some_conditions(friction=False)
    sweep = np.concatenate([-np.logspace(0.0, -8.0, 33), np.logspace(-8.0, 0.0, 33)])
    slopes = np.stack([_respond(part, replace(conditions, gap=np.full(COUNT, gap))).by_gap[0] for gap in sweep])
    smooth = any(len(np.unique(slot)) > 4 for slot in slopes.T)
    # each piece is linear: open or closed, then stick or slip, and a sign that turns. Where pieces are joined by a bend
    # iterations of quadratic convergence follow: six, as 0.5 to the power of 2^6 is below round-off
    allowed, kind = (12, "bend smoothly") if smooth else (6, "are piecewise linear")
    for seed in range(3):
        done, _ = _solve(part, friction=True, seed=seed)
        require(done.iterations <= allowed, f"{done.iterations} iterations on springs that {kind}, allowed {allowed}")


def slots_know_nothing_of_each_other(enforcement: Enforcement) -> None:
    """Slots in another order get the same answers in that order, to the last bit."""
    part = _implicit(enforcement)
    conditions, _ = some_conditions()
    order = np.random.default_rng(3).permutation(COUNT)
    mixed = replace(conditions, **{f.name: getattr(conditions, f.name)[..., order].copy() for f in fields(conditions)})
    one, other = _respond(part, conditions), _respond(part, mixed)
    for f in fields(Response):
        identical(getattr(other, f.name), getattr(one, f.name)[..., order], f"{f.name} in another order")


def conditions_are_untouched(enforcement: Enforcement) -> None:
    """Conditions are only read, and the response does not depend on earlier calls."""
    part = _implicit(enforcement)
    conditions, _ = some_conditions()
    with untouched(**{f.name: getattr(conditions, f.name) for f in fields(conditions)}):
        first = _respond(part, conditions)
    _respond(part, some_conditions(seed=5)[0])
    second = _respond(part, conditions)
    for f in fields(Response):
        identical(getattr(second, f.name), getattr(first, f.name), f"{f.name} after another call")


CHECKS: tuple[Check, ...] = (
    response_is_filled,
    response_is_linearised,
    closed_gaps_bear_forces,
    exactness_is_declared,
    friction_keeps_its_bound,
    what_rests_keeps_its_friction,
    numbers_change_the_response,
    units_do_not_matter_to_it,
    few_iterations,
    slots_know_nothing_of_each_other,
    conditions_are_untouched,
)
