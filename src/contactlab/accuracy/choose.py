"""Choosing for one scene: the cheapest algorithm, slave, element, integrator and level that meet an error."""

from __future__ import annotations

import math
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from contactlab.accuracy.finer_reference import Finer, Said, finer_plan
from contactlab.accuracy.lines import Line, lines_of, reached
from contactlab.accuracy.point import NOT_RUN, Point
from contactlab.accuracy.run import Accuracy, Asked, Budget, Told, line_plan, plan
from contactlab.accuracy.scene_case import choices_of
from contactlab.accuracy.study import CaseChoice, CaseStudy, Contender
from contactlab.api import Setup
from contactlab.errors import RequestError
from contactlab.parts.registry import Registry
from contactlab.scene.scene import Scene
from contactlab.scene.toml_text import write_toml
from contactlab.studies.find_reference import matching_reference

FIRST = (1, 2)
"""Levels at which everything is tried."""
FINER = (4, 8, 16)
WITH_ELEMENTS = 2
"""Contenders that other elements than those of the scene are tried with."""
KEPT = 3
"""Lines that go on to finer levels: those that seem to get there at the least cost."""
ROUNDS = 2
"""How often levels between those that miss the error and those that meet it are tried."""
SLOWEST = 0.5
"""Order of convergence that is expected at least, where two levels show less."""
CLEAR = 10.0
"""A reference that is made here is refined until its uncertainty is below the error over this, while there is time.

It is taken from the error that the trials must meet. With an error C h and costs of h^-2, a tenth of it costs 1.2 times
as much as an exact reference would, a third 2.2 times.
"""
TRIAL = 0.05
"""Of the search that one of the first trials may take."""
SHARE = 0.5
"""Of the search that making a reference may take before it is refined no more."""


@dataclass(frozen=True)
class Wish:
    """What is asked for: relative error, CPU time of the run that is chosen and of all trials [s]."""

    error: float = 0.01
    budget: float = 60.0
    search: float = 120.0


@dataclass(frozen=True)
class Chosen:
    """What was found. `settings` are scene keys and values; empty where nothing meets the wish, and `why` says why not.

    cost   CPU time of the run [s] with its interval; error  measured at this level; uncertainty  of the reference
    known  points that the archive had, of those `tried`
    """

    why: str
    reference: str
    uncertainty: float
    tried: Sequence[Point]
    settings: Mapping[str, Any] = field(default_factory=dict)
    name: str = ""
    level: int = 0
    error: float = math.nan
    cost: tuple[float, float, float] = (math.nan, math.nan, math.nan)

    @property
    def known(self) -> int:
        """How many of the points the archive had."""
        return sum(point.spent == 0.0 and bool(point.cpu) for point in self.tried)


def choose_plan(
    scene: Scene, wish: Wish, registry: Registry, folder: Path, told: Told, said: Said = lambda line: None
) -> Generator[Sequence[Any], Sequence[Any], Chosen]:
    """Try contenders on coarse meshes, follow the promising ones, and take the cheapest that meets the error.

    Raises RequestError for a scene without contact.
    """
    if not scene.contacts:
        raise RequestError("the scene has no contact to choose for", where=scene.name, allowed="[[contacts]]")
    made = yield from _reference_plan(scene, wish, registry, folder, said)
    reference = made.reference
    if reference is None:
        return Chosen(f"there is nothing to measure errors against: {made.why}", "", math.nan, ())
    uncertainty = 0.0 if math.isnan(reference.pressure_uncertainty) else reference.pressure_uncertainty
    target = wish.error - uncertainty
    if target <= 0.0:
        why = f"the reference itself is known to {100.0 * uncertainty:.2g} % only: a larger --search may refine it"
        return Chosen(why, reference.title, uncertainty, ())
    search = _Search(scene, replace(wish, error=target), registry, folder, told, made)
    return (yield from search.result(reference.title, uncertainty))


def _reference_plan(
    scene: Scene, wish: Wish, registry: Registry, folder: Path, said: Said
) -> Generator[Sequence[Any], Sequence[Any], Finer]:
    """An installed reference of the scene, else one from finer meshes."""
    installed = matching_reference(scene.data, registry)
    if installed is not None:
        return Finer(installed, "", "", 0.0)
    integrator = integrators_for(scene, registry)[0]
    enough, budget = wish.error / CLEAR, SHARE * wish.search
    return (yield from finer_plan(scene, integrator, enough, budget, folder, registry, said))


