"""Cases: problems with known answers for contact algorithms.

A case is data: it plans runs, names their measures, and evaluates the records of the runs. It never runs anything
itself, so that it can be pickled, hashed and sent to another process.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal

from contactlab.api.record import Record
from contactlab.api.reference import Solution

Spec = str | Mapping[str, Any]
"""A part as a scene writes it: its name, or a table with `use` and fields."""

Changes = Mapping[str, Any]
"""Values at dotted keys of a scene, as `Scene.with_` takes them; None removes the key."""


@dataclass(frozen=True)
class Setup:
    """The choices with which a case is run: one cell of the matrix.

    algorithm   of every contact of the case
    swap        whether slave and master are exchanged from what the case declares
    element     of the bodies, one of `Case.elements`
    integrator  one of `Case.integrators`
    level       1 for the meshes of the quick matrix; the case decides what a higher level refines
    enforcement of every contact, whatever the case writes; empty for what the case or the integrator has
    """

    algorithm: Spec
    swap: bool = False
    element: Spec = ""
    integrator: Spec = ""
    level: int = 1
    enforcement: Spec = ""

    def changes(self, *bodies: str, contacts: int = 1) -> dict[str, Any]:
        """These choices as changes of a scene with `contacts` contacts; `bodies` are those that take the element."""
        found: dict[str, Any] = {f"bodies.{body}.element": self.element for body in bodies}
        found["integrator"] = self.integrator
        for number in range(contacts):
            found |= {f"contacts.{number}.algorithm": self.algorithm, f"contacts.{number}.swap": self.swap}
        return found


@dataclass(frozen=True)
class Job:
    """One run.

    name     unique among the jobs of a case
    scene    name of a bundled scene, or a scene as plain tables
    changes  of that scene
    watch    parts of kind watch; each is found in the record by the key `name` of its table, else by its `use`
    work     steps and iterations after which the run is stopped and not judged
    guards   False for a run that is meant to do what guards stop; it can miss a criterion but is never silent
    fields   whether the record keeps the fields at the end of the run
    frames   number of stored frames
    curves   whether the record keeps the curves of all stored frames, or of the last one
    """

    name: str
    scene: str | Mapping[str, Any]
    changes: Changes = field(default_factory=dict)
    watch: tuple[Spec, ...] = ()
    work: float = math.inf
    guards: bool = True
    fields: bool = False
    frames: int = 1
    curves: Literal["all", "last"] = "all"


@dataclass(frozen=True)
class Answer:
    """The known value of a measure.

    value        [unit of the measure]
    uncertainty  of it, as a fraction
    kind         "exact", "two-discretisations", "other-code" or "finest" (our own finest mesh)
    origin       paper, equation or program
    level        of the finest of the own runs that it is made of; None where it is made of none
    """

    value: float
    kind: Literal["exact", "two-discretisations", "other-code", "finest"] = "exact"
    uncertainty: float = 0.0
    origin: str = ""
    level: int | None = None

    def refusal(self, level: int) -> str:
        """Why a run at a level is not measured against it; empty where it is."""
        if self.level is None or level < self.level:
            return ""
        return f"the answer is made of runs at level {self.level}, and tells nothing of others on meshes as fine"


Role = Literal["error", "criterion", "invariant", "reported", "no-limit"]


@dataclass(frozen=True)
class Measure:
    """One number of a case.

    role   "error": against an answer; a finished run whose error exceeds 3 times `most` without a warning is silent.
           "criterion": met or missed. "invariant": no run may break it; a finished one that does is silent.
           "reported": not judged. "no-limit": a number of several meshes which shows that finer ones have no limit;
           where the case calls the problem ill-posed, a finished cell with such a number, and all met, is `ill-posed`
    least, most  allowed values
    why    the reason of the tolerance
    order  q, where the tolerance falls as h^q
    codes  of warnings that report a miss: with one of them given, a miss is not silent
    """

    name: str
    unit: str = ""
    role: Role = "criterion"
    least: float = -math.inf
    most: float = math.inf
    why: str = ""
    order: float | None = None
    codes: tuple[str, ...] = ()
    answer: Answer | None = None

    def met(self, value: float) -> bool:
        """Whether `value` is allowed: always if it is only reported, otherwise never for nan."""
        return self.role == "reported" or self.least <= value <= self.most


def error(name: str, most: float, why: str, unit: str = "", **more: Any) -> Measure:
    """An error of either sign, at most `most`."""
    return Measure(name, unit, "error", -most, most, why, **more)


def within(name: str, least: float, most: float, why: str, unit: str = "", **more: Any) -> Measure:
    """A criterion: a number between two others."""
    return Measure(name, unit, "criterion", least, most, why, **more)


def at_most(name: str, most: float, why: str, unit: str = "", **more: Any) -> Measure:
    """A criterion: a number that must not be larger."""
    return Measure(name, unit, "criterion", -math.inf, most, why, **more)


def near(name: str, exact: float, fraction: float, why: str, unit: str = "", **more: Any) -> Measure:
    """A criterion: a number within a fraction of its exact value."""
    slack = abs(exact) * fraction
    return Measure(name, unit, "criterion", exact - slack, exact + slack, why, answer=Answer(exact), **more)


def invariant(name: str, most: float, why: str, unit: str = "", **more: Any) -> Measure:
    """An invariant: a number that may exceed `most` in no run."""
    return Measure(name, unit, "invariant", -math.inf, most, why, **more)


def no_limit(name: str, least: float, most: float, why: str, unit: str = "", **more: Any) -> Measure:
    """A number which shows that finer meshes have no limit: between two others. See `Measure`."""
    return Measure(name, unit, "no-limit", least, most, why, **more)


def reported(name: str, unit: str = "") -> Measure:
    """A number that is reported and not judged."""
    return Measure(name, unit, "reported")


class Case(ABC):
    """A problem with a known answer. Subclasses are frozen dataclasses; their fields vary it (friction, mesh ratio).

    1. `plan` names the runs as data. Called again with the records so far, it may name more; () ends the plan.
    2. `measures` names the numbers and their allowed values, before anything has run.
    3. `evaluate` finds these numbers in the records, by name. Failed runs are records, too; a number that cannot
       be found is left out, which counts as nan.

    title        one line
    source       where the answer is published
    family       a word shared by related cases
    axes         values of the fields in the full matrix; the quick one takes the defaults
    demands      of "friction", "explicit", "implicit", "quadratic edges": shown to people and to `contactlab check`
    proves       property of a part that meets the case: "patch test", "friction", "momentum" ...
    integrators, elements  to choose from; the quick matrix takes the first
    swaps        whether slave and master can be exchanged
    margin       field that `--margins` changes until a criterion is missed, and the value at which it stops
    """

    title: ClassVar[str]
    source: ClassVar[str]
    family: ClassVar[str]
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {}
    demands: ClassVar[frozenset[str]] = frozenset()
    proves: ClassVar[frozenset[str]] = frozenset()
    integrators: ClassVar[tuple[Spec, ...]]
    elements: ClassVar[tuple[Spec, ...]]
    swaps: ClassVar[bool] = True
    margin: ClassVar[tuple[str, float] | None] = None

    @abstractmethod
    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Runs that are still needed; () when there is nothing more to run."""

    @abstractmethod
    def measures(self, setup: Setup) -> Sequence[Measure]:
        """The numbers that are measured with this setup, and their allowed values."""

    @abstractmethod
    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """The numbers by the names of the measures."""

    def exact_pressure(self, setup: Setup, done: Mapping[str, Record]) -> Solution | None:
        """The pressure that "L2 of the pressure" is measured against, and over which window; None where it has none.

        How well the slave's nodes can follow it is told beside the error.
        """
        return None

    def applies(self, setup: Setup) -> str:
        """Why the case cannot be run with this setup; empty when it can."""
        return "" if self.swaps or not setup.swap else "a rigid surface cannot be the slave"

    def ill_posed(self, setup: Setup) -> str:
        """Why the problem has no solution, so that a run which reports that is right; empty when it has one.

        Where every run finishes, measures of role "no-limit" must show it.
        """
        return ""
