"""Which steps the contact record keeps."""

from __future__ import annotations

import math

import pytest

from contactlab.results.record_plan import MEANT, RecordPlan


def kept(plan: RecordPlan, steps: int) -> list[int]:
    found, step = [], 0
    while (step := plan.following(step)) <= steps:
        found.append(int(step))
        if not math.isfinite(step):
            break
    return found


@pytest.mark.parametrize(("first", "last", "every"), [(1, math.inf, 1), (5, 60, 3), (10, 10, 1)])
def test_all_steps_of_the_window_within_the_budget(first: int, last: float, every: int) -> None:
    plan = RecordPlan(first, last, every, every, 400, 300)
    assert kept(plan, 100) == [s for s in range(first, 101) if s <= last and (s - first) % every == 0]


def test_never_more_rows_than_the_budget_however_long_the_run() -> None:
    rows = 400
    plan = RecordPlan(1, math.inf, 1, 2, rows, int(MEANT * rows))
    found = kept(plan, 5_000)
    assert found[: plan.sure] == list(range(1, 2 * plan.sure, 2))
    assert found[-1] > 2_000
    # stretches have half as many rows each: their sum stays below a third of the first one
    assert len(found) <= rows


def test_what_follows_depends_on_the_step_alone() -> None:
    plan = RecordPlan(3, 900, 1, 1, 80, 60)
    found = kept(plan, 1000)
    for step in range(1000):
        assert plan.following(step) == next((s for s in found if s > step), math.inf)
