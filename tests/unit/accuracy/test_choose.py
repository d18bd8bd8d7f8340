"""The choice of a configuration: costs beyond a line, levels between two, and a search that is run."""

from __future__ import annotations

import math
import zlib
from collections.abc import Generator
from pathlib import Path
from typing import Any

import pytest

from contactlab.accuracy import choose as choosing
from contactlab.accuracy.choose import _level_between, expected_cost, first_meeting
from contactlab.accuracy.lines import Line
from contactlab.accuracy.point import Point
from contactlab.accuracy.run import LineTasks
from contactlab.cli import main
from contactlab.jobs.run import here
from contactlab.parts.registry import default_registry
from contactlab.scene.scene import load_scene
from contactlab.studies.find_reference import matching_reference


def line(*points: tuple[int, float, float], stopped: int = 0) -> Line:
    made = [Point("a", "x", "declared", n, "finished", error=e, cpu=(c,)) for n, e, c in points]
    made += [Point("a", "x", "declared", stopped, "over-limit", "too long")] if stopped else []
    return Line("a", "x", "declared", made, 0.0, 1.1)


def test_costs_go_on_as_the_last_two_points_do() -> None:
    # first order, costs as the cube of the level: half of the error costs eight times as much
    assert expected_cost(line((1, 0.08, 1.0), (2, 0.04, 8.0)), 0.02) == pytest.approx(64.0)
    assert expected_cost(line((1, 0.08, 1.0), (2, 0.04, 8.0)), 0.08) == 1.0
    assert math.isinf(expected_cost(line((1, 0.08, 1.0)), 0.02))
    assert math.isinf(expected_cost(line((1, 0.08, 1.0), (2, 0.04, 8.0), stopped=4), 0.02))


def test_a_level_between_serves_where_the_line_says_so() -> None:
    # error = 0.08 / level, so that 0.015 needs level 5.3
    assert _level_between(line((4, 0.02, 1.0), (8, 0.01, 8.0)), 0.015) == 6
    assert _level_between(line((1, 0.08, 1.0), (2, 0.04, 8.0)), 0.05) == 0  # nothing lies between


def test_the_coarsest_point_counts_from_which_on_the_error_is_met() -> None:
    points = line((1, 0.08, 1.0), (2, 0.004, 2.0), (4, 0.02, 8.0), (8, 0.005, 64.0))
    found = first_meeting(points, 0.01, 100.0)
    assert found is not None
    assert found.level == 8  # level 2 was luck
    assert first_meeting(points, 0.01, 10.0) is None


@pytest.mark.parametrize("wish", [0.05, 0.02, 0.008])
def test_the_choice_is_near_the_best_of_all(wish: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Against an exhaustive search in a world of known errors C h^q and costs c n^p, which the trials are asked of."""
    scene, registry = load_scene("disc-on-block"), default_registry()
    constants = (0.16, 1.0, 0.1, 2.0), (0.08, 0.9, 0.4, 2.2), (0.3, 1.9, 0.2, 2.5), (0.05, 0.5, 0.3, 2.0)

    def world(name: str, slave: str) -> tuple[float, float, float, float]:
        return constants[zlib.crc32(f"{name} {slave}".encode()) % len(constants)]

    def error_and_cost(name: str, slave: str, level: int) -> tuple[float, float]:
        c, q, unit, p = world(name, slave)
        return c * level**-q, unit * level**p

    names: set[tuple[str, str]] = set()
    tried: dict[tuple[str, str], list[int]] = {}

    def line_plan(line: LineTasks, *rest: Any) -> Generator[list[Any], Any, list[Point]]:
        points = []
        for task in line.tasks:
            name = task.contender.label, task.slave
            names.add(name)
            tried.setdefault(name, []).append(task.level)
            error, cost = error_and_cost(*name, task.level)
            points.append(Point("disc-on-block", *name, task.level, "finished", "", error, (cost,), 0.01))
        yield []
        return points

    monkeypatch.setattr(choosing, "line_plan", line_plan)
    asked = choosing.choose_plan(scene, choosing.Wish(wish, 60.0, 120.0), registry, tmp_path, lambda point: None)
    found = here(asked, lambda run: pytest.fail("a run was made"))
    known = matching_reference(scene.data, registry)
    assert known is not None
    target = wish - known.pressure_uncertainty
    every = [error_and_cost(*name, level) for name in names for level in range(1, 17)]
    best = min(cost for error, cost in every if error <= target)
    assert found.error <= target
    assert found.cost[0] <= 2.0 * best
    assert scene.with_(found.settings).level == found.level
    # what meets the error goes to no finer level
    for name, levels in tried.items():
        meets = [level for level in sorted(set(levels)) if error_and_cost(*name, level)[0] <= target]
        assert len(meets) <= 1 or max(meets) <= 2 or _between_was_tried(levels, meets)


def _between_was_tried(levels: list[int], meets: list[int]) -> bool:
    """Whether the finer of the levels that meet the error was run before the coarser ones."""
    return levels.index(max(meets)) < min(levels.index(level) for level in meets[:-1])


@pytest.mark.parametrize(("option", "value"), [("--error", "200%"), ("--error", "no"), ("--budget", "0s")])
def test_wrong_wishes_are_told(option: str, value: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["choose", "disc-on-block", option, value]) == 2
    said = capsys.readouterr().err
    assert f'choose, {option}: this value is not allowed\n  got      "{value}"' in said
