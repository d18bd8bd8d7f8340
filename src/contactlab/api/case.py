"""Cases: questions with known answers that are put to contact algorithms.

A case is data, and questions put to records: it plans runs, names what is measured on them, and evaluates what came
back. It never runs anything itself, so that it pickles, hashes and travels.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal

from contactlab.api.record import Record

Spec = str | Mapping[str, Any]
"""A part as a scene writes it: its name, or a table with `use` and fields."""

Changes = Mapping[str, Any]
"""Values at dotted keys of a scene, as `Scene.with_` takes them; None takes the key away."""


@dataclass(frozen=True)
class Setup:
    """What a case is put to: the choices of one cell of the matrix.

    algorithm   of every contact of the case
    swap        whether slave and master are exchanged against what the case declares
    element     of the bodies, one of `Case.elements`
    integrator  one of `Case.integrators`
    level       1 for the size of the quick matrix; what a higher one refines, the case says
    """

    algorithm: Spec
    swap: bool = False
    element: Spec = ""
    integrator: Spec = ""
    level: int = 1

    def changes(self, *bodies: str, contacts: int = 1) -> dict[str, Any]:
        """These choices as changes of a scene with so many contacts, and with elements to choose in `bodies`."""
        found: dict[str, Any] = {f"bodies.{body}.element": self.element for body in bodies}
        found["integrator"] = self.integrator
        for number in range(contacts):
            found |= {f"contacts.{number}.algorithm": self.algorithm, f"contacts.{number}.swap": self.swap}
        return found


@dataclass(frozen=True)
class Job:
    """One run.

    name     tells the jobs of a case apart
    scene    name of a bundled scene, or a scene as plain tables
    changes  of that scene
    watch    parts of kind watch; each is found in the record by the key `name` of its table, else by its `use`
    work     steps and iterations after which the run is stopped and not judged
    guards   False for a run that means to do what the guards stop; it can miss a criterion but is never silent
    fields   whether the record keeps the fields of the end
    frames   stored frames
    """

    name: str
    scene: str | Mapping[str, Any]
    changes: Changes = field(default_factory=dict)
    watch: tuple[Spec, ...] = ()
    work: float = math.inf
    guards: bool = True
    fields: bool = False
    frames: int = 1


@dataclass(frozen=True)
class Answer:
    """What a measure is compared with.

    value        [unit of the measure]
    uncertainty  of it, as a fraction
    kind         "exact", "two-discretisations", "other-code" or "finest" (of the own meshes)
    origin       paper, equation or program
    """

    value: float
    kind: Literal["exact", "two-discretisations", "other-code", "finest"] = "exact"
    uncertainty: float = 0.0
    origin: str = ""


Role = Literal["error", "criterion", "invariant", "reported"]


@dataclass(frozen=True)
class Measure:
    """One number of a case.

    role   "error": against an answer; a finished run that is off by over 3 times `most` without a warning is silent.
           "criterion": met or missed. "invariant": what no run may break; a finished one that does is silent.
           "reported": only told
    least, most  allowed values
    why    the reason of the tolerance
    order  q, where the tolerance falls as h^q
    codes  of warnings that name a miss: with one of them set, a miss is not silent
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
        """Whether `value` is allowed; what is only reported always is, and nan never."""
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
    """An invariant: a number that no run may let grow larger than `most`."""
    return Measure(name, unit, "invariant", -math.inf, most, why, **more)


def reported(name: str, unit: str = "") -> Measure:
    """A number that is told and not judged."""
    return Measure(name, unit, "reported")


class Case(ABC):
    """A question. Subclasses are frozen dataclasses; their fields are perturbations of it (mesh ratio, friction ...).

    1. `plan` names the runs as data; called again with what is done, it may name more, and nothing ends it.
    2. `measures` says what is measured and what is allowed, before anything has run.
    3. `evaluate` finds these numbers in the records, by name. Runs that failed are records, too; a number that cannot
       be found is left out, which counts as nan.

    title        one line
    source       where the answer is published
    family       a word that cases which belong together share
    axes         values of the fields in the full matrix; the quick one takes the defaults
    demands      of "friction", "explicit", "implicit", "quadratic edges": told to people and to `contactlab check`
    proves       what a part shows that meets it: "patch test", "friction", "momentum" ...
    integrators, elements  to choose from; the first is that of the quick matrix
    swaps        whether slave and master can be exchanged
    margin       field that `--margins` drives until a criterion is missed, and the value it stops at
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
        """The numbers that are measured with this setup, and what they are compared with."""

    @abstractmethod
    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """The numbers by the names of the measures."""

    def applies(self, setup: Setup) -> str:
        """Why this setup cannot be put to the case; empty when it can."""
        return "" if self.swaps or not setup.swap else "a rigid surface cannot be the slave"

    def ill_posed(self, setup: Setup) -> str:
        """Why the problem has no answer, so that a run which says so is right; empty when it has one."""
        return ""
