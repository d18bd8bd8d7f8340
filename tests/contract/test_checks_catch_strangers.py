"""Defects as strangers plant them, most in right parts by one line: each is caught by a check of its kind."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, cast

import pytest
from contactlab_cases.measures import ContactLength, PeakError, PressureCentre
from contactlab_friction.coulomb import Coulomb
from contactlab_friction.tresca import Tresca
from contactlab_mortar.mortar import MortarP0

from contactlab.api import Case, FrictionBound, FrictionLaw, Job, Record, RunMeasure, Setup, Solution
from contactlab.parts.contract import faults
from contactlab.parts.registry import default_registry
from contactlab.testing import case, friction, measure, reference
from contactlab.testing.assertions import Check

LAYERS: Any = default_registry().part_class("reference", "even-compression")
PATCH: Any = default_registry().part_class("case", "patch")


@dataclass(frozen=True)
class Adhesive(FrictionLaw):
    """A right law: Coulomb's with an adhesion by default."""

    mu: float = 0.3
    grip: float = 2.0

    def bound(self) -> FrictionBound:
        return FrictionBound(self.mu, self.grip, math.inf)


@dataclass(frozen=True)
class GripIgnored(Adhesive):
    def bound(self) -> FrictionBound:
        return FrictionBound(self.mu, 2.0, math.inf)


@dataclass(frozen=True)
class MuOfDefault(Adhesive):
    def bound(self) -> FrictionBound:
        return FrictionBound(0.3, self.grip, math.inf)


@dataclass(frozen=True)
class NegativeGrip(Adhesive):
    def bound(self) -> FrictionBound:
        return FrictionBound(self.mu, -self.grip, math.inf)


@dataclass(frozen=True)
class InMillimetres(Adhesive):
    def bound(self) -> FrictionBound:
        return FrictionBound(math.nan if self.mu < 1.0 else self.mu, self.grip, math.inf)


@dataclass(frozen=True)
class Worn(Adhesive):
    calls: ClassVar[list[int]] = []

    def bound(self) -> FrictionBound:
        self.calls.append(1)
        return FrictionBound(self.mu * (1.0 + 1e-3 * len(self.calls)), self.grip, math.inf)


@dataclass(frozen=True)
class NoBound(Adhesive):
    def bound(self) -> Any:
        return self.mu, self.grip


class Measured(RunMeasure):
    """What defects of measures change: what comes out of a shipped one."""

    inner: ClassVar[RunMeasure] = ContactLength()
    title, unit, meaning, digits = inner.title, inner.unit, inner.meaning, inner.digits

    def evaluate(self, record: Record, contact: str, reference: Solution | None) -> float:
        return self.found(self.inner.evaluate(record, contact, reference), record, contact)

    def found(self, value: float, record: Record, contact: str) -> float:
        return value


@dataclass(frozen=True)
class Constant(Measured):
    def found(self, value: float, record: Record, contact: str) -> float:
        return 0.2 if value > 0.0 else 0.0


@dataclass(frozen=True)
class ZeroForNan(Measured):
    def found(self, value: float, record: Record, contact: str) -> float:
        return 0.0 if math.isnan(value) else value


@dataclass(frozen=True)
class PeakWithoutReference(Measured):
    inner: ClassVar[RunMeasure] = PeakError()

    def evaluate(self, record: Record, contact: str, reference: Solution | None) -> float:
        value = self.inner.evaluate(record, contact, reference)
        return math.nan if math.isnan(value) else 0.03


@dataclass(frozen=True)
class Overflows(Measured):
    def found(self, value: float, record: Record, contact: str) -> float:
        return math.inf if value == 0.0 else value


@dataclass(frozen=True)
class Doubles(Measured):
    def found(self, value: float, record: Record, contact: str) -> float:
        record.curve(contact).pressure[:] *= 2.0
        return value


@dataclass(frozen=True)
class WritesSummary(Measured):
    def found(self, value: float, record: Record, contact: str) -> float:
        record.summary["length"] = value  # type: ignore[index]
        return value


@dataclass(frozen=True)
class OtherUnit(Measured):
    unit = "inch"


@dataclass(frozen=True)
class Counts(Measured):
    calls: ClassVar[list[int]] = []

    def found(self, value: float, record: Record, contact: str) -> float:
        self.calls.append(1)
        return value + 1e-9 * len(self.calls)


@dataclass(frozen=True)
class CentreOfAll(Measured):
    inner: ClassVar[RunMeasure] = PressureCentre()

    def found(self, value: float, record: Record, contact: str) -> float:
        return value if value == value else math.inf


@dataclass(frozen=True)
class AlgorithmForgotten(PATCH):  # type: ignore[misc]
    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        jobs: Sequence[Job] = super().plan(replace(setup, algorithm="mortar-p0"), done)
        return jobs


@dataclass(frozen=True)
class SwapForgotten(PATCH):  # type: ignore[misc]
    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        jobs: Sequence[Job] = super().plan(replace(setup, swap=False), done)
        return jobs


@dataclass(frozen=True)
class ElementForgotten(PATCH):  # type: ignore[misc]
    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        jobs: Sequence[Job] = super().plan(replace(setup, element=self.elements[0]), done)
        return jobs


@dataclass(frozen=True)
class NoReason(PATCH):  # type: ignore[misc]
    def measures(self, setup: Setup) -> Any:
        return [replace(one, why="") for one in super().measures(setup)]


