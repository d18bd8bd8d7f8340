"""Cost and error of the finest mesh, predicted from points whose law is known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from contactlab.accuracy.cost_model import CostModel
from contactlab.accuracy.error_model import UNKNOWN, ErrorModel
from contactlab.accuracy.lines import Line
from contactlab.accuracy.point import Point
from contactlab.accuracy.predictions import Prediction, predictions_of
from contactlab.reports.accuracy_page import predictions_section, told

LEVELS = (1, 2, 3, 4, 6, 8)


def point(level: int, error: float, cost: float, counts: dict[str, float] | None = None) -> Point:
    return Point("a", "x", "declared", level, "finished", error=error, cpu=(cost,), counts=counts or {})


def line(points: list[Point], uncertainty: float = 0.0, case: str = "a", contender: str = "x") -> Line:
    return Line(case, contender, "declared", points, uncertainty, 1.1)


def predicted_cost(points: list[Point], level: int) -> float:
    one = line(points)
    return CostModel.below(level, [one]).cost(one, level)


def explicit_cost(level: int) -> float:
    return 0.05 + 2e-6 * 1000 * level * level**2  # start + unit cost x steps x cells


def test_a_law_that_holds_is_predicted_to_the_last_digit() -> None:
    points = [point(n, 0.1 / n**2, explicit_cost(n), {"steps": 1000.0 * n}) for n in LEVELS]
    (one,) = predictions_of([line(points)])
    assert one.levels == (2, 3, 4, 6)
    assert one.level == 8
    assert one.predicted_cost == pytest.approx(explicit_cost(8), rel=1e-9)
    assert one.predicted_error == pytest.approx(0.1 / 64, rel=1e-9)
    assert one.is_within
    assert not one.is_off


def test_factors_of_an_implicit_run_grow_faster_than_its_cells() -> None:
    def cost(level: int) -> float:
        return 0.02 + 5.0 * 1e-3 * level**2 + 1e-3 * level**3

    points = [point(n, 0.1, cost(n), {"steps": 1.0, "iterations": 5.0}) for n in (2, 3, 4, 6)]
    assert predicted_cost(points, 8) == pytest.approx(cost(8), rel=1e-9)


def test_nodes_count_where_the_level_does_not_tell_them() -> None:
    """A graded mesh has fewer nodes than the square of its level says, and factors are made once a load step."""

    def of(level: int, iterations: float) -> Point:
        nodes = 400.0 * level**1.4
        cost = 0.02 + iterations * 2e-5 * nodes + 3e-7 * nodes**1.5
        return point(level, 0.1, cost, {"steps": 1.0, "iterations": iterations, "nodes": nodes})

    points = [of(level, iterations) for level, iterations in ((2, 5.0), (3, 9.0), (4, 4.0), (6, 6.0))]
    assert predicted_cost(points, 8) == pytest.approx(of(8, math.sqrt(24.0)).cost, rel=1e-9)


def test_the_first_level_tells_nothing() -> None:
    """What fixed costs weigh there is no law of finer meshes."""
    points = [point(n, 0.1, explicit_cost(n), {"steps": 1000.0 * n}) for n in (2, 3, 4)]
    slow = point(1, 0.1, 50.0, {"steps": 1000.0})
    assert predicted_cost([slow, *points], 8) == predicted_cost(points, 8)


def test_unit_costs_are_never_negative() -> None:
    """Costs that fall would be predicted as less than nothing by a free fit."""
    points = [point(n, 0.1, 1.0 / n, {"steps": 10.0}) for n in (2, 3, 4)]
    assert predicted_cost(points, 8) > 0.0


def test_two_points_that_scatter_take_their_unit_costs_from_lines_of_the_same_work() -> None:
    """A line whose level 3 was slow by a half would be predicted 80 % too dear by itself."""
    counts = {"steps": 1.0, "iterations": 5.0}

    def cost(level: int) -> float:
        return 0.02 + 5.0 * (1e-3 * level**2 + 2e-4 * level**3)

    true = [point(n, 0.1, cost(n), counts) for n in (1, 2, 3)]
    slow = line([*true[:2], point(3, 0.1, 1.5 * cost(3), counts)])
    alone, among = ([slow], [slow, *(line(true) for _ in range(6))])
    assert CostModel.below(4, alone).cost(slow, 4) > 1.5 * cost(4)
    assert CostModel.below(4, among).cost(slow, 4) == pytest.approx(1.5 ** (1 / 3) * cost(4), rel=0.1)


def test_lines_of_other_cases_and_explicit_ones_have_unit_costs_of_their_own() -> None:
    counts = {"iterations": 4.0}
    cheap = line([point(n, 0.1, 0.1 + 0.01 * n**2, counts) for n in (2, 3)])
    others = [
        line([point(n, 0.1, 7.0 * n**3, counts) for n in (2, 3)], case="b"),
        line([point(n, 0.1, 7.0 * n**3, {"steps": 4.0}) for n in (2, 3)], contender="y"),
    ]
    alone = CostModel.below(4, [cheap]).cost(cheap, 4)
    assert CostModel.below(4, [cheap, *others]).cost(cheap, 4) == pytest.approx(alone, rel=1e-9)


def test_a_line_of_two_points_goes_on_with_the_order_of_its_case() -> None:
    """Between levels 2 and 3 the error of one line grows by chance; all others of the case are of order 2."""
    others = [line([point(n, 0.1 / n**2, 1.0) for n in (2, 3)]) for _ in range(8)]
    odd = line([point(2, 0.02, 1.0), point(3, 0.022, 1.0)])
    told = ErrorModel.below(4, [*others, odd]).error(odd, 4)
    assert told is not None
    # its own order, -0.24, has 0.082 / (0.082 + 0.3) of the weight
    own, share = math.log(0.02 / 0.022) / math.log(1.5), 0.5 * math.log(1.5) ** 2 / (0.5 * math.log(1.5) ** 2 + 0.3)
    assert told[0] == pytest.approx(0.022 * (4 / 3) ** -(share * own + (1.0 - share) * 2.0), rel=1e-9)


def test_a_case_that_scatters_has_wider_intervals() -> None:
    chance = np.random.default_rng(3)
    smooth = [line([point(n, 0.1 / n, 1.0) for n in (2, 3, 4)], case=name) for name in ("smooth", "b", "c") * 20]
    rough = [
        line([point(n, 0.1 / n * math.exp(0.5 * chance.standard_normal()), 1.0) for n in (2, 3, 4)], case="rough")
        for _ in range(20)
    ]
    model = ErrorModel.below(6, [*smooth, *rough])
    assert model.missed("rough") > 1.2 * model.missed("smooth") > 0.0
    assert ErrorModel.below(6, smooth[:1]).missed("smooth") == UNKNOWN  # two steps tell nothing


def test_intervals_hold_nine_of_ten() -> None:
    """500 lines of order 2 whose errors scatter by 10 %: 90 % within 3.5 standard deviations of that share."""
    chance = np.random.default_rng(7)
    lines = [
        line([point(n, 0.1 / n**2 * math.exp(0.1 * chance.standard_normal()), 1.0) for n in LEVELS]) for _ in range(500)
    ]
    found = predictions_of(lines)
    share = sum(one.is_within for one in found) / len(found)
    assert share == pytest.approx(0.9, abs=3.5 * math.sqrt(0.9 * 0.1 / 500))
    assert sum(one.is_wide for one in found) < 0.02 * len(found)  # chance makes a line scatter twice as much


def test_a_line_that_stops_falling_is_a_misprediction_and_is_listed() -> None:
    good = [point(n, 0.1 / n**2, explicit_cost(n), {"steps": 1000.0 * n}) for n in LEVELS]
    bad = [*good[:-1], point(8, 0.0028, 4.0 * explicit_cost(8))]
    found = predictions_of([line(good), line(good), line(bad)])
    assert [one.is_off for one in found] == [False, False, True]
    assert found[2].cost_off == pytest.approx(-0.75)
    assert told(found).startswith("2 of 3 costs within 40%; 2 of 3 errors in their interval, of which 0")
    assert "1 mispredictions" in predictions_section(found)


def test_an_error_that_the_reference_cannot_tell_is_not_predicted() -> None:
    points = [point(n, max(0.1 / n**2, 2e-3), 1.0) for n in LEVELS]
    (one,) = predictions_of([line(points, uncertainty=1e-3)])
    assert not one.tells_error
    assert not one.is_off


@pytest.mark.parametrize("levels", [(1, 2, 4), (8,), ()])
def test_two_points_of_level_2_or_more_are_needed_before(levels: tuple[int, ...]) -> None:
    assert predictions_of([line([point(n, 0.1 / n, 1.0) for n in levels])]) == []


def test_nothing_is_said_where_nothing_was_predicted() -> None:
    nothing: list[Prediction] = []
    assert told(nothing) == predictions_section(nothing) == ""
