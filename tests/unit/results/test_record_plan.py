"""Which steps the contact record takes, and which iterations have their states stored."""

from __future__ import annotations

import math

import pytest

from contactlab.results.record_plan import IteratePlan, Window


def taken(plan: Window | IteratePlan, last: int) -> list[int]:
    found, number = [], 0.0
    while (number := plan.following(int(number))) <= last:
        found.append(int(number))
    return found


@pytest.mark.parametrize(("first", "last", "every"), [(1, math.inf, 1), (5, 60, 3), (10, 10, 1)])
def test_all_steps_of_the_window(first: int, last: float, every: int) -> None:
    assert taken(Window(first, last, every), 100) == [s for s in range(first, 101, every) if s <= last]


def test_never_more_iterations_than_the_budget_however_long_the_run() -> None:
    plan = IteratePlan(400)
    found = taken(plan, 5_000)
    assert found[: plan.sure] == list(range(1, plan.sure + 1))
    assert found[-1] > 2_000
    # stretches have half as many rows each: their sum stays below a third of the first one
    assert len(found) <= plan.rows


def test_what_follows_depends_on_the_number_alone() -> None:
    plan = IteratePlan(80)
    found = taken(plan, 1500)
    for number in range(1000):
        assert plan.following(number) == next(s for s in found if s > number)
