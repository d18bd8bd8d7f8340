"""Running a study of cases: coarse or cheap points of all lines first, each kept in the archive as it is done."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import zip_longest
from pathlib import Path

from contactlab.accuracy.point import SLAVES, Point, Task, named, remembered, run_point, timed_out
from contactlab.accuracy.problem import Problem, choices, contenders, problem_of
from contactlab.accuracy.study import CaseChoice, CaseStudy, Contender
from contactlab.archive.archive import FILE, Archive, StoredRun
from contactlab.errors import RequestError
from contactlab.parts.registry import Registry
from contactlab.studies.call import Call, Pool
from contactlab.studies.cpu_limit import SLOW
from contactlab.studies.pool import ProcessDiedError, RaisedError, TimedOutError
from contactlab.studies.scheduler import LOCAL, open_pool
from contactlab.studies.system import machine

Told = Callable[[Point, int, int], None]
"""Called after each point with how many are done of how many."""

SoFar = Callable[[Callable[[], "Accuracy"]], None]
"""Called after each point with what gives the study as it stands."""

WAITING = "waiting"
OTHERS = {WAITING: "not run yet", "interrupted": "stopped before it was run"}
"""Statuses of points that are not run, in words."""
GROWTH = 3.0
"""Power of the level that costs grow with, while a line has one point only."""


@dataclass(frozen=True)
class Asked:
    """A case of the study with what its answer is worth.

    uncertainty  of the reference, as a fraction
    order        that theory gives the error, nan where the case does not say
    """

    label: str
    title: str
    measure: str
    reference: str
    uncertainty: float
    order: float
    why: str


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


@dataclass
class _Line:
    """What a line of convergence still has to run.

    rank      place among those that are run one after another
    by_costs  whether the expected cost of the next level is its place among all others
    """

    tasks: list[Task]
    rank: int = 0
    by_costs: bool = False
    done: list[Point] = field(default_factory=list)

    @property
    def place(self) -> tuple[int, float]:
        """Lines are run in this order: by rank, then by the level that comes next, or by what that should cost."""
        task = self.tasks[len(self.done)]
        if not self.by_costs:
            return self.rank, task.level
        expected = expected_cost(self.done, task.level)
        # what is beyond its limit is told at once: it takes no time, and a study that is stopped still knows it
        return self.rank, expected if expected <= task.limit else 0.0


def run_accuracy(
    study: CaseStudy, registry: Registry, folder: Path, jobs: int, told: Told, scheduler: str = LOCAL,
    so_far: SoFar | None = None, meanwhile: Callable[[], None] = lambda: None,
) -> Accuracy:  # fmt: skip
    """Every point of a study. What the archive in `folder` holds of this machine is not run again.

    so_far     is called after each point with what gives the study as it stands; points to come have status "waiting"
    meanwhile  is called once, when the first points are on their way in other processes and this one has to wait
    Raises RequestError for a wrong request. Ctrl-C ends it with the points that are there.
    """
    asked, lines = plan(study, registry)
    points: list[Point] = []
    total = sum(len(line.tasks) for line in lines)
    interrupted = False
    with Archive(folder / FILE) as archive, open_pool(scheduler, jobs) as pool:
        runner = _Runner(study, registry, folder / FILE, archive, pool)
        try:
            for point in runner.run(lines, jobs, meanwhile):
                points.append(point)
                told(point, len(points), total)
                if so_far is not None:
                    so_far(lambda: _with_others(study, registry, asked, lines, points, jobs, WAITING))
        except KeyboardInterrupt:
            interrupted = True
            pool.stop()
    found = _with_others(study, registry, asked, lines, points, jobs, "interrupted")
    return replace(found, interrupted=interrupted)


def _with_others(
    study: CaseStudy, registry: Registry, asked: Sequence[Asked], lines: Sequence[_Line], done: Sequence[Point],
    jobs: int, status: str,
) -> Accuracy:  # fmt: skip
    """All points in order: those that are done, and all others with this status."""
    labels = list(dict.fromkeys(contender.label for contender in contenders(study, registry)))
    cases = [each.label for each in asked]
    seen = {(p.case, p.contender, p.slave, p.level) for p in done}
    others = [named(t, status, OTHERS[status]) for line in lines for t in line.tasks if _place(t) not in seen]
    points = sorted([*done, *others], key=lambda p: (cases.index(p.case), labels.index(p.contender), p.slave, p.level))
    return Accuracy(study, asked, labels, points, jobs)


def _place(task: Task) -> tuple[str, str, str, int]:
    return task.choice.label, task.contender.label, task.slave, task.level


def plan(study: CaseStudy, registry: Registry) -> tuple[list[Asked], list[_Line]]:
    """The cases and the lines of convergence of what can be put to them. Raises RequestError."""
    folder = study.path.parent if study.path else None
    asked, groups = [], []
    for choice in choices(study, registry):
        problem = problem_of(choice, registry, folder)
        fitting = [
            (contender, swap)
            for contender in contenders(study, registry)
            for swap in (False, True)
            if SLAVES[swap] in (contender.slaves or SLAVES) and not problem.refusal(contender, swap)
        ]
        if not fitting:
            continue
        asked.append(_asked(problem, fitting[0][0]))
        asking = partial(Task, choice, limit=study.limit, repeat=study.repeat, folder=folder)
        groups.append(
            [
                _Line(
                    [asking(contender=contender, swap=swap, level=level) for level in sorted(levels)],
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


def _rank(study: CaseStudy, contender: Contender) -> int:
    """Place of the entry that a contender comes from, where these are run one after another."""
    if study.order != "contenders":
        return 0
    return next(n for n, one in enumerate(study.contenders) if one == replace(contender, algorithm=one.algorithm))


def _asked(problem: Problem, contender: Contender) -> Asked:
    setup = problem.setup(contender, False, 1)
    measure = problem.measure(setup)
    choice: CaseChoice = problem.choice
    return Asked(
        choice.label, problem.case.title, measure.name, problem.reference(setup), problem.uncertainty(setup),
        math.nan if measure.order is None else measure.order, choice.why,
    )  # fmt: skip


class _Runner:
    """Submits the next level of a line once the one before is done, and keeps what comes."""

    def __init__(self, study: CaseStudy, registry: Registry, path: Path, archive: Archive, pool: Pool) -> None:
        self.study, self.registry, self.path, self.archive, self.pool = study, registry, path, archive, pool
        self.spent = 0.0

    def run(self, lines: Sequence[_Line], jobs: int, meanwhile: Callable[[], None]) -> Iterator[Point]:
        """Points as they are made: never more under way than processes, so that coarse levels come first."""
        idle = [meanwhile]
        waiting = sorted(lines, key=lambda line: line.place)
        running: dict[Future[tuple[Point, list[StoredRun]]], tuple[_Line, Task]] = {}
        while waiting or running:
            while waiting and len(running) < jobs:
                line = waiting.pop(0)
                task = line.tasks[len(line.done)]
                known = self._without_running(line, task)
                if known is not None:
                    yield self._took(line, known, waiting)
                    continue
                limit = SLOW * task.limit * task.repeat
                call = Call(run_point, (task, self.registry, self.path), limit=limit)
                running[self.pool.submit(call)] = line, task
            if running and idle:
                idle.pop()()
            for future in wait(running, return_when=FIRST_COMPLETED).done if running else ():
                line, task = running.pop(future)
                yield self._took(line, self._kept(future, task), waiting)

    def _took(self, line: _Line, point: Point, waiting: list[_Line]) -> Point:
        """Add a point to its line, which goes back among those that wait: by their next level."""
        line.done.append(point)
        self.spent += point.spent
        if len(line.done) < len(line.tasks):
            waiting.insert(sum(other.place <= line.place for other in waiting), line)
        return point

    def _without_running(self, line: _Line, task: Task) -> Point | None:
        """The point where nothing has to be run for it."""
        if self.archive.record(task.key(), machine()) is not None:
            return named(task, "timed-out", f"took longer than its limit of {task.limit:g} CPU s before")
        expected = expected_cost(line.done, task.level)
        if math.isinf(expected):
            return named(task, "over-limit", f"a coarser level already took more than {task.limit:g} CPU s")
        if expected > task.limit:
            return named(task, "over-limit", f"would take about {expected:.2g} CPU s, the limit is {task.limit:g}")
        budget = self.study.budget
        if budget is not None and self.spent + expected * task.repeat > budget:
            return named(task, "over-budget", f"the {budget:g} CPU s of the study are used up")
        return None

    def _kept(self, future: Future[tuple[Point, list[StoredRun]]], task: Task) -> Point:
        try:
            point, made = future.result()
        except TimedOutError:
            reason = f"stopped after {SLOW * task.limit * task.repeat:g} s of wall time, {SLOW:g} times its limit"
            self.archive.add_run(remembered(task, reason))
            return timed_out(task, reason)
        except ProcessDiedError as error:
            return named(task, "failed", str(error))
        except RaisedError as error:
            return named(task, "failed", f"{error}")
        for run in made:
            self.archive.add_run(run)
        if point.cpu and point.cost > task.limit:
            reason = f"took {point.cost:.3g} CPU s, the limit is {task.limit:g}"
            return replace(point, status="timed-out", reason=reason, error=math.nan)
        return point


def expected_cost(done: Sequence[Point], level: int) -> float:
    """CPU time [s] to expect of a level, from the last two that were run; 0 where none was, inf above a limit."""
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