def integrators_for(scene: Scene, registry: Registry) -> list[Any]:
    """Those that can take the scene, static ones first where it is quasi-static, its own among them."""
    own = dict(scene.integrator)
    names = registry.names("integrator")
    static = [name for name in names if not registry.part_class("integrator", name).inertia]
    quasi = scene.data["time"].get("end") == "auto" or own["use"] in static
    found: list[Any] = [own if name == own["use"] else name for name in static] if quasi else []
    return found if own in found else [*found, own]


class _Search:
    """The trials: everything on coarse meshes, then other elements and finer levels of what is promising."""

    def __init__(
        self, scene: Scene, wish: Wish, registry: Registry, folder: Path, told: Told, reference: Finer
    ) -> None:
        self.scene, self.wish, self.registry, self.told = scene, wish, registry, told
        path = folder / "scene.toml"
        path.write_text(write_toml(scene.data), encoding="utf-8")
        self.case = CaseChoice(scene=str(path.resolve()), name=scene.name, reference=reference.file)
        self.points: dict[tuple[str, str, int], Point] = {}
        self.contenders: dict[str, Contender] = {}
        self.spent = reference.spent
        self.study = CaseStudy((self.case,), ())
        self.asked: Sequence[Asked] = ()

    def result(self, title: str, uncertainty: float) -> Generator[Sequence[Any], Sequence[Any], Chosen]:
        """Search, and take the cheapest line that meets the error."""
        first = self._own()
        lines = yield from self._run(first, FIRST)
        others = [name for name in self.registry.names("element") if name not in self._elements()]
        first = [self.contenders[name] for name in self._contenders(self._promising(lines))[:WITH_ELEMENTS]]
        lines = yield from self._run([replace(contender, element=e) for contender in first for e in others], FIRST)
        for level in FINER:
            front = self._going_on(lines)
            if not front:
                break
            lines = yield from self._run([self._alone(line) for line in front], (*FIRST, level))
        lines = yield from self._between(lines)
        return self._chosen(lines, title, uncertainty)

    def _going_on(self, lines: Sequence[Line]) -> list[Line]:
        """Promising lines that miss the error so far, and seem to meet it for less than any run that does."""
        error, budget = self.wish.error, self.wish.budget
        least = min((met.cost for line in lines if (met := first_meeting(line, error, budget))), default=math.inf)
        front = self._promising(lines)[:KEPT]
        return [line for line in front if not reached(line, error) and expected_cost(line, error) < least]

    def _alone(self, line: Line) -> Contender:
        """The contender of a line with its slave only."""
        slave: Literal["declared", "exchanged"] = "exchanged" if line.slave == "exchanged" else "declared"
        return replace(self.contenders[line.contender], slaves=(slave,))

    @staticmethod
    def _contenders(lines: Sequence[Line]) -> list[str]:
        """Their contenders in the same order, each once."""
        return list(dict.fromkeys(line.contender for line in lines))

    def _own(self) -> list[Contender]:
        """All algorithms and integrators with the elements as they are written."""
        return [
            Contender(str(each["use"] if isinstance(each, Mapping) else each), "", each, algorithm)
            for each in integrators_for(self.scene, self.registry)
            for algorithm in self.registry.names("contact")
        ]

    def _elements(self) -> set[str]:
        return {str(body["element"]["use"]) for body in self.scene.data["bodies"].values()}

    def _run(
        self, contenders: Sequence[Contender], levels: Sequence[int]
    ) -> Generator[Sequence[Any], Sequence[Any], list[Line]]:
        """Points of these contenders at these levels, and all lines so far."""
        self.contenders |= {one.label: replace(one, slaves=()) for one in contenders}
        left = self.wish.search - self.spent
        if contenders and left > 0.0:
            study = CaseStudy(
                (self.case,), tuple(contenders), levels=tuple(levels), join=False, limit=self._limit(levels),
                budget=left, targets=(self.wish.error,),
            )  # fmt: skip
            self.asked, tasks = plan(study, self.registry)
            budget = Budget(left)
            found = yield [line_plan(line, self.registry, budget, self._told_once) for line in tasks]
            self.spent += budget.spent
            for point in (point for points in found for point in points):
                place = point.contender, point.slave, point.level
                if place not in self.points or (point.cpu and not self.points[place].cpu):
                    self.points[place] = point  # not what the archive knows by now: that would have taken no time
            self.study = study
        names = list(dict.fromkeys(point.contender for point in self.points.values()))
        return lines_of(Accuracy(self.study, self.asked, names, list(self.points.values()), 1))

    def _told_once(self, point: Point) -> None:
        """Lines that continue bring their coarser points along."""
        if (point.contender, point.slave, point.level) not in self.points:
            self.told(point)

    def _limit(self, levels: Sequence[int]) -> float:
        """CPU time of one trial [s]: a stubborn one must not take the search from all others."""
        share = TRIAL if tuple(levels) == FIRST else SHARE
        return min(self.wish.budget, share * self.wish.search)

    def _promising(self, lines: Sequence[Line]) -> list[Line]:
        """Lines by the cost that the error seems to need, without those that seem to need more than the budget."""
        expected = {id(line): expected_cost(line, self.wish.error) for line in lines}
        fitting = [line for line in lines if expected[id(line)] <= self.wish.budget]
        return sorted(fitting, key=lambda line: expected[id(line)])

    def _between(self, lines: Sequence[Line]) -> Generator[Sequence[Any], Sequence[Any], list[Line]]:
        """Levels between two that were run, where the error seems to be met there already."""
        for _ in range(ROUNDS):
            asked = [
                (self._alone(line), level)
                for line in self._promising(lines)[:KEPT]
                if (level := _level_between(line, self.wish.error))
            ]
            if not asked:
                break
            for one, level in asked:
                lines = yield from self._run([one], (level,))
        return list(lines)

    def _chosen(self, lines: Sequence[Line], title: str, uncertainty: float) -> Chosen:
        tried = [point for point in self.points.values() if point.status not in NOT_RUN]
        found = [(line, point) for line in lines if (point := first_meeting(line, self.wish.error, self.wish.budget))]
        if not found:
            return Chosen(self._cannot(lines), title, uncertainty, tried)
        line, point = min(found, key=lambda pair: pair[1].cost)
        rivals = sorted(p.cost for other, p in found if other is not line)
        why = f"the cheapest of {len(found)} configurations that meet the error"
        if rivals:
            why += f"; the next one takes {rivals[0]:.2g} CPU s"
            why += " and cannot be told from it" if rivals[0] <= point.cost * line.spread**2 else ""
        cost = (point.cost, point.cost / line.spread, point.cost * line.spread)
        return Chosen(
            why, title, uncertainty, tried, self._settings(line, point), line.name, point.level, point.error, cost
        )

    def _cannot(self, lines: Sequence[Line]) -> str:
        there = [line for line in lines if line.finished]
        if not there:
            return "no trial came to its end"
        best = min(there, key=lambda line: min(line.errors))
        expected = expected_cost(best, self.wish.error)
        text = f"nothing that was tried meets it: {best.name} comes to {100.0 * min(best.errors):.2g} % at level "
        text += f"{best.finished[-1].level} in {best.finished[-1].cost:.2g} CPU s"
        return text + (f", and would need about {expected:.2g} CPU s" if math.isfinite(expected) else "")

    def _settings(self, line: Line, point: Point) -> dict[str, Any]:
        """The scene keys that make the chosen run."""
        contender = self.contenders[line.contender]
        setup = Setup(
            contender.algorithm, line.slave == "exchanged", contender.element, contender.integrator, point.level
        )
        found = choices_of(self.scene.data, setup)
        own = dict(self.scene.integrator)
        if found["integrator"] == own:
            del found["integrator"]
        return found


