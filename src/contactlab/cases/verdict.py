"""Verdict on a cell of the matrix: met, missed, failed, silent ... and every number with its own verdict."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal

from contactlab.api import Case, Measure, Record, Setup
from contactlab.api.case import invariant, reported
from contactlab.results.invariants import Invariant


def invariants_of(done: Mapping[str, Record]) -> list[tuple[Measure, float]]:
    """The worst of each invariant over all runs and contacts of a cell, by what is allowed of it.

    A breach that a warning of its own code names is missed, and not silent.
    """
    worst: dict[str, Invariant] = {}
    for record in done.values():
        for data in record.summary.get("invariants", ()):
            one = Invariant.from_data(data)
            before = worst.get(one.name)
            if before is None or not _share(one) <= _share(before):
                worst[one.name] = one
    return [(_measure(one), one.value) for one in worst.values()]


def _share(one: Invariant) -> float:
    return one.value / one.limit if 0.0 < one.limit < math.inf else one.value


def _measure(one: Invariant) -> Measure:
    return invariant(one.name, one.limit, one.why, codes=(one.code,)) if one.limit < math.inf else reported(one.name)


Verdict = Literal["met", "missed", "failed", "silent", "not-judged", "ill-posed", "not-applicable"]

WORST: Final[tuple[Verdict, ...]] = (
    "silent", "failed", "missed", "not-judged", "ill-posed", "met", "not-applicable"
)  # fmt: skip
"""The worst first."""

SILENT_FROM = 3.0
"""Multiple of the error that a case allows: a finished run with a larger error and no warning is silent."""


@dataclass(frozen=True)
class Judged:
    """Measure with its value and verdict."""

    measure: Measure
    value: float
    verdict: Verdict


@dataclass(frozen=True)
class Finding:
    """Result of one cell: the worst of its measures, and the status of its runs."""

    verdict: Verdict
    status: str
    reason: str
    judged: tuple[Judged, ...]


def judge(case: Case, setup: Setup, done: Mapping[str, Record], values: Mapping[str, float]) -> Finding:
    """The verdict of a case on what its runs left."""
    status, reason = _end(done)
    codes = frozenset(code for record in done.values() for code in record.warnings)
    guarded = all(record.summary.get("guards", True) for record in done.values())
    judged = [
        Judged(
            measure,
            value,
            "not-applicable"
            if measure.answer is not None and measure.answer.refusal(setup.level)
            else verdict_of(measure, value, status, codes, guarded),
        )
        for measure in case.measures(setup)
        for value in (values.get(measure.name, math.nan),)
    ]
    if status == "finished":
        judged += [
            Judged(measure, value, verdict_of(measure, value, status, codes, guarded))
            for measure, value in invariants_of(done)
        ]
    impossible = case.ill_posed(setup)
    if impossible and status in ("not-converged", "refused"):
        return Finding("ill-posed", status, f"{impossible}; the run reports: {reason}", tuple(judged))
    if impossible and status == "finished" and (shown := _shown_to_have_no_limit(judged)):
        return Finding("ill-posed", status, f"{impossible}; {shown}", tuple(judged))
    own: list[Verdict] = [j.verdict for j in judged]
    if status != "finished":
        own.append("not-judged" if status == "timed-out" else "failed")
    return Finding(worst(own), status, reason or _told(judged), tuple(judged))


def verdict_of(
    measure: Measure, value: float, status: str, codes: frozenset[str] = frozenset(), guarded: bool = True
) -> Verdict:
    """Verdict on one measure. Missing values of unfinished runs fail, or are not judged after a time limit."""
    if status != "finished" and math.isnan(value):
        return "not-judged" if status == "timed-out" else "failed"
    if measure.met(value):
        return "met"
    warned = bool(codes & set(measure.codes))
    silent = measure.role == "invariant" or (
        measure.role == "error" and not SILENT_FROM * measure.least <= value <= SILENT_FROM * measure.most
    )
    if silent and status == "finished" and guarded and not warned:
        return "silent"
    return "missed"


def worst(verdicts: Sequence[Verdict]) -> Verdict:
    """The worst of several verdicts; met without any."""
    return min(verdicts, key=WORST.index, default="met")


def _end(done: Mapping[str, Record]) -> tuple[str, str]:
    """Return status and reason of the first run that did not finish."""
    for name, record in done.items():
        if not record.finished:
            told = f"{name}: " if len(done) > 1 else ""
            return record.status, told + record.reason
    return "finished", ""


def _shown_to_have_no_limit(judged: Sequence[Judged]) -> str:
    """The numbers of finished runs that show it, in words; empty without any, or if a number is off."""
    if any(j.verdict != "met" for j in judged):
        return ""
    return "; ".join(f"{j.measure.name}: {j.value:.4g}" for j in judged if j.measure.role == "no-limit")


def _told(judged: Sequence[Judged]) -> str:
    """Name the worst number that is not met, in words."""
    bad = [j for j in judged if j.verdict not in ("met", "not-applicable")]
    if not bad:
        return ""
    first = min(bad, key=lambda j: WORST.index(j.verdict))
    return f"{first.measure.name} is {first.value:.4g}, allowed {allowed(first.measure)}"


def allowed(measure: Measure) -> str:
    """Say in words which values of a measure are allowed."""
    if measure.role == "reported":
        return "anything"
    if measure.least == -measure.most:
        return f"within +-{measure.most:.4g}"
    if not math.isfinite(measure.least):
        return f"<= {measure.most:.4g}"
    return (
        f">= {measure.least:.4g}" if not math.isfinite(measure.most) else f"{measure.least:.5g} to {measure.most:.5g}"
    )
