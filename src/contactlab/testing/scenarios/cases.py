"""Cases, from the registry, that prove what a part promises."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from contactlab.api import Case, Potential, Setup
from contactlab.cases.run_case import declined, evaluated, run_case, unfit
from contactlab.cases.verdict import Finding, allowed, judge
from contactlab.errors import RequestError
from contactlab.parts.registry import Registry
from contactlab.testing.assertions import Expected, NotApplicable, require
from contactlab.testing.partners import usual_algorithm, usual_law
from contactlab.testing.scenarios.runs import half_passes
from contactlab.testing.subject import Subject

PACKAGE = "contactlab-cases"
ENERGY = "rise of energy"
"""Text in the names of measures of energy made by contact."""
WIDTH = "half-width"
"""Text in the names of measures of the ends of contact."""
EVEN, EVEN_BY_A_LAW = 1e-10, 1e-5
"""Shares of the largest stress: round-off of a solve; error of iterations for the pressure of a law."""
WORK = 5000.0
"""Steps and iterations of a run that sets no limit."""


@dataclass(frozen=True)
class Question:
    """A case with some of its fields; `element` is a number among the case's elements, `swap` exchanges the slave."""

    case: str
    fields: Mapping[str, Any] = field(default_factory=dict)
    swap: bool = False
    element: int = 0

    @property
    def label(self) -> str:
        """The question in a few words."""
        words = [f"{name} {value:g}" for name, value in self.fields.items()]
        words += ["slave exchanged"] if self.swap else []
        words += ["quadratic edges"] if self.element else []
        return " ".join([self.case, f"({', '.join(words)})" if words else ""]).strip()


def answer(subject: Subject, question: Question) -> None:
    """Put the case to the part; what it misses by what it declares is expected. Raises as a check does."""
    found = found_of(subject, question)
    if found.verdict in ("met", "ill-posed"):
        return
    if found.verdict == "not-applicable":
        raise NotApplicable(found.reason)
    said = f"{question.label}: {_told(found)}"
    cls = subject.part_class
    if (
        subject.kind == "contact"
        and issubclass(cls, Potential)
        and found.status == "refused"
        and "start" in found.reason
    ):
        raise NotApplicable(f"{said}; assumes bodies that are large compared with its clearance")
    why = _excuse(subject, question, found)
    if why:
        raise Expected(f"{said}; {why}")
    raise AssertionError(said)


def answer_evenly(subject: Subject, question: Question) -> None:
    """Put a patch test to sides that overlap to press: the stress is uniform, if lower than for touching sides."""
    case = _case(subject.registry, question)
    _, done = run_case(case, _setup(subject, case, question), subject.registry, work=WORK)
    for record in done.values():
        require(record.status == "finished", f"{question.label}: the run ended as {record.status}: {record.reason}")
        stress = np.concatenate([values.reshape(-1, values.shape[-1]) for values in record.stress.values()])
        spread = float(np.ptp(stress, axis=0).max() / np.abs(stress).max())
        most = EVEN_BY_A_LAW if half_passes(subject) else EVEN
        require(spread <= most, f"{question.label}: the stress varies by {spread:.3g} of the largest, allowed {most}")


def found_of(subject: Subject, question: Question) -> Finding:
    """The verdict of the case. Raises NotApplicable if it is not installed."""
    case = _case(subject.registry, question)
    setup = _setup(subject, case, question)
    why = unfit(case, setup, subject.registry)
    if why:
        raise NotApplicable(why)
    _, done = run_case(case, setup, subject.registry, work=WORK)
    if why := declined(setup, done):
        raise NotApplicable(why)
    return judge(case, setup, done, evaluated(case, setup, done))


def _case(registry: Registry, question: Question) -> Case:
    try:
        case: Case = registry.make("case", {"use": question.case, **question.fields})
    except RequestError as error:
        raise NotApplicable(f"the case {question.case} is not installed: pip install {PACKAGE}") from error
    return case


def _setup(subject: Subject, case: Case, question: Question) -> Setup:
    """The part in its place, usual parts of the case elsewhere."""
    element: Any = case.elements[min(question.element, len(case.elements) - 1)]
    if question.element:
        element = _quadratic(subject.registry, case)
    integrator: Any = case.integrators[0]
    if subject.kind == "contact":
        law = usual_law(subject.registry) if half_passes(subject) else ""
        return Setup(subject.spec, question.swap, element, integrator, enforcement=law)
    algorithm = usual_algorithm(subject.registry)
    if subject.kind == "element":
        return Setup(algorithm, question.swap, subject.spec, integrator)
    return Setup(algorithm, question.swap, element, subject.spec)


def _quadratic(registry: Registry, case: Case) -> Any:
    """The first element of the case with three nodes to a side."""
    for element in case.elements:
        if registry.make("element", element).degree > 1:
            return element
    raise NotApplicable("the case has no element with quadratic edges")


def _told(found: Finding) -> str:
    """Text of missed numbers with limits and reasons, or the end of the run."""
    bad = [j for j in found.judged if j.verdict not in ("met", "not-applicable") and j.value == j.value]
    if not bad:
        return f"the run ended as {found.status}: {found.reason}"
    lines: Iterator[str] = (
        f"{j.measure.name} is {j.value:.3g} {j.measure.unit}".strip()
        + f", allowed {allowed(j.measure)}: {j.measure.why}"
        for j in bad[:2]
    )
    return "; ".join(lines)


def _excuse(subject: Subject, question: Question, found: Finding) -> str:
    """Return the declaration that lets the part miss this case; empty without one."""
    if subject.kind != "contact":
        return ""
    cls = subject.part_class
    missed = [j.measure.name for j in found.judged if j.verdict != "met" and j.measure.role != "reported"]
    by_energy_alone = bool(missed) and all(ENERGY in name for name in missed)
    if not cls.keeps_energy and found.status == "finished" and by_energy_alone:
        return "keeps_energy is False"
    if half_passes(subject) and missed and all(WIDTH in name for name in missed):
        return "sides of half passes overlap as their law needs, which widens the contact"
    if not cls.passes_patch_test and question.case == "patch":
        return "passes_patch_test is False"
    if not cls.passes_patch_test and question.element:
        return "passes_patch_test is False, and quadratic edges enlarge the error"
    return ""
