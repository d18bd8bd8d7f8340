"""Checks of enforcements for explicit integrators; `enforcement_implicit` has the others."""

from __future__ import annotations

import numpy as np

from contactlab.api import Enforcement, Floats, Rows
from contactlab.testing import enforcement_implicit
from contactlab.testing.assertions import Check, agree, require, untouched
from contactlab.testing.gap_rows import coupled_normals, direct_forces, operator, rows_from, solved, turned

COUNT = 50


def _problem(seed: int = 1) -> tuple[Rows, Floats, Floats, Floats]:
    """Rows of both signs of gap, nodal compliance, the operator and the gaps."""
    normal = coupled_normals(COUNT, seed)
    rng = np.random.default_rng(seed + 100)
    compliance = rng.uniform(0.5, 1.5, (COUNT + 3, 2))
    gap = rng.uniform(-1.0, 1.0, COUNT)
    return rows_from(normal, gap), compliance, operator(normal, compliance), gap


def is_the_direct_solution(enforcement: Enforcement) -> None:
    """Forces of 50 coupled frictionless rows are those of a direct active-set solution."""
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
    require(left.min() >= -1e-9, f"a gap of {left.min():.1e} is left")
    agree(y * left, np.zeros(COUNT), 1e-9 * y.max(), "force times gap")


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
    multipliers = np.random.default_rng(4).uniform(0.0, 3.0, (1, COUNT))
    solved(enforcement, rows, compliance, multipliers)
    expected = direct_forces(matrix, gap)
    agree(multipliers[0], expected, 1e-9 * expected.max(), "forces after a wrong start")


def slots_are_kept_apart(enforcement: Enforcement) -> None:
    """A row's force is stored in its own slot, and slots without a row are cleared."""
    normal = np.zeros((2, 2, 2))
    normal[0, 0], normal[1, 1] = (0.0, 1.0), (1.0, 0.0)
    multipliers = np.full((1, 6), 5.0)
    solved(enforcement, rows_from(normal, [-2.0, 1.0], slots=[4, 1]), np.ones((2, 2)), multipliers)
    agree(multipliers[0], [0.0, 0.0, 0.0, 0.0, 2.0, 0.0], 1e-9, "multipliers of two rows in slots 4 and 1")


def nothing_to_do(enforcement: Enforcement) -> None:
    """Without rows, and with open rows only, there are no forces."""
    for rows in (rows_from(np.zeros((0, 2, 2)), np.zeros(0)), rows_from(np.ones((1, 2, 2)), [0.3])):
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
    require(done.rigid_rows == 1, f"{done.rigid_rows} rows are reported as rigid, expected 1")
    agree(multipliers[0], [0.0, 0.5], 1e-9, "forces of a rigid and a movable row")
    require(np.all(np.isfinite(force)), "force: not finite where motion is prescribed")


def correction_is_reported(enforcement: Enforcement) -> None:
    """The largest correction of a node is compliance times force."""
    normal = np.zeros((1, 2, 2))
    normal[0, 1] = 0.0, 1.0
    done, _ = solved(enforcement, rows_from(normal, [-1.5]), np.full((2, 2), 2.0), np.zeros((1, 1)))
    agree(done.largest_correction, 1.5, 1e-9, "largest correction")


def friction_keeps_its_bound(enforcement: Enforcement) -> None:
    """Sticking rows do not slip, sliding ones carry their bound against the slip, and none exceeds it."""
    normal = coupled_normals(COUNT, 5)
    tangent = turned(normal)
    rng = np.random.default_rng(5)
    compliance = np.repeat(rng.uniform(0.5, 1.5, (COUNT + 3, 1)), 2, axis=1)
    gap, slip = rng.uniform(-1.0, 0.5, COUNT), rng.uniform(-0.3, 0.3, COUNT)
    multipliers = np.zeros((2, COUNT))
    rows = rows_from(normal, gap, tangent=tangent, slip=slip, coefficient=0.3)
    _, force = solved(enforcement, rows, compliance, multipliers)
    y, rub = multipliers
    limit = 0.3 * y
    require(np.all(np.abs(rub) <= limit * (1.0 + 1e-12)), "a tangential force exceeds its bound")
    moved = slip + (tangent * (compliance * force)).sum(axis=(1, 2))
    stick = np.abs(rub) < limit * (1.0 - 1e-9)
    require(bool(stick.any()) and bool((~stick & (y > 0.0)).any()), "the problem should have rows of both states")
    agree(moved[stick], np.zeros(stick.sum()), 1e-9, "slip of sticking rows")
    require(np.all((rub * moved)[~stick] <= 1e-9), "a sliding row is pushed along its slip")


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
    inputs_untouched,
    *enforcement_implicit.CHECKS,
)
