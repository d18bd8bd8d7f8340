"""Question of a study: a case with the error that counts, and the methods that can answer it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from contactlab.accuracy.scene_case import SceneCase
from contactlab.accuracy.study import CaseChoice, CaseStudy, Contender
from contactlab.api import Answer, Case, Measure, Setup
from contactlab.cases.run_case import unfit, with_fields
from contactlab.errors import RequestError, did_you_mean
from contactlab.parts.registry import Registry, split_spec

KINDS = {"": "exact", "exact": "exact", "two-discretisations": "two discretisations", "other-code": "another code"}
KINDS["finest"] = "finer meshes"


@dataclass(frozen=True)
class Problem:
    """A case as a study asks it."""

    choice: CaseChoice
    case: Case

    def setup(self, contender: Contender, swap: bool, level: int) -> Setup:
        """Methods that the case is run with."""
        enforcement = contender.enforcement or ""
        return Setup(contender.algorithm, swap, contender.element, contender.integrator, level, enforcement)

    def refusal(self, contender: Contender, swap: bool, registry: Registry) -> str:
        """Why a contender cannot be put to it; empty where it can."""
        if not isinstance(self.case, SceneCase):
            for kind, spec, allowed in (
                ("element", contender.element, self.case.elements),
                ("integrator", contender.integrator, self.case.integrators),
            ):
                names = [_use(kind, each) for each in allowed]
                if _use(kind, spec) not in names:
                    return f"the case is made for {kind} {', '.join(names)}"
        return unfit(self.case, self.setup(contender, swap, 1), registry)

    def measure(self, setup: Setup) -> Measure:
        """The error that counts, with the answer of the choice. Raises RequestError where the case has none."""
        found = self._measure(setup)
        if self.choice.answer is None:
            return found
        kind = self.choice.kind or "finest"
        return replace(found, answer=Answer(self.choice.answer, kind, self.choice.uncertainty or 0.0, self.choice.why))

    def _measure(self, setup: Setup) -> Measure:
        found = self.case.measures(setup)
        names = [measure.name for measure in found]
        if self.choice.error:
            for measure in found:
                if measure.name == self.choice.error:
                    return measure
            raise RequestError(
                "the case has no such measure", where=f"case {self.choice.label}, key error", got=self.choice.error,
                allowed="; ".join(names), hint=did_you_mean(self.choice.error, names),
            )  # fmt: skip
        relative = [measure for measure in found if is_relative(measure)]
        if not relative:
            raise RequestError(
                "the case has no relative error", where=f"case {self.choice.label}", got="; ".join(names),
                allowed="a measure of role error without a unit, or one with an answer", hint="name one: error = ...",
            )  # fmt: skip
        return min(relative, key=lambda measure: not measure.name.startswith("L2"))

    def error(self, setup: Setup, values: Mapping[str, float]) -> float:
        """Relative error of what was found, nan where it was not."""
        measure = self.measure(setup)
        value = values.get(measure.name, math.nan)
        if measure.answer is not None and not _is_error(measure):
            return abs(value / measure.answer.value - 1.0)
        return abs(value)

    def uncertainty(self, setup: Setup) -> float:
        """Uncertainty of the reference, as a fraction; 0 for an exact reference."""
        if self.choice.uncertainty is not None:
            return self.choice.uncertainty
        answer = self.measure(setup).answer
        return answer.uncertainty if answer is not None else 0.0

    def reference(self, setup: Setup) -> str:
        """Name of the reference of the error."""
        answer = self.measure(setup).answer
        return KINDS[self.choice.kind or (answer.kind if answer is not None else "")]


def _use(kind: str, spec: Any) -> str:
    return split_spec(kind, spec, kind)[0]


def _is_error(measure: Measure) -> bool:
    """Return whether the value is an error itself, not a quantity with a known answer."""
    return measure.role == "reported" or measure.least == -measure.most or measure.least == -math.inf


def is_relative(measure: Measure) -> bool:
    """Return whether a measure is the relative error of a result."""
    if measure.role == "error" and not measure.unit and measure.least == -measure.most:
        return True
    answer = measure.answer
    return answer is not None and answer.value != 0.0 and not _is_error(measure)


def problem_of(choice: CaseChoice, registry: Registry, folder: Path | None = None) -> Problem:
    """The question of an entry. Raises RequestError or PartError."""
    if choice.scene:
        return Problem(choice, SceneCase.of(choice, registry, folder))
    case: Case = registry.make("case", choice.use, f"case {choice.label}")
    return Problem(choice, with_fields(case, choice.fields or {}))


def contenders(study: CaseStudy, registry: Registry) -> list[Contender]:
    """The contenders with every installed algorithm in the place of "*"."""
    found: dict[tuple[str, tuple[str, ...]], Contender] = {}
    for one in study.contenders:
        specs = registry.names("contact") if one.algorithm == "*" else [one.algorithm]
        for spec in specs:
            each = replace(one, algorithm=spec)
            found.setdefault((each.label, each.slaves), each)
    return list(found.values())


def choices(study: CaseStudy, registry: Registry) -> list[CaseChoice]:
    """The study's cases and, where it lets them join, those of other packages that have a relative error."""
    own = list(study.cases)
    if not study.join:
        return own
    packages = {_package(registry, choice.use) for choice in own if choice.use}
    return own + [
        CaseChoice(use=name)
        for name in registry.names("case")
        if _package(registry, name) not in packages and _has_error(registry, name)
    ]


def _package(registry: Registry, name: str) -> str:
    return registry.offer("case", name).part.target.partition(":")[0].partition(".")[0]


def _has_error(registry: Registry, name: str) -> bool:
    case: Case = registry.make("case", name)
    setup = Setup(registry.names("contact")[0], False, case.elements[0], case.integrators[0])
    # a case that raises has none: it is told where it is asked for by name
    try:
        measures = case.measures(setup)
    except Exception:
        measures = ()
    return any(is_relative(measure) for measure in measures)
