"""All checks of a part: unit checks, scenarios with cases, and the cost of a call."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field
from typing import Any

from contactlab.api import ContactMethod, Potential
from contactlab.errors import PartError, SceneError, one_line
from contactlab.parts.declared_values import declared
from contactlab.testing.cost import Cost, costs
from contactlab.testing.examples import refused
from contactlab.testing.fields_in_use import unused_fields
from contactlab.testing.run import Outcome, checks_for, run_check
from contactlab.testing.scenarios import scenarios_for
from contactlab.testing.subject import Subject

FATAL = {"pieces_keep_their_bounds"}
"""Checks without which no other is made: compiled code that writes outside its arrays would spoil this process."""

Told = Callable[[Subject, Outcome], None]
"""Function called after each check."""


@dataclass(frozen=True)
class PartReport:
    """The results of one part; `tags` are its declarations."""

    kind: str
    name: str
    origin: str
    target: str
    outcomes: tuple[Outcome, ...]
    costs: tuple[Cost, ...] = ()
    tags: dict[str, Any] = field(default_factory=dict)
    cpu_s: float = 0.0

    def count(self, status: str) -> int:
        """Number of checks with this result."""
        return sum(outcome.status == status for outcome in self.outcomes)

    @property
    def right(self) -> bool:
        """Return whether something was checked and nothing failed."""
        return self.count("passed") > 0 and not self.count("failed")


def check_names(kind: str) -> list[str]:
    """Names of all checks of a part of this kind, in order; for contacts also the checks of potentials."""
    own = (*checks_for(kind), *(checks_for(kind, Potential) if kind == "contact" else ()))
    return list(dict.fromkeys(check.__name__ for check in (*FIRST, *own, *scenarios_for(kind))))


def check_part(
    subject: Subject, told: Told | None = None, until_failure: bool = False, only: Collection[str] = ()
) -> PartReport:
    """Run every check of one part, or the checks in `only`; with `until_failure` stop at the first that fails."""
    began, outcomes = time.process_time(), []
    for outcome in _outcomes(subject, only):
        outcomes.append(outcome)
        if told is not None:
            told(subject, outcome)
        if until_failure and outcome.status == "failed":
            break
    right = all(outcome.status != "failed" for outcome in outcomes)
    found = costs(subject) if right and not until_failure and not only else []
    offer = subject.offer
    return PartReport(
        subject.kind, subject.name, str(offer.origin), offer.part.target, tuple(outcomes), tuple(found),
        _tags(subject), time.process_time() - began,
    )  # fmt: skip


def _outcomes(subject: Subject, only: Collection[str]) -> Iterator[Outcome]:
    first = run_check(keeps_the_contract, subject)
    yield first
    if first.status != "passed":
        return
    fatal = False
    checks = checks_for(subject.kind, subject.part_class)
    wanted = {*only, *FATAL} if only else {*check_names(subject.kind)}
    used = run_check(fields_are_used, subject)
    failed = used.status == "failed"
    yield from [used] if used.check in wanted else []
    for check in checks:
        if check.__name__ not in wanted:
            continue
        if fatal:
            says = " ".join((check.__doc__ or "").split())
            yield Outcome(check.__name__, says, "not applicable", "skipped: a check on which all others depend failed")
            continue
        # a new instance; of two half passes the algorithm of each
        part = subject.make()
        outcome = run_check(check, (part.half_pass() or part) if isinstance(part, ContactMethod) else part)
        fatal = outcome.status == "failed" and check.__name__ in FATAL
        failed |= outcome.status == "failed"
        yield outcome
    for scenario in scenarios_for(subject.kind):
        if scenario.__name__ not in wanted:
            continue
        if failed:
            says = " ".join((scenario.__doc__ or "").split())
            why = "skipped: unit checks failed, and whole runs would show that less clearly"
            yield Outcome(scenario.__name__, says, "not applicable", why)
        else:
            yield run_check(scenario, subject)


def keeps_the_contract(subject: Subject) -> None:
    """The part is a class of its kind with all members of the contract, and can be made from usual values."""
    try:
        subject.part_class  # noqa: B018 - raises if it is not a class of the kind
        subject.make()
    except PartError as error:
        cause = error.__cause__
        problem = cause.problem if isinstance(cause, PartError) else error.problem
        raise AssertionError(problem) from error
    except SceneError as error:
        if guessed := subject.guessed:
            raise refused(guessed, one_line(error)) from error
        raise


def fields_are_used(subject: Subject) -> None:
    """Every field is named by some code of the part: otherwise scenes set it in vain."""
    unused = unused_fields(subject.part_class)
    if unused:
        raise AssertionError(f"the part does not use its field {', '.join(unused)}; use the field or remove it")


FIRST = (keeps_the_contract, fields_are_used)
"""Checks of the class, whatever its kind."""


def _tags(subject: Subject) -> dict[str, Any]:
    """Declarations of the class beyond data: its plain class attributes, by name."""
    try:
        cls = subject.part_class
    except PartError:
        return {}
    found = {name: getattr(cls, name, None) for name in declared(cls)}
    return {name: value for name, value in found.items() if isinstance(value, bool | int | str) and value != ""}
