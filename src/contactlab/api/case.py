"""Cases: benchmark problems with known solutions for contact algorithms.

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
"""A plugin component as a scene writes it: its name, or a table with `use` and fields."""

Changes = Mapping[str, Any]
"""Values at dotted keys of a scene, as `Scene.with_` takes them; None removes the key."""


@dataclass(frozen=True)
class Setup:
    """The choices with which a case is run: one cell of the matrix.

    algorithm   for every contact of the case
    swap        True if slave and master are exchanged from the declaration of the case
    element     for the bodies, one of `Case.elements`
    integrator  one of `Case.integrators`
    level       1 for the meshes of the quick matrix; the case decides what a higher level refines
    enforcement of every contact, whatever the case writes; empty for the default of the case or integrator
    """

    algorithm: Spec
    swap: bool = False
    element: Spec = ""
    integrator: Spec = ""
    level: int = 1
    enforcement: Spec = ""

    def changes(self, *bodies: str, contacts: int = 1) -> dict[str, Any]:
        """Return these choices as changes of a scene with `contacts` contacts; `bodies` have the element."""
        found: dict[str, Any] = {f"bodies.{body}.element": self.element for body in bodies}
        found["integrator"] = self.integrator
        for number in range(contacts):
            found |= {f"contacts.{number}.algorithm": self.algorithm, f"contacts.{number}.swap": self.swap}
        return found


@dataclass(frozen=True)
class Job:
    """A planned run of a case.

    name     unique among the jobs of a case
    scene    name of a bundled scene, or a scene as plain tables
    changes  to the scene
    watch    callbacks of kind watch; the key `name` of the table names each in the record, or else its `use`
    work     steps and iterations after which the run is stopped and not judged
    guards   False for a run that does on purpose what guards stop; it can miss a criterion but is never silent
    fields   True if the record keeps the fields at the end of the run
    frames   number of stored frames
    curves   True if the record keeps the curves of all stored frames, or of the last frame
    means    True if the record has means in time of reactions and contact forces: `watched["means"]`
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
    means: bool = False


@dataclass(frozen=True)
class Answer:
    """The known value of a measure.

    value        [unit of the measure]
    uncertainty  as a fraction of the value
    kind         "exact", "two-discretisations", "other-code" or "finest" (our own finest mesh)
    origin       paper, equation or program
    level        finest level of our own runs behind the value; None without own runs
    """

    value: float
    kind: Literal["exact", "two-discretisations", "other-code", "finest"] = "exact"
    uncertainty: float = 0.0
    origin: str = ""
    level: int | None = None

    def refusal(self, level: int) -> str:
        """Return why a run at a level is not compared with the value; empty if it is."""
        if self.level is None or level < self.level:
            return ""
        return f"the answer is made of runs at level {self.level}, and does not judge others on meshes as fine"


Role = Literal["error", "criterion", "invariant", "reported", "no-limit"]


@dataclass(frozen=True)
class Measure:
    """A measured number of a case.

    role   "error": against a known value; a finished run whose error exceeds 3 times `most` without warning is silent.
           "criterion": met or missed. "invariant": no run may break it; a finished run that does is silent.
           "reported": not judged. "no-limit": a number of several meshes that shows divergence under refinement;
           if the case calls the problem ill-posed, a finished cell with such a number, and all met, is `ill-posed`
    least, most  allowed values
    why    the reason of the tolerance
    order  q, if the tolerance falls as h^q
    codes  of warnings that report a miss: with one of these warnings, a miss is not silent
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
        """Return True if `value` is allowed: always if it is only reported, otherwise never for NaN."""
        return self.role == "reported" or self.least <= value <= self.most


def error(name: str, most: float, why: str, unit: str = "", **more: Any) -> Measure:
    """Measure an error of either sign, at most `most`."""
    return Measure(name, unit, "error", -most, most, why, **more)


def within(name: str, least: float, most: float, why: str, unit: str = "", **more: Any) -> Measure:
    """Measure a criterion: a number between two limits."""
    return Measure(name, unit, "criterion", least, most, why, **more)


def at_most(name: str, most: float, why: str, unit: str = "", **more: Any) -> Measure:
    """Measure a criterion: a number with an upper limit."""
    return Measure(name, unit, "criterion", -math.inf, most, why, **more)


def near(name: str, exact: float, fraction: float, why: str, unit: str = "", **more: Any) -> Measure:
    """Measure a criterion: a number within a fraction of its exact value."""
    slack = abs(exact) * fraction
    return Measure(name, unit, "criterion", exact - slack, exact + slack, why, answer=Answer(exact), **more)


def invariant(name: str, most: float, why: str, unit: str = "", **more: Any) -> Measure:
    """Measure an invariant: a number that may exceed `most` in no run."""
    return Measure(name, unit, "invariant", -math.inf, most, why, **more)


def no_limit(name: str, least: float, most: float, why: str, unit: str = "", **more: Any) -> Measure:
    """Measure a number that shows that finer meshes have no limit: between two values. See `Measure`."""
    return Measure(name, unit, "no-limit", least, most, why, **more)


def reported(name: str, unit: str = "") -> Measure:
    """Measure a number that is reported and not judged."""
    return Measure(name, unit, "reported")


class Case(ABC):
    """A benchmark problem. Subclasses are frozen dataclasses; their fields vary it (friction, mesh ratio).

    1. `plan` names the runs as data. Called again with the records so far, it may name more; () ends the plan.
    2. `measures` names the numbers and their allowed values, before anything has run.
    3. `evaluate` finds these numbers in the records, by name. Failed runs are records, too; numbers that it cannot
       find are left out, which counts as NaN.

    title        one line
    source       publication of the solution
    family       a word shared by related cases
    axes         values of the fields in the full matrix; the quick one takes the defaults
    demands      of "friction", "explicit", "implicit", "quadratic edges": shown to people and to `contactlab check`
    proves       property of a plugin component that passes: "patch test", "friction", "momentum" ...
    integrators, elements  to choose from; the quick matrix takes the first
    swaps        True if slave and master can be exchanged
    margin       field that `--margins` changes until a criterion fails, and the value at which it stops
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
        """Return runs that are still needed; () if no run is left."""

    @abstractmethod
    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Return the numbers measured with this setup, and their allowed values."""

    @abstractmethod
    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Return the numbers by the names of the measures."""

    def exact_pressure(self, setup: Setup, done: Mapping[str, Record]) -> Solution | None:
        """Return the reference of "L2 of the pressure", with its window; None without one.

        The report also gives how well the slave's nodes can follow it.
        """
        return None

    def applies(self, setup: Setup) -> str:
        """Return why the case cannot be run with this setup; empty if it can."""
        return "" if self.swaps or not setup.swap else "a rigid surface cannot be the slave"

    def ill_posed(self, setup: Setup) -> str:
        """Return why the problem is ill-posed, so that a run that reports this is right; empty if it is well-posed.

        If every run finishes, measures of role "no-limit" must show it.
        """
        return ""
