"""A study of cases: a plan per line of convergence, coarse or cheap points of all lines first."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import zip_longest
from typing import Any

from contactlab.accuracy.point import SLAVES, Point, Task, named, point_plan
from contactlab.accuracy.problem import Problem, choices, contenders, problem_of
from contactlab.accuracy.study import CaseChoice, CaseStudy, Contender
from contactlab.errors import RequestError
from contactlab.jobs.driver import Driver
from contactlab.parts.registry import Registry

WAITING = "waiting"
OTHERS = {WAITING: "not run yet", "interrupted": "stopped before it was run"}
"""Statuses of points that are not run, in words."""
GROWTH = 3.0
"""Power of the level that costs grow with, while a line has one point only."""


@dataclass(frozen=True)
class Asked:
    """A case of the study with what its answer is worth.

    uncertainty  of the reference, as a fraction
    order        that theory gives the error, nan if the case does not say
    targets      errors asked for, as fractions; empty for the targets of the study
    """

    label: str
    title: str
    measure: str
    reference: str
    uncertainty: float
    order: float
    why: str
    targets: Sequence[float] = ()


@dataclass(frozen=True)
class Accuracy:
    """All points of a study, in the order of the plan.

    side_by_side  runs at a time: more than one disturb each other
    """

    study: CaseStudy
    asked: Sequence[Asked]
    contenders: Sequence[str]
    points: Sequence[Point]
    side_by_side: int
    interrupted: bool = False

    @property
    def targets(self) -> list[float]:
        """All errors that are asked for, the largest first."""
        return sorted({target for asked in self.asked for target in self.targets_of(asked)}, reverse=True)

    def targets_of(self, asked: Asked) -> Sequence[float]:
        """Errors that are asked for in a case."""
        return asked.targets or self.study.targets


@dataclass(frozen=True)
class LineTasks:
    """The points of a line of convergence, by level.

    rank      place among lines that are run one after another
    by_costs  whether the expected cost of the next level is its place among all others
    """

    tasks: Sequence[Task]
    problem: Problem
    rank: int = 0
    by_costs: bool = False

    def place(self, task: Task, expected: float) -> tuple[float, float]:
        """Runs begin in this order: by rank, then by level, or by what they should cost."""
        return float(self.rank), expected if self.by_costs else float(task.level)


class Budget:
    """CPU time that a study may spend, and has spent [s]."""

    def __init__(self, budget: float | None) -> None:
        self.budget, self.spent = budget, 0.0

    def refusal(self, expected: float) -> str:
        """Why a point that is expected to take so long does not begin; empty if it may."""
        if self.budget is not None and self.spent + expected > self.budget:
            return f"the {self.budget:g} CPU s of the study are used up"
        return ""


Told = Callable[[Point], None]
"""Called with each point."""


def line_plan(
    line: LineTasks, registry: Registry, budget: Budget, told: Told
) -> Generator[Sequence[Any], Sequence[Any], list[Point]]:
    """The points of a line, level by level; a level that would take longer than its limit is not run."""
    done: list[Point] = []
    for task in line.tasks:
        expected = expected_cost(done, task.level)
        if done and done[-1].status == "interrupted":
            point = named(task, "interrupted", OTHERS["interrupted"])
        elif math.isinf(expected):
            took = "took" if any(point.status == "timed-out" for point in done) else "would take"
            point = named(task, "over-limit", f"a coarser level {took} more than {task.limit:g} CPU s")
        elif expected > task.limit:
            point = named(task, "over-limit", f"would take about {expected:.2g} CPU s, the limit is {task.limit:g}")
        else:
            unless = partial(budget.refusal, expected * (task.repeat if expected < task.short else 1))
            point = yield from point_plan(task, line.problem, registry, line.place(task, expected), unless)
        budget.spent += point.spent
        done.append(point)
        told(point)
    return done


def run_accuracy(
    study: CaseStudy, registry: Registry, driver: Driver,
    so_far: Callable[[Callable[[], Accuracy]], None] = lambda found: None,
) -> Accuracy:  # fmt: skip
    """Every point of a study. Raises RequestError for a wrong request.

    so_far  is called after each point with what gives the study as it stands; points to come have status "waiting"
    """
    asked, lines = plan(study, registry)
    points: list[Point] = []
    others = partial(_with_others, study, registry, asked, lines, points, driver.size)

    def told(point: Point) -> None:
        points.append(point)
        driver.progress.told(point_text(point))
        so_far(partial(others, WAITING))

    budget = Budget(study.budget)
    for _ in driver.results(line_plan(line, registry, budget, told) for line in lines):
        pass
    return replace(others("interrupted"), interrupted=driver.interrupted)


def point_text(point: Point) -> str:
    """A point in one line."""
    head = f"{point.case}, {point.contender}, {point.slave}, level {point.level}: "
    if point.finished:
        return f"{head}{100.0 * point.error:.3g} % in {point.cost:.3g} s"
    return f"{head}{point.status}: {point.reason.splitlines()[0] if point.reason else ''}"


def _with_others(
    study: CaseStudy, registry: Registry, asked: Sequence[Asked], lines: Sequence[LineTasks], done: Sequence[Point],
    jobs: int, status: str,
) -> Accuracy:  # fmt: skip
    """All points in order: those that are done, and all others with this status."""
    labels = list(dict.fromkeys(contender.label for contender in contenders(study, registry)))
    cases = [each.label for each in asked]
    seen = {(p.case, p.contender, p.slave, p.level) for p in done}
    others = [
        named(t, status, OTHERS[status])
        for line in lines
        for t in line.tasks
        if (t.choice.label, t.contender.label, t.slave, t.level) not in seen
    ]
    points = sorted([*done, *others], key=lambda p: (cases.index(p.case), labels.index(p.contender), p.slave, p.level))
    return Accuracy(study, asked, labels, points, jobs)


def plan(study: CaseStudy, registry: Registry) -> tuple[list[Asked], list[LineTasks]]:
    """The cases and the lines of convergence of what can be put to them. Raises RequestError."""
    folder = study.path.parent if study.path else None
    asked, groups = [], []
    for choice in choices(study, registry):
        problem = problem_of(choice, registry, folder)
        fitting = [
            (contender, swap)
            for contender in contenders(study, registry)
            for swap in (False, True)
            if SLAVES[swap] in (contender.slaves or SLAVES) and not problem.refusal(contender, swap, registry)
        ]
        if not fitting:
            continue
        asked.append(_asked(problem, fitting[0][0]))
        asking = partial(Task, choice, limit=study.limit, repeat=study.repeat, short=study.short)
        groups.append(
            [
                LineTasks(
                    [asking(contender=contender, swap=swap, level=level) for level in sorted(levels)],
                    problem,
                    _rank(study, contender),
                    study.order == "costs",
                )
                for contender, swap in fitting
                if (levels := contender.levels or choice.levels or study.levels)
            ]
        )
    if not groups:
        raise RequestError("no contender can be put to any of the cases", where=str(study.path or study.name))
    # a line of each case in turn: what a budget leaves is spread over the cases
    return asked, [line for turn in zip_longest(*groups) for line in turn if line is not None]


def points_of(lines: Sequence[LineTasks]) -> int:
    """Return the number of points."""
    return sum(len(line.tasks) for line in lines)


def _rank(study: CaseStudy, contender: Contender) -> int:
    """Place of the entry that a contender comes from, if entries are run one after another."""
    if study.order != "contenders":
        return 0
    return next(n for n, one in enumerate(study.contenders) if one == replace(contender, algorithm=one.algorithm))


def _asked(problem: Problem, contender: Contender) -> Asked:
    setup = problem.setup(contender, False, 1)
    measure = problem.measure(setup)
    choice: CaseChoice = problem.choice
    return Asked(
        choice.label, problem.case.title, measure.name, problem.reference(setup), problem.uncertainty(setup),
        math.nan if measure.order is None else measure.order, choice.why, choice.targets,
    )  # fmt: skip


def expected_cost(done: Sequence[Point], level: int) -> float:
    """CPU time [s] to expect of a level, from the last two that were run; 0 if none was, inf above a limit."""
    if any(point.status in ("timed-out", "over-limit") for point in done):
        return math.inf
    timed = [point for point in done if point.cost > 0.0]
    if not timed:
        return 0.0
    last = timed[-1]
    power = GROWTH
    if len(timed) > 1:
        before = timed[-2]
        power = math.log(last.cost / before.cost) / math.log(last.level / before.level)
    return float(last.cost * (level / last.level) ** min(max(power, 1.0), 4.0))
