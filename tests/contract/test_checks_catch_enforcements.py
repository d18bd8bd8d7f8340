"""Every check of enforcements catches a planted defect, and right ones in NumPy pass all of them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from contactlab.api import Enforcement, ExplicitEnforcement, Floats, Rows, Solve
from contactlab.parts.registry import Registry
from contactlab.testing import NotApplicable, enforcement, enforcement_implicit, normal_law, scales
from contactlab.testing.assertions import Check

SPRINGS = Registry(files=[Path(__file__).with_name("implicit_springs.py")])
Exact: Any = SPRINGS.part_class("enforcement", "numpy-active-set")
Slow: Any = SPRINGS.part_class("enforcement", "slow-active-set")
CHECKS = [check for check in enforcement.CHECKS if check not in normal_law.CHECKS]


def dense(rows: Rows, weight: Floats, nodes: int) -> Floats:
    """Weights (k, 2 N)."""
    out = np.zeros((rows.count, nodes, 2))
    for k in range(rows.count):
        for z in range(rows.start[k], rows.start[k + 1]):
            out[k, rows.node[z]] += weight[z]
    return out.reshape(rows.count, 2 * nodes)


@dataclass(frozen=True)
class Sweeps(ExplicitEnforcement):
    """Projected Gauss-Seidel on dense rows, with one named flaw, or none."""

    flaw: str = ""

    def solve(self, rows: Rows, compliance: Floats, multipliers: Floats, force: Floats) -> Solve:
        k = rows.count
        slots = np.arange(k) if self.flaw == "slots ignored" else rows.slot[:k]
        normal, c = dense(rows, rows.normal_weight, len(force)), compliance.reshape(-1)
        rubs = len(rows.tangent_weight) > 0
        tangent = dense(rows, rows.tangent_weight, len(force)) if rubs else np.zeros_like(normal)
        y = multipliers[0, slots].copy()
        if self.flaw == "never below the start":
            least = y.copy()
        t = multipliers[1, slots].copy() if rubs else np.zeros(k)
        if self.flaw == "gap shifted in place":
            rows.gap -= 1e-3
        a, b = (normal**2 * c).sum(axis=1), (tangent**2 * c).sum(axis=1)
        y[a == 0.0] = 0.0
        sweeps, change = 0, np.inf
        while change > 1e-13 and sweeps < (3 if self.flaw == "stops after three sweeps" else 500) and k:
            change, sweeps = 0.0, sweeps + 1
            for i in range(k):
                moved = c * (normal.T @ y + tangent.T @ t)
                if a[i] > 0.0:
                    new = y[i] - (rows.gap[i] + normal[i] @ moved) / a[i]
                    new = new if self.flaw == "pulls" else max(0.0, new)
                    if self.flaw == "never below the start":
                        new = max(new, least[i])
                    change, y[i] = max(change, abs(new - y[i])), new
                if rubs and b[i] > 0.0:
                    moved = c * (normal.T @ y + tangent.T @ t)
                    grip = min(rows.bound[1, i] * rows.measure[i], rows.bound[2, i] * y[i] if y[i] else 0.0)
                    if np.isinf(rows.bound[2, i]):
                        grip = rows.bound[1, i] * rows.measure[i]
                    limit = (grip + rows.bound[0, i] * y[i]) * (1.1 if self.flaw == "rubs too much" else 1.0)
                    new = float(np.clip(t[i] - (rows.slip[i] + tangent[i] @ moved) / b[i], -limit, limit))
                    change, t[i] = max(change, abs(new - t[i])), new
        total = (normal.T @ y + tangent.T @ t).reshape(force.shape)
        if self.flaw == "returns early without rows" and not k:
            return Solve(0, 0.0, 0, 0.0)
        force[:] = force + total if self.flaw == "forces added" else total
        multipliers[:] = 0.0
        multipliers[0, slots] = y
        if rubs:
            multipliers[1, slots] = t
        rigid = 0 if self.flaw == "rigid rows not reported" else int(np.count_nonzero(a == 0.0))
        shift = np.abs(total if self.flaw == "force as correction" else compliance * total)
        return Solve(sweeps, 0.0, rigid, float(shift.max(initial=0.0)))


@pytest.mark.parametrize("check", CHECKS)
@pytest.mark.parametrize("part", [Sweeps(), Exact()])
def test_a_right_enforcement_passes(check: Check, part: Enforcement) -> None:
    try:
        check(part)
    except NotApplicable:
        implicit = check in enforcement_implicit.CHECKS
        unitless = "units" in check.__name__ or "numbers" in check.__name__
        assert check in scales.CHECKS or unitless or implicit == isinstance(part, ExplicitEnforcement)


@dataclass(frozen=True)
class NoField(Sweeps):
    """Names a length that it does not have."""

    length_scale: ClassVar[str] = "reach"


@dataclass(frozen=True)
class InMillimetres(Sweeps):
    """Closes what is a hundredth of a millimetre open.

    early  [-] over a millimetre
    """

    early: float = 0.01

    def solve(self, rows: Rows, compliance: Floats, multipliers: Floats, force: Floats) -> Solve:
        return super().solve(replace(rows, gap=rows.gap - self.early), compliance, multipliers, force)


@dataclass(frozen=True)
class Idle(Exact):
    """Springs with a number that does nothing.

    width  [-]
    """

    exact: ClassVar[bool] = False
    width: float = 0.1


@dataclass(frozen=True)
class Forgetful(Exact):
    """Friction of the slip of this step alone."""

    def respond(self, conditions: Any, out: Any) -> None:
        super().respond(conditions, out)
        if len(out.residual) > 1:
            out.residual[1] = conditions.force[1] + conditions.stiffness * conditions.slip


WRONG: list[tuple[Check, Enforcement]] = [
    (enforcement.units_do_not_matter_to_them, InMillimetres()),
    (enforcement_implicit.what_rests_keeps_its_friction, Forgetful()),
    (enforcement_implicit.numbers_change_the_response, Idle()),
    (enforcement_implicit.units_do_not_matter_to_it, Idle("leaves a thousandth")),
    (enforcement.is_the_direct_solution, Sweeps("stops after three sweeps")),
    (enforcement.conditions_hold, Sweeps("pulls")),
    (enforcement.forces_are_the_rows, Sweeps("forces added")),
    (enforcement.warm_start_changes_nothing, Sweeps("never below the start")),
    (enforcement.slots_are_kept_apart, Sweeps("slots ignored")),
    (enforcement.nothing_to_do, Sweeps("returns early without rows")),
    (enforcement.rigid_rows_are_left_out, Sweeps("rigid rows not reported")),
    (enforcement.correction_is_reported, Sweeps("force as correction")),
    (enforcement.friction_keeps_its_bound, Sweeps("rubs too much")),
    (enforcement.inputs_untouched, Sweeps("gap shifted in place")),
    (enforcement_implicit.response_is_filled, Exact("status forgotten")),
    (enforcement_implicit.response_is_linearised, Exact("derivative of half the gap")),
    (enforcement_implicit.closed_gaps_bear_forces, Exact("pulls")),
    (enforcement_implicit.exactness_is_declared, Exact("leaves a thousandth")),
    (enforcement_implicit.friction_keeps_its_bound, Exact("rubs too much")),
    (enforcement_implicit.few_iterations, Slow()),
    (enforcement_implicit.slots_know_nothing_of_each_other, Exact("neighbours")),
    (enforcement_implicit.conditions_are_untouched, Exact("writes gaps")),
    (scales.scales_are_fields, NoField()),
]


@pytest.mark.parametrize(("check", "part"), WRONG)
def test_wrong_enforcements_are_caught(caught: Any, check: Check, part: Enforcement) -> None:
    caught(check, part)


def test_every_check_has_a_wrong_part() -> None:
    assert {check for check, _ in WRONG} == set(CHECKS)
