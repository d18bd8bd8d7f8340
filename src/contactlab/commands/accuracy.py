"""`contactlab compare` for a study of cases: what accuracy costs in time."""

from __future__ import annotations

import argparse
import json
import math
from dataclasses import replace

from contactlab.accuracy.evaluation import evaluate
from contactlab.accuracy.run import plan, points_of, run_accuracy
from contactlab.accuracy.study import CaseStudy
from contactlab.commands.accuracy_progress import SoFar, import_what_draws, write_all
from contactlab.commands.common import console, print_json, registry_with
from contactlab.commands.many import folder_of, interrupted, many
from contactlab.errors import RequestError
from contactlab.studies.study import MOST_RUNS


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
        from contactlab.reports.accuracy_predictions import told
        from contactlab.reports.accuracy_table import print_costs, print_winners

        out = console()
        print_costs(found, evaluated.costs, out)
        print_winners(found, evaluated.winners, out)
        if evaluated.predictions:
            out.print(f"predicted from coarser meshes: {told(evaluated.predictions)}", markup=False, highlight=False)
        out.print(f"page: {folder / 'accuracy.html'}", markup=False, highlight=False, soft_wrap=True)
    if found.interrupted:
        return interrupted(folder)
    return 0 if any(point.finished for point in found.points) else 1


def _asked(study: CaseStudy, options: argparse.Namespace) -> CaseStudy:
    """The study as the options change it."""
    if options.quick:
        study = study.quickened()
    if options.repeat is None:
        return study
    if options.repeat > MOST_RUNS:
        raise RequestError("no such number of runs", where="--repeat", got=options.repeat, allowed=f"1 to {MOST_RUNS}")
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
                hint="copy the study into a file of your own and change its cases, contenders or levels",
            )  # fmt: skip
