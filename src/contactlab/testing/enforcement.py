"""Checks of enforcements for explicit integrators; `enforcement_implicit` has the others."""

from __future__ import annotations

import numpy as np

from contactlab.api import Enforcement, ExplicitEnforcement, Floats, Rows
from contactlab.testing import enforcement_implicit, normal_law, scales
from contactlab.testing.assertions import Check, NotApplicable, agree, require, untouched
from contactlab.testing.gap_rows import coupled_normals, direct_forces, operator, rows_from, solved, turned
from contactlab.testing.scales import scale_of
from contactlab.testing.units import FORCE, LONG, in_other_units, same_in_other_units

COUNT = 50
FAR = 1000.0  # lengths of a pressure curve at which nothing is left of it


def _problem(seed: int = 1) -> tuple[Rows, Floats, Floats, Floats]:
    """Rows of both signs of gap, nodal compliance, the operator and the gaps."""
    normal = coupled_normals(COUNT, seed)
    rng = np.random.default_rng(seed + 100)
    compliance = rng.uniform(0.5, 1.5, (COUNT + 3, 2))
    gap = rng.uniform(-1.0, 1.0, COUNT)
    return rows_from(normal, gap), compliance, operator(normal, compliance), gap


def _far(enforcement: Enforcement) -> float:
    """A gap [mm] at which the part has no force."""
    if not enforcement.pressure_before_contact:
        return 0.3
    if not enforcement.length_scale:
        raise NotApplicable("pressure_before_contact without a length_scale: the gap where it begins is unknown")
    return FAR * scale_of(enforcement, "length_scale", 1.0)


def _explicit(enforcement: Enforcement) -> None:
    if not isinstance(enforcement, ExplicitEnforcement):
        raise NotApplicable("the enforcement is not for explicit integrators")


def is_the_direct_solution(enforcement: Enforcement) -> None:
    """Forces of 50 coupled frictionless rows match a direct active-set solution."""
    _explicit(enforcement)
    if not enforcement.exact:
        raise NotApplicable("assumes that closed gaps become zero: exact is False")
    for seed in range(3):
        rows, compliance, matrix, gap = _problem(seed)
        multipliers = np.zeros((1, COUNT))
        solved(enforcement, rows, compliance, multipliers)
        expected = direct_forces(matrix, gap)
        agree(multipliers[0], expected, 1e-9 * expected.max(), "forces against the direct solution")


def conditions_hold(enforcement: Enforcement) -> None:
    """No row pulls, none stays closed beyond the tolerance, and open rows have no force."""
    rows, compliance, matrix, gap = _problem(7)
    multipliers = np.zeros((1, COUNT))
    solved(enforcement, rows, compliance, multipliers)
    y = multipliers[0]
    left = gap + matrix @ y
    require(np.all(y >= 0.0), f"a row pulls with {-y.min():.1e} N")
    if enforcement.exact:
        require(left.min() >= -1e-9, f"a gap of {left.min():.1e} mm is left, allowed -1e-9 mm")
        agree(y * left, np.zeros(COUNT), 1e-9 * y.max(), "force times gap")
        return
    require(bool(y.any()), "no row has a force, but many overlap")
    # springs act by the predicted gap, or by the one that is left
    idle = (gap < 0.0) & (left < 0.0) & (y == 0.0)
    require(not idle.any(), f"{int(idle.sum())} rows overlap before and after the solve and have no force")
    if not enforcement.pressure_before_contact:
        open_ = (np.minimum(gap, left) > 0.0) & (y > 0.0)
        require(
            not open_.any(),
            f"{int(open_.sum())} open rows have a force; declare pressure_before_contact if that is meant",
        )


def forces_are_the_rows(enforcement: Enforcement) -> None:
    """Nodal forces are the rows times the multipliers, at every node, for any earlier contents of the array."""
    normal = coupled_normals(COUNT, 3)
    rows, compliance, *_ = _problem(3)
    multipliers = np.zeros((1, COUNT))
    _, force = solved(enforcement, rows, compliance, multipliers)
    agree(force, np.einsum("k,kni->ni", multipliers[0], normal), 1e-12, "nodal forces")