@dataclass(frozen=True)
class TwiceTheSame(PATCH):  # type: ignore[misc]
    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        return [*super().plan(setup, done)] * 2


@dataclass(frozen=True)
class DepthForgotten(LAYERS):  # type: ignore[misc]
    def solution(self, scene: Mapping[str, Any]) -> Solution:
        found = super().solution(scene)
        share = 10.0 / found.pressure.max()
        force = scaled_force(found, share)
        return replace(found, pressure=share * found.pressure, scalars={"reaction": force})


@dataclass(frozen=True)
class KiloNewton(LAYERS):  # type: ignore[misc]
    def solution(self, scene: Mapping[str, Any]) -> Solution:
        found = super().solution(scene)
        return replace(found, scalars={"reaction": scaled_force(found, 1e-3)})


@dataclass(frozen=True)
class RenamesTheScene(LAYERS):  # type: ignore[misc]
    def solution(self, scene: Any) -> Solution:
        scene["name"] = "solved"
        return cast(Solution, super().solution(scene))


@dataclass(frozen=True)
class HoldsForAll(LAYERS):  # type: ignore[misc]
    def mismatch(self, scene: Mapping[str, Any]) -> str:
        return "" if "bodies" not in scene else cast(str, super().mismatch(scene))


@dataclass(frozen=True)
class Drifts(LAYERS):  # type: ignore[misc]
    calls: ClassVar[list[int]] = []

    def solution(self, scene: Mapping[str, Any]) -> Solution:
        self.calls.append(1)
        found = super().solution(scene)
        return replace(found, pressure=found.pressure * (1.0 + 1e-9 * len(self.calls)))


@dataclass(frozen=True)
class OneAlgorithm(LAYERS):  # type: ignore[misc]
    def mismatch(self, scene: Mapping[str, Any]) -> str:
        why = cast(str, super().mismatch(scene))
        return why or ("" if scene["contacts"][0].get("swap") is not True else "the slave is the other one")


def scaled_force(found: Solution, share: float) -> Any:
    """The reaction, times a share."""
    return replace(found.scalars["reaction"], value=share * found.scalars["reaction"].value)


CAUGHT: list[tuple[Check, Any]] = [
    (friction.numbers_count, GripIgnored()),
    (friction.numbers_count, MuOfDefault()),
    (friction.numbers_in_range, NegativeGrip()),
    (friction.numbers_in_range, InMillimetres()),
    (friction.same_bound_twice, Worn()),
    (friction.numbers_in_range, NoBound()),
    (measure.follows_from_the_run, Constant()),
    (measure.follows_from_the_run, ZeroForNan()),
    (measure.follows_from_the_run, PeakWithoutReference()),
    (measure.outlives_empty_contacts, Overflows()),
    (measure.outlives_empty_contacts, CentreOfAll()),
    (measure.changes_nothing, Doubles()),
    (measure.changes_nothing, WritesSummary()),
    (measure.says_what_it_is, OtherUnit()),
    (measure.finds_the_same_again, Counts()),
    (case.plans_what_is_asked, AlgorithmForgotten()),
    (case.plans_what_is_asked, SwapForgotten()),
    (case.plans_what_is_asked, ElementForgotten()),
    (reference.follows_the_depth, DepthForgotten()),
    (reference.pressure_carries_the_reaction, KiloNewton()),
    (reference.can_be_compared_with, RenamesTheScene()),
    (reference.is_silent_about_strange_scenes, HoldsForAll()),
    (reference.can_be_compared_with, Drifts()),
    (reference.does_not_depend_on_the_mesh, OneAlgorithm()),
    (case.measures_with_reasons, NoReason()),
    (case.plans_scenes, TwiceTheSame()),
]


@pytest.mark.parametrize(("check", "part"), CAUGHT)
def test_defects_of_strangers_are_caught(caught: Any, check: Check, part: Any) -> None:
    caught(check, part)


RIGHT: list[tuple[tuple[Check, ...], Any]] = [
    (friction.CHECKS, Adhesive()),
    (friction.CHECKS, Coulomb(mu=0.3)),
    (friction.CHECKS, Tresca(stress=20.0)),
    (measure.CHECKS, ContactLength()),
    (measure.CHECKS, PeakError()),
    (measure.CHECKS, PressureCentre()),
    (reference.CHECKS, LAYERS()),
    (case.CHECKS, PATCH()),
]


@pytest.mark.parametrize(("checks", "part"), RIGHT)
def test_the_right_parts_that_they_were_made_of_pass(checks: tuple[Check, ...], part: Any) -> None:
    for check in checks:
        check(part)


def test_names_that_miss_the_contract_by_a_letter_are_refused() -> None:
    wrong = type("Wrong", (Coulomb,), {"__module__": __name__, "passes_patch_tests": True, "bounds": lambda self: None})
    wrong_case = type("WrongCase", (PATCH,), {"__module__": __name__, "famly": "contact", "helper": 1})
    assert "its bounds is nothing that the contract knows; did you mean bound?" in faults("friction", wrong)
    assert "its famly is nothing that the contract knows; did you mean family?" in faults("case", wrong_case)
    assert not [line for line in faults("case", wrong_case) if "helper" in line]
    body = {"__module__": __name__, "__annotations__": {"keep_energy": ClassVar[bool]}, "keep_energy": True}
    promised = dataclass(frozen=True)(type("Promised", (MortarP0,), body))
    assert "its keep_energy is nothing that the contract knows; did you mean keeps_energy?" in faults(
        "contact", promised
    )


assert issubclass(PATCH, Case)
