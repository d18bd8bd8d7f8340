"""`contactlab check`: is a part right?"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path

from contactlab.api.formulas import formulas_of
from contactlab.commands.common import console, parse_settings
from contactlab.errors import RequestError, did_you_mean
from contactlab.reports.sheet import Column, Sheet
from contactlab.testing.card import as_data, write_cards
from contactlab.testing.check_part import PartReport, check_names, check_part
from contactlab.testing.find import subjects
from contactlab.testing.formula_lines import FormulaLines
from contactlab.testing.run import Outcome, checks_for
from contactlab.testing.scenarios.cases import PACKAGE
from contactlab.testing.subject import Subject

LABELS = {"expected": "expected to fail"}  # a failure that the part declares, such as a failed patch test
WITHOUT_CASES = f"no cases are installed, so benchmarks with known solutions are skipped: pip install {PACKAGE}"


def check(options: argparse.Namespace) -> int:
    """Check every part that is meant and show what came out; exit status 1 if anything failed."""
    parts = subjects(options.target, options.kind, options.files, parse_settings(options.settings))
    only = _named(options.only, parts)
    if only and options.card:
        raise RequestError("a card needs all checks", where="--card", got="--only", allowed="one of them")
    if options.python and (options.json or options.card):
        raise RequestError("--python runs the unit checks only", where="--python", got="--json or --card")
    if options.python:
        return _checked_in_python(parts, only)
    reports = _checked(parts, only, quiet=options.json)
    if options.card:
        write_cards(reports, Path(options.card))
    if options.json:
        print(json.dumps(as_data(reports), indent=1))
    else:
        for report in reports:
            show(report)
        _print_end(reports, cases=bool(parts[0].registry.names("case")), card=options.card)
    return 0 if all(report.right for report in reports) else 1


def _named(names: Sequence[str], parts: Sequence[Subject]) -> list[str]:
    """Checks by their names, as they are shown or as functions. Raises RequestError for a name that no part has."""
    known = list(dict.fromkeys(name for part in parts for name in check_names(part.kind)))
    found = [name.strip().replace(" ", "_") for name in names]
    for name in found:
        if name not in known:
            raise RequestError(
                "there is no such check", where="--only", got=name, allowed=", ".join(known),
                hint=did_you_mean(name, known),
            )  # fmt: skip
    return found


def _checked(parts: Sequence[Subject], only: Sequence[str], quiet: bool) -> list[PartReport]:
    out = console()
    shown = nullcontext() if quiet or not out.is_terminal else out.status("checking")
    with shown as status:

        def told(subject: Subject, outcome: Outcome) -> None:
            if status is not None:
                status.update(f"{subject.kind} {subject.name}: {outcome.check.replace('_', ' ')}")

        return [check_part(subject, told, only=only) for subject in parts]


def _checked_in_python(parts: Sequence[Subject], only: Sequence[str]) -> int:
    """Unit checks of parts with formulas, uncompiled: what came out, and which lines of the formulas ran."""
    with FormulaLines() as lines:
        parts = [part for part in parts if formulas_of(part.part_class)]
        if not parts:
            hint = "omit the option: all but formulas and kernels is plain Python anyway"
            raise RequestError("none of these parts has formulas", where="--python", hint=hint)
        for part in parts:
            lines.watch(part.part_class)
        units = [check.__name__ for part in parts for check in checks_for(part.kind)]
        reports = _checked(parts, only or units, quiet=False)
    for part, report in zip(parts, reports, strict=True):
        show(report)
        rows = (
            [one.name, one.share, f"{one.file}: {', '.join(map(str, one.missed))}" if one.missed else ""]
            for one in lines.of(part.part_class)
        )
        heads = [Column(name, keep=True) for name in ("formula", "lines that ran", "lines that did not")]
        console().print(Sheet(heads, rows, f"{report.kind} {report.name}"))
    _print_end(reports, cases=True, card=None)
    return 0 if all(report.right for report in reports) else 1


def show(report: PartReport) -> None:
    """Print one part: a row for each check, then what a call costs."""
    out = console()
    heads = Column("check", keep=True), Column("outcome", whole=True, keep=True), "why"
    rows = (
        [outcome.check.replace("_", " "), LABELS.get(outcome.status, outcome.status), _why(outcome)]
        for outcome in report.outcomes
    )
    out.print(Sheet(heads, rows, f"{report.kind} {report.name}, from {report.origin}"))
    if report.costs:
        own = report.costs[0]
        prices = (
            [cost.name, f"{cost.microseconds:.4g}", f"{cost.microseconds / own.microseconds:.2g}"]
            for cost in report.costs
        )
        out.print(Sheet(("part", "CPU time [us]", "times this one"), prices, own.of))


def _why(outcome: Outcome) -> str:
    """Return the outcome in words; for a failed check its purpose comes first."""
    if outcome.status == "failed":
        return f"{outcome.says}\n{outcome.reason}"
    return f"told: {outcome.reason}" if outcome.status == "passed" and outcome.reason else outcome.reason


def _print_end(reports: Sequence[PartReport], cases: bool, card: str | None) -> None:
    out = console()
    if not cases:
        out.print(WITHOUT_CASES, markup=False, highlight=False)
    for report in reports:
        counts = ", ".join(
            f"{report.count(status)} {LABELS.get(status, status)}"
            for status in ("passed", "failed", "expected", "not applicable")
        )
        out.print(f"{report.kind} {report.name}: {counts}; {report.cpu_s:.1f} CPU s", markup=False, highlight=False)
    if card:
        out.print(f"card: {Path(card, 'card.md')}", markup=False, highlight=False)
