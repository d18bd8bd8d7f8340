"""Trials of a choice: the runs that were made of a scene, their errors, and what they are measured against."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field
from statistics import median
from typing import Any

import numpy as np

from contactlab.accuracy.configuration import Configuration
from contactlab.accuracy.judged import ForcesJudged, Judge, Judged, PressuresJudged, forces_of, moves
from contactlab.accuracy.point import cost_of, spent_on
from contactlab.accuracy.remaining import Ladder, Truth, truth_of
from contactlab.api import Job, Record
from contactlab.errors import ContactlabError
from contactlab.jobs.perform import LEEWAY
from contactlab.jobs.run import Run
from contactlab.parts.registry import Registry
from contactlab.scene.scene import Scene
from contactlab.studies.find_reference import matching_reference
from contactlab.studies.finest import with_multipliers

FINER = (2, 3, 4, 6, 8, 12, 16)
"""Levels of the runs that errors are measured against."""
LIMIT = 10**6
"""Level beyond all that are tried."""
GROWTH = (1.0, 2.2, 3.5)
"""Power of the level that costs grow with: at least, while one level is known, at most."""
EQUAL = 0.1
"""CPU time [s] below which runs cost the same: then the more accurate one is taken."""

Said = Callable[[str], None]
Plan = Generator[Sequence[Any], Sequence[Any], Any]


@dataclass(frozen=True)
class Wish:
    """Request: relative error, CPU time of the chosen run and of all trials [s]."""

    error: float = 0.01
    budget: float = 60.0
    search: float = 120.0


@dataclass
class Trial:
    """A configuration at a level: what its run gave.

    costs    CPU times of its runs without start and compilation [s]
    facts    load steps, whether the way to the end matters, whether anything is pressed, contacts with coarse facets
    reached  part of the loading that a run came to which did not finish
    """

    status: str
    reason: str
    costs: list[float] = field(default_factory=list)
    pressures: Any = None
    forces: Any = None
    facts: Mapping[str, Any] = field(default_factory=dict)
    reached: float = 0.0

    @property
    def finished(self) -> bool:
        """Return whether the run finished."""
        return self.status == "finished"

    @property
    def cost(self) -> float:
        """Median of its CPU times [s]."""
        return median(self.costs) if self.costs else math.nan


Place = tuple[Configuration, int]


class Trials:
    """All runs of a scene so far."""

    def __init__(self, scene: Scene, wish: Wish, registry: Registry, said: Said = lambda line: None) -> None:
        self.scene, self.wish, self.registry, self.said = scene, wish, registry, said
        self.known = matching_reference(scene.data, registry)
        self.judge = Judge(self.known.window if self.known is not None else None)
        self.all: dict[Place, Trial] = {}
        self.spent = 0.0
        self.stopped = False
        self.means = moves(scene, registry)
        self.doubt = 0.0
        self.steps = 0
        self.exact = with_multipliers(registry)
        self._judged_at = -1
        self._truth: Truth | None = None
        self._off: dict[Place, float] = {}

    def run(self, wanted: Sequence[Place], until: float, limit: float = math.inf) -> Plan:
        """Make these trials within a limit [CPU s], the cheap ones first, up to a part of the search in all."""
        fresh = [p for p in dict.fromkeys(wanted) if p not in self.all and self.expected(*p) <= limit]
        fresh.sort(key=lambda place: self.expected(*place))
        if fresh and not self.stopped:
            yield [self._one(place, until * self.wish.search, limit) for place in fresh]

    def longer(self) -> Plan:
        """Make the first trial that was stopped for its time once more, without a limit but that of the search."""
        for place in [place for place, trial in self.all.items() if trial.status == "timed-out"][:1]:
            del self.all[place]
            yield from self.run([place], 1.0)

    def again(self, place: Place, number: int) -> Plan:
        """Repeat a trial for its cost."""
        yield from self._one(place, self.wish.search, math.inf, number)

    def _one(self, place: Place, until: float, limit: float, number: int = 0) -> Plan:
        configuration, level = place
        name = f"{self.name(configuration)}, level {level}"
        expected = self.expected(*place)
        left = max(self.wish.search - self.spent, 0.1) / LEEWAY  # a run is stopped after so many times its limit
        limit = min(limit, left, max(self.wish.budget, 2.0 * expected))
        try:
            changes = configuration.changes(self.scene.data, level)
            job = Job("run", self.scene.data, changes, curves="last", means=self.means)
            scene = self.scene.with_({"record.recorders": [], "record.frames": job.frames, **changes})
            run = Run(
                job, scene, f"{self.scene.name} {name}", number=number, timed=True,
                cpu_limit=float(f"{limit:.2g}"), rank=(expected,),
                unless=lambda: "no time left" if self.spent + expected > until else "",
            )  # fmt: skip
        except ContactlabError as error:
            self.all.setdefault(place, Trial("refused", str(error).strip().replace("\n", " ")))
            return
        (record,) = yield [run]
        if record.status == "interrupted":
            self.stopped = True
        elif record.status != "not-run":
            killed = record.status == "timed-out" and "process_s" not in record.summary
            self.spent += limit if killed else spent_on(record)
            self._keep(place, record, name)

    def _keep(self, place: Place, record: Record, name: str) -> None:
        reason = record.reason.strip().splitlines()[0] if record.reason.strip() else ""
        trial = self.all.setdefault(place, Trial(record.status, reason))
        if not record.finished:
            trial.reached = float(record.summary.get("reached", {}).get("share", 0.0))
            self.said(f"{name}: {record.status}{f': {reason}' if reason else ''}")
            return
        trial.costs.append(cost_of(record))
        if trial.forces is None:
            trial.pressures = self.judge.pressures(record)
            trial.forces = forces_of(record, place[0].exchanged)
            pressed = any(np.any(np.nan_to_num(found[-1].pressure)) for found in record.curves.values() if len(found))
            trial.facts = {
                "steps": record.summary.get("steps", 0),
                **record.summary.get("history", {}),
                "pressed": pressed,
                "coarse": coarse_facets(record),
            }
        self.said(f"{name}: {trial.costs[-1]:.3g} s")

    def name(self, configuration: Configuration) -> str:
        """Name of a configuration in tables."""
        return configuration.named(len(self.scene.contacts))

    def ladder(self, configuration: Configuration) -> dict[int, Trial]:
        """Finished runs of a configuration by level."""
        found = {n: t for (c, n), t in self.all.items() if c == configuration and t.finished}
        return dict(sorted(found.items()))

    def expected(self, configuration: Configuration, level: int) -> float:
        """CPU time [s] to expect of a run, by coarser ones; 0 if nothing is known."""
        known = [(n, max(t.cost, 1e-3)) for n, t in self.ladder(configuration).items()]
        if not known:
            return 0.0
        least, usual, most = GROWTH
        last, cost = known[-1]
        power = usual
        if len(known) > 1:
            power = math.log(cost / known[-2][1]) / math.log(last / known[-2][0])
        return float(cost * (level / last) ** min(max(power, least), most))

    def cost(self, place: Place) -> float:
        """CPU time of a trial [s]."""
        return self.all[place].cost

    def configurations(self) -> list[Configuration]:
        """All that have a finished run."""
        return list(dict.fromkeys(c for (c, _), t in self.all.items() if t.finished))

    def facetted(self) -> tuple[int, ...]:
        """Numbers of the contacts that smooth surfaces may help, and of those that have some."""
        coarse = {n for trial in self.all.values() for n in trial.facts.get("coarse", ())}
        own = {n for n, contact in enumerate(self.scene.contacts) if contact.smooth}
        return tuple(sorted(coarse | own)) if coarse else ()

    # --- what the trials say -----------------------------------------------------------------------

    def judged(self) -> Judged:
        """Pressures if two levels of a configuration have some, else forces."""
        return PressuresJudged(self.judge) if self.pressed() else ForcesJudged()

    def pressed(self) -> bool:
        """Return whether pressures can be judged."""
        return any(trial.pressures for trial in self.all.values())

    def bounded(self) -> bool:
        """Return whether an error can be promised: of pressures, or of forces if nothing is pressed at the end."""
        return self.pressed() or not any(trial.facts["pressed"] for trial in self.all.values() if trial.finished)

    def value(self, trial: Trial) -> Any:
        """Return the quantities of a run that are compared."""
        return self.judged().value(trial.pressures, trial.forces)

    def comparable(self, trial: Trial) -> bool:
        """Return whether there is anything to compare."""
        value = self.value(trial)
        return value is not None and len(value) > 0

    def apart(self, trial: Trial, other: Trial) -> float:
        """Relative distance of two runs."""
        return self.judged().apart(self.value(trial), self.value(other))

    def ladders(self) -> list[Ladder]:
        """Comparable runs by level of those whose errors are of the mesh alone; of all if none is on two meshes."""
        exact, others = list[Ladder](), list[Ladder]()
        for each in self.configurations():
            if self.is_static(each) and each.steps != self.steps:
                continue  # its way is coarser
            trials = {n: t for n, t in self.ladder(each).items() if self.comparable(t)}
            if trials:
                values = {n: self.value(t) for n, t in trials.items()}
                family = (each.exchanged, each.element)
                ladder = Ladder(self.name(each), family, values, trials[max(trials)].cost)
                (exact if each.algorithm in self.exact else others).append(ladder)
        return exact if any(len(ladder.values) > 1 for ladder in exact) else [*exact, *others]

    def is_static(self, each: Configuration) -> bool:
        """Return whether the integrator has no inertia."""
        name = each.integrator or str(self.scene.integrator["use"])
        return not self.registry.part_class("integrator", name).inertia

    def by_name(self, name: str) -> Configuration:
        """Configuration of a name."""
        return next(each for each in self.configurations() if self.name(each) == name)

    def truth(self) -> Truth | None:
        """Return the reference of errors: an installed one, else the finest runs."""
        if self._judged_at != len(self.all):
            self._judged_at, self._off = len(self.all), {}
            self._truth = self._find_truth()
        return self._truth

    def _find_truth(self) -> Truth | None:
        if self.known is not None and list(self.judge.lines)[:1] == [0]:
            known = self.known.pressure_uncertainty
            known = 0.0 if math.isnan(known) else known
            return Truth({0: self.known.profile}, known, self.known.title, self.known.level or LIMIT)
        return truth_of(self.ladders(), self.judged(), 3)

    def error(self, place: Place) -> float:
        """Distance of a trial from the truth; nan if it cannot be compared."""
        truth, trial = self.truth(), self.all[place]
        if place not in self._off:
            known = truth is not None and trial.finished and self.comparable(trial)
            self._off[place] = self.judged().apart(self.value(trial), truth.value) if known and truth else math.nan
        return self._off[place]

    def errors(self, configuration: Configuration) -> dict[int, float]:
        """Errors by level; of forces the largest from there on: a number that crosses zero on its way is no luck."""
        largest, found = 0.0, {}
        for level in sorted(self.ladder(configuration), reverse=True):
            error = self.error((configuration, level))
            if not math.isnan(error):
                largest = max(largest, error)
                found[level] = error if self.pressed() else largest
        return dict(sorted(found.items()))

    def meeting(self, truth: Truth) -> list[Place]:
        """Trials that keep the error with all that is uncertain, within the budget of a run."""
        target = self.wish.error - truth.uncertainty - self.doubt
        return [
            (each, level)
            for each in self.configurations()
            for level, error in self.errors(each).items()
            if error < target and self.ladder(each)[level].cost <= self.wish.budget
        ]


def coarse_facets(record: Record) -> tuple[int, ...]:
    """Numbers of the contacts that a run has found coarse facets in, where smooth surfaces are a cure."""
    found = (w["key"].split(".") for w in record.summary.get("warnings", ()) if w["code"] == "coarse-facets")
    return tuple(sorted(int(words[1]) for words in found if words[-1] == "smooth"))
