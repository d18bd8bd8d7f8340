"""`contactlab compare` for a study of cases: what accuracy costs in time."""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from time import monotonic

from contactlab.accuracy.evaluation import Evaluation, evaluate
from contactlab.accuracy.files import write
from contactlab.accuracy.run import Accuracy, plan, points_of, run_accuracy
from contactlab.accuracy.study import CaseStudy
from contactlab.commands.common import console, print_json, registry_with
from contactlab.commands.many import folder_of, interrupted, many
from contactlab.errors import RequestError
from contactlab.studies.study import check_repeat


def compare_accuracy(study: CaseStudy, options: argparse.Namespace) -> int:
    """Run the study, write its tables and page, and print the costs; failed points are results."""
    _refuse_others(options)
    registry = registry_with(options.files)
    study = _asked(study, options)
    _, lines = plan(study, registry)  # a wrong name is reported before a folder is made
    name = options.scene.removesuffix(".toml").rpartition("/")[2]
    with many(options, name, points_of(lines)) as driver:
        folder = folder_of(driver)
        driver.meanwhile = import_what_draws
        found = run_accuracy(study, registry, driver, SoFar(folder))
    evaluated = evaluate(found)
    write_all(evaluated, folder)
    if options.json:
        print_json({"folder": str(folder), **json.loads((folder / "accuracy.json").read_text(encoding="utf-8"))})
    else:
        from contactlab.reports.accuracy_tables import NOTES, costs_sheet, winners_sheet

        out = console()
        out.print(costs_sheet(found, evaluated.costs))
        out.print(NOTES, highlight=False)
        out.print(winners_sheet(evaluated.winners))
        out.say(f"page: {folder / 'accuracy.html'}")
    if found.interrupted:
        return interrupted(options, folder)
    return 0 if any(point.finished for point in found.points) else 1


def _asked(study: CaseStudy, options: argparse.Namespace) -> CaseStudy:
    """The study as the options change it."""
    if options.quick:
        study = study.quickened()
    if options.repeat is None:
        return study
    check_repeat(options.repeat, "--repeat")
    return replace(study, repeat=options.repeat, short=math.inf)


def _refuse_others(options: argparse.Namespace) -> None:
    for name, given in (
        ("--vary", options.vary),
        ("--set", options.settings),
        ("--effects", options.effects),
        ("--reference", options.reference),
    ):
        if given:
            raise RequestError(
                "a study of cases is not varied from the command line", where=name,
                hint="copy the study into your own file and change its cases, contenders or levels",
            )  # fmt: skip


LEAST = 3.0
"""Wall time [s] from one writing of the page to the next, at least."""
SHARE = 0.05
"""Largest share of the time that is spent on writing it."""


def import_what_draws() -> None:
    """Libraries that draw the page: seconds if Python has not compiled them yet, for which no point should wait."""
    import_module("contactlab.reports.accuracy_page")


def write_all(evaluated: Evaluation, folder: Path, figures: bool = True) -> None:
    """Tables as CSV and JSON, the page, and its `figures` as files of their own."""
    from contactlab.reports.accuracy_page import write_accuracy_page

    write(evaluated, folder)
    write_accuracy_page(evaluated, folder, files=figures)


class SoFar:
    """Rewrites the page of a study while points come, unless that was done shortly before."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.next = 0.0

    def __call__(self, found: Callable[[], Accuracy]) -> None:
        """Write what there is."""
        began = monotonic()
        if began < self.next:
            return
        write_all(evaluate(found()), self.folder, figures=False)
        if not self.next:
            print(
                f"page so far, rewritten as points come: {self.folder / 'accuracy.html'}", file=sys.stderr, flush=True
            )
        now = monotonic()
        self.next = now + max(LEAST, (now - began) / SHARE)