def warm_start_changes_nothing(enforcement: Enforcement) -> None:
    """The solution does not depend on the forces that the solve starts from."""
    rows, compliance, matrix, gap = _problem(4)
    _explicit(enforcement)
    if not enforcement.exact:
        first = np.zeros((1, COUNT))
        solved(enforcement, rows, compliance, first)
    multipliers = np.random.default_rng(4).uniform(0.0, 3.0, (1, COUNT))
    solved(enforcement, rows, compliance, multipliers)
    expected = direct_forces(matrix, gap) if enforcement.exact else first[0]
    agree(multipliers[0], expected, 1e-9 * expected.max(), "forces after a wrong start")


def slots_are_kept_apart(enforcement: Enforcement) -> None:
    """A row's force is stored in its own slot, and slots without a row are cleared."""
    normal = np.zeros((2, 2, 2))
    normal[0, 0], normal[1, 1] = (0.0, 1.0), (1.0, 0.0)
    multipliers = np.full((1, 6), 5.0)
    solved(enforcement, rows_from(normal, [-2.0, _far(enforcement)], slots=[4, 1]), np.ones((2, 2)), multipliers)
    force = 2.0 if enforcement.exact else multipliers[0, 4]
    require(force > 0.0, "an overlap of 2 mm in slot 4 has no force")
    agree(multipliers[0], [0.0, 0.0, 0.0, 0.0, force, 0.0], 1e-9, "multipliers of two rows in slots 4 and 1")


def nothing_to_do(enforcement: Enforcement) -> None:
    """There are no forces without rows, and with open rows only."""
    for rows in (rows_from(np.zeros((0, 2, 2)), np.zeros(0)), rows_from(np.ones((1, 2, 2)), [_far(enforcement)])):
        multipliers = np.zeros((1, 1))
        done, force = solved(enforcement, rows, np.ones((2, 2)), multipliers)
        agree(force, np.zeros((2, 2)), 0.0, "force")
        agree(multipliers, np.zeros((1, 1)), 0.0, "multipliers")
        require(done.residual <= 1e-9, f"residual {done.residual} with nothing to do")


def rigid_rows_are_left_out(enforcement: Enforcement) -> None:
    """A row whose nodes cannot move gets no force and is reported."""
    normal = np.zeros((2, 2, 2))
    normal[0, 0], normal[1, 1] = (0.0, 1.0), (0.0, 1.0)
    compliance = np.array([[1.0, 0.0], [1.0, 2.0]])
    multipliers = np.zeros((1, 2))
    done, force = solved(enforcement, rows_from(normal, [-1.0, -1.0]), compliance, multipliers)
    if enforcement.exact:
        require(done.rigid_rows == 1, f"{done.rigid_rows} rows are reported as rigid, expected 1")
        agree(multipliers[0], [0.0, 0.5], 1e-9, "forces of a rigid and a movable row")
    else:  # springs act between what cannot move as well
        require(done.rigid_rows in (0, 1), f"{done.rigid_rows} rows are reported as rigid, expected 0 or 1")
        require(multipliers[0, 1] > 0.0, "a movable row that overlaps by 1 mm has no force")
    require(np.all(np.isfinite(force)), "force: not finite where motion is prescribed")


def correction_is_reported(enforcement: Enforcement) -> None:
    """The largest correction of a node is compliance times force."""
    normal = np.zeros((1, 2, 2))
    normal[0, 1] = 0.0, 1.0
    multipliers = np.zeros((1, 1))
    done, _ = solved(enforcement, rows_from(normal, [-1.5]), np.full((2, 2), 2.0), multipliers)
    moved = 1.5 if enforcement.exact else 2.0 * float(multipliers[0, 0])
    agree(done.largest_correction, moved, 1e-9 * max(1.0, moved), "largest correction")


