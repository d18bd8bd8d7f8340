"""Costs of targets, ties, profiles and orders from points that are known."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from contactlab.accuracy.lines import Line, front, scatter_of
from contactlab.accuracy.orders import orders_of, slope
from contactlab.accuracy.point import Point
from contactlab.accuracy.run import Accuracy, Asked, expected_cost
from contactlab.accuracy.solved import BEST, solved
from contactlab.accuracy.study import CaseChoice, CaseStudy, Contender
from contactlab.accuracy.targets import Cost, best_of, costs_of
from contactlab.accuracy.winners import told, winners_of

STUDY = CaseStudy((CaseChoice(use="a"),), (Contender("statics", "q1", "newton", "x"),), targets=(0.1, 0.01, 0.001))


def line(contender: str, errors: list[float], costs: list[float], uncertainty: float = 0.0, off: float = 1.1) -> Line:
    """Points at levels 1, 2, 4 ... whose repetitions take the cost, `off` times less and `off` times more."""
    points = [
        Point("a", contender, "declared", 2**k, "finished", error=e, cpu=(c, c / off, c * off), calibration=0.01)
        for k, (e, c) in enumerate(zip(errors, costs, strict=True))
    ]
    return Line("a", contender, "declared", points, uncertainty, 1.0)


def costs(*lines: Line) -> dict[tuple[str, float], Cost]:
    asked = Asked("a", "", "L2", "exact", lines[0].uncertainty, 2.0, "")
    found = Accuracy(STUDY, [asked], [one.contender for one in lines], [p for one in lines for p in one.points], 1)
    return {(cost.contender, cost.target): cost for cost in costs_of(found, lines)}


def test_a_cost_is_that_of_the_cheapest_run_that_keeps_the_error() -> None:
    one = line("x", [0.04, 0.02, 0.005, 0.004], [1.0, 2.0, 8.0, 7.0])
    assert one.cheapest(0.02) is one.points[1]
    assert one.cheapest(0.01) is one.points[3]  # between the levels nothing was run, and the finest was the cheaper one
    assert one.cheapest(0.1) is one.points[0]
    assert one.cheapest(0.001) is None
    found = costs(one)
    assert (found["x", 0.01].cost, found["x", 0.01].level) == (7.0, 8)
    assert math.isinf(found["x", 0.001].cost)


def test_intervals_are_those_of_repetitions_and_hold_the_cost() -> None:
    one = line("x", [0.02, 0.005], [4.0, 1.0], 0.003, off=1.25)
    assert one.interval(0.1) == (0.8, 1.25)
    assert one.interval(0.019) == (0.8, 1.25)
    assert one.interval(0.006) == (0.8, math.inf)  # the reference may be off by as much as is left
    alone = replace(one, points=[replace(point, cpu=point.cpu[:1]) for point in one.points], scatter=3.0)
    assert alone.interval(0.1) == pytest.approx((1.0 / 3.0, 3.0))  # of points that were run once


def test_an_error_that_crosses_zero_on_its_way_is_no_luck() -> None:
    assert line("x", [0.04, 1e-6, 0.02, 0.005], [1.0, 2.0, 4.0, 8.0]).errors == [0.04, 0.02, 0.02, 0.005]


def test_equal_costs_tie_and_clear_ones_do_not() -> None:
    near = costs(line("x", [0.04, 0.001], [1.0, 8.0]), line("y", [0.04, 0.001], [1.05, 8.2]))
    assert [near[name, 0.01].mark for name in "xy"] == ["tied", "tied"]
    clear = costs(line("x", [0.04, 0.001], [1.0, 8.0]), line("y", [0.04, 0.001], [3.0, 30.0]))
    assert [clear[name, 0.01].mark for name in "xy"] == ["cheapest", ""]


def test_a_winner_names_the_group_and_the_factor_of_the_next() -> None:
    fine_costs = {"x q1 w": 8.0, "y q1 w": 8.4, "z q2 w": 20.0}
    lines = [line(name, [0.05, 0.002], [1.0, cost]) for name, cost in fine_costs.items()]
    found = Accuracy(STUDY, [Asked("a", "", "L2", "exact", 0.0, 2.0, "")], [one.contender for one in lines], [], 1)
    coarse, fine, nobody = winners_of(found, costs_of(found, lines))
    assert (coarse.target, coarse.group, coarse.coarsest, coarse.next) == (0.1, tuple(found.contenders), True, "")
    assert (fine.group, fine.level, fine.cost, fine.next) == (("x q1 w", "y q1 w"), 2, 8.0, "z q2 w")
    assert fine.factor == pytest.approx(2.5)
    assert told(fine)[0] == "2 tie: x, y q1 w"
    assert (nobody.kind, nobody.group) == ("not-reached", ())


def test_a_reference_that_is_known_roughly_makes_ties() -> None:
    # 1 % is kept at 4 s by y, at 1 s by x: with an error known to 0.3 % it may be that y keeps it at 1 s, too
    both = line("x", [0.009], [1.0]), line("y", [0.012, 0.004], [1.1, 4.0])
    assert [costs(*both)[name, 0.01].mark for name in "xy"] == ["cheapest", ""]
    rough = [replace(one, uncertainty=0.003) for one in both]
    assert [costs(*rough)[name, 0.01].mark for name in "xy"] == ["tied", "tied"]


def test_a_case_may_have_targets_of_its_own() -> None:
    one = line("x", [0.04, 0.00001], [1.0, 8.0])
    asked = Asked("a", "", "L2", "exact", 0.0, 2.0, "", (0.0001, 0.02))
    found = Accuracy(STUDY, [asked], ["x"], one.points, 1)
    assert [cost.target for cost in costs_of(found, [one])] == found.targets == [0.02, 0.0001]


def test_targets_below_three_times_the_uncertainty_are_grey() -> None:
    found = costs(line("x", [0.04, 0.0001], [1.0, 8.0], uncertainty=0.001))
    assert found["x", 0.01].kind == "reached"
    assert found["x", 0.001].kind == "grey"


def test_what_failed_never_looks_cheap() -> None:
    bad = Line("a", "y", "declared", [Point("a", "y", "declared", 1, "diverged", "blew up", cpu=(0.001,))], 0.0, 1.1)
    found = costs(line("x", [0.04, 0.001], [1.0, 8.0]), bad)
    assert found["y", 0.01].kind == "failed"
    assert math.isinf(found["y", 0.01].cost)
    assert found["x", 0.01].mark == "cheapest"
    assert front([bad]) == []


def test_what_stopped_it_is_told() -> None:
    stopped = line("x", [0.04], [1.0])
    later = Point("a", "x", "declared", 2, "over-limit", "would take about 40 CPU s")
    found = costs(Line("a", "x", "declared", [*stopped.points, later], 0.0, 1.1))
    assert found["x", 0.1].kind == "reached"
    assert found["x", 0.01].kind == "over-limit"
    assert "40 CPU s" in found["x", 0.01].why
    assert costs(stopped)["x", 0.01].kind == "not-reached"


def test_shares_count_failures_for_ever_and_the_virtual_best_is_the_cheapest() -> None:
    both = costs(line("x", [0.04, 0.005], [1.0, 8.0]), line("y", [0.02, 0.0005], [2.0, 50.0]))
    profiles = {one.contender: one for one in solved(list(both.values()))}
    assert profiles["x"].share(1e9) == pytest.approx(2.0 / 3.0)
    assert profiles["y"].share(1e9) == profiles[BEST].share(1e9) == 1.0
    assert profiles[BEST].share(1.0) == pytest.approx(1.0 / 3.0)


def test_the_better_slave_stands_for_a_contender() -> None:
    one = Cost("a", "x", "declared", 0.01, "reached", 3.0)
    other = Cost("a", "x", "exchanged", 0.01, "reached", 2.0)
    assert best_of([one, other, Cost("a", "x", "declared", 0.001, "failed")])["a", "x", 0.01] is other


def test_orders_are_slopes_with_the_interval_of_a_normal_regression() -> None:
    exact = line("x", [0.04, 0.01, 0.0025, 0.000625], [1.0, 2.0, 4.0, 8.0])
    asked = Asked("a", "", "L2", "exact", 0.0, 2.0, "")
    (order,) = orders_of(Accuracy(STUDY, [asked], ["x"], exact.points, 1), [exact])
    assert order.order == pytest.approx(2.0, abs=1e-12)
    assert order.levels == (2, 4, 8)
    # Anscombe's first set: slope 0.5001, standard error 0.1179, t(9) = 2.262
    x = np.array([10, 8, 13, 9, 11, 14, 6, 4, 12, 7, 5], float)
    y = np.array([8.04, 6.95, 7.58, 8.81, 8.33, 9.96, 7.24, 4.26, 10.84, 4.82, 5.68])
    assert slope(x, y) == pytest.approx((0.5001, 2.262 * 0.1179), rel=1e-3)  # the digits that were published


def test_the_scatter_of_single_runs_is_that_of_repeated_ones_else_of_the_calibration() -> None:
    times = np.geomspace(1.0, 4.0, 101)
    points = [Point("a", "x", "declared", 1, "finished", calibration=float(t)) for t in times]
    # eight tenths of two octaves, half of it either way
    assert scatter_of(points) == pytest.approx(4.0**0.4, rel=1e-2)
    points += line("x", [0.1, 0.1], [1.0, 4.0], off=1.3).points
    assert scatter_of(points) == pytest.approx(1.3)
    assert math.isinf(scatter_of([]))


def test_costs_of_the_next_level_are_expected_from_the_last_two() -> None:
    done = line("x", [0.1, 0.1], [1.0, 4.0]).points
    assert expected_cost(done, 4) == pytest.approx(16.0)
    assert expected_cost(done[:1], 2) == pytest.approx(8.0)  # as the cube, before two are known
    assert math.isinf(expected_cost([*done, Point("a", "x", "declared", 4, "timed-out")], 8))