def expected_cost(line: Line, error: float) -> float:
    """CPU time [s] to an error: on the line, or beyond it as its last two points go; inf where they tell nothing."""
    if reached(line, error):
        return line.cost_at(error)
    points = line.finished
    if len(points) < 2 or points[-1].level < line.points[-1].level:  # a finer one did not come to its end
        return math.inf
    (a, b), (e, f) = points[-2:], line.errors[-2:]
    ratio = math.log(b.level / a.level)
    order = max(SLOWEST, math.log(e / f) / ratio)
    power = max(1.0, math.log(b.cost / a.cost) / ratio)
    return float(b.cost * (f / error) ** (power / order))


def first_meeting(line: Line, error: float, budget: float) -> Point | None:
    """The coarsest point from which on the error is met, where its cost is within the budget; None without one."""
    for point, largest in zip(line.finished, line.errors, strict=True):
        if largest <= error:
            return point if point.cost <= budget else None
    return None


def _level_between(line: Line, error: float) -> int:
    """A level between the last that misses the error and the first that meets it, 0 where there is none."""
    for k in range(1, len(line.finished)):
        if line.errors[k] <= error < line.errors[k - 1]:
            low, high = line.finished[k - 1].level, line.finished[k].level
            share = math.log(line.errors[k - 1] / error) / math.log(line.errors[k - 1] / line.errors[k])
            level = math.ceil(low * (high / low) ** share)
            return level if low < level < high else 0
    return 0