def friction_keeps_its_bound(enforcement: Enforcement) -> None:
    """Sticking rows do not slip, sliding ones carry their bound against the slip, and none exceeds it."""
    normal = coupled_normals(COUNT, 5)
    tangent = turned(normal)
    rng = np.random.default_rng(5)
    compliance = np.repeat(rng.uniform(0.5, 1.5, (COUNT + 3, 1)), 2, axis=1)
    gap, slip = rng.uniform(-1.0, 0.5, COUNT), rng.uniform(-0.3, 0.3, COUNT)
    if not enforcement.exact:  # springs have forces of their own size: some of these slips are small for any of them
        slip *= np.logspace(-4.0, 4.0, COUNT)
    multipliers = np.zeros((2, COUNT))
    # Coulomb's law with a coefficient for each row, Tresca's on any surface, and one that is capped by the pressure
    which = np.arange(COUNT) % 3
    measure, adhesion = rng.uniform(0.3, 0.8, COUNT), np.where(which > 0, 0.4, 0.0)
    coefficient = np.where(which > 0, 0.0, rng.uniform(0.1, 0.4, COUNT))
    rows = rows_from(
        normal, gap, tangent=tangent, slip=slip, coefficient=coefficient, adhesion=adhesion,
        cap=np.array([0.0, np.inf, 0.5])[which], measure=measure,
    )  # fmt: skip
    _, force = solved(enforcement, rows, compliance, multipliers)
    y, rub = multipliers
    limit = coefficient * y + np.where(which == 2, np.minimum(adhesion * measure, 0.5 * y), adhesion * measure)
    require(np.all(np.abs(rub) <= limit * (1.0 + 1e-12)), "a tangential force exceeds its bound")
    moved = slip + (tangent * (compliance * force)).sum(axis=(1, 2))
    stick = np.abs(rub) < limit * (1.0 - 1e-9)
    require(bool(stick.any()), "no row sticks, but some of them hardly move: every force is at its bound")
    if not enforcement.time_scale:  # a bound that falls with the rate is reached by none of them
        require(bool((~stick & (y > 0.0)).any()), "no row slips at its bound, but some of them move far")
    if enforcement.exact and not enforcement.time_scale:
        agree(moved[stick], np.zeros(stick.sum()), 1e-9, "slip of sticking rows")
    require(np.all((rub * moved)[~stick] <= 1e-9), "friction of a slipping row acts along its slip")


def units_do_not_matter_to_them(enforcement: Enforcement) -> None:
    """Explicit forces are the same in m, ms and kPa as in mm, s and MPa, by the units of the docstring."""
    _explicit(enforcement)
    other = in_other_units(enforcement)
    rows, compliance, _, gap = _problem(8)
    found, wanted = np.zeros((1, COUNT)), np.zeros((1, COUNT))
    solved(enforcement, rows, compliance, wanted)
    scaled = rows_from(coupled_normals(COUNT, 8), LONG * gap, measure=LONG)
    scaled.size[:] *= LONG
    solved(other, scaled, LONG / FORCE * compliance, found)
    same_in_other_units(found, wanted, FORCE, "forces")


def inputs_untouched(enforcement: Enforcement) -> None:
    """Rows and compliance are only read, except for scratch arrays."""
    rows, compliance, *_ = _problem(6)
    with untouched(
        node=rows.node,
        start=rows.start,
        weights=rows.normal_weight,
        gap=rows.gap,
        size=rows.size,
        slot=rows.slot,
        measure=rows.measure,
        compliance=compliance,
    ):
        solved(enforcement, rows, compliance, np.zeros((1, COUNT)))


CHECKS: tuple[Check, ...] = (
    is_the_direct_solution,
    conditions_hold,
    forces_are_the_rows,
    warm_start_changes_nothing,
    slots_are_kept_apart,
    nothing_to_do,
    rigid_rows_are_left_out,
    correction_is_reported,
    friction_keeps_its_bound,
    units_do_not_matter_to_them,
    inputs_untouched,
    *enforcement_implicit.CHECKS,
    *normal_law.CHECKS,
    *scales.CHECKS,
)
