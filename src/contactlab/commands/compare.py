"""`contactlab compare`: every combination of a study, accuracy against cost."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from contactlab.commands.common import console, parse_settings, print_how_to_look, print_json, registry_with
from contactlab.commands.many import interrupted
from contactlab.errors import RequestError, SceneError, did_you_mean, visible
from contactlab.parts.registry import Registry
from contactlab.run.folders import results_folder
from contactlab.studies.study import parse_vary
from contactlab.studies.table import Table


def compare(options: argparse.Namespace) -> int:
    """Run the combinations and print their table; failed rows are results: the status is 1 if no run finished."""
    from contactlab.accuracy.study import bundled_case_studies, find_case_study

    cases = find_case_study(options.scene)
    if cases is not None:
        from contactlab.commands.accuracy import compare_accuracy

        return compare_accuracy(cases, options)
    if options.quick:
        raise RequestError(
            "only a study of cases has a quick version", where="--quick", got=options.scene, allowed="accuracy"
        )
    try:
        return _compare_scene(options)
    except SceneError as error:
        studies = bundled_case_studies()
        if error.where != options.scene:  # something inside of it is wrong
            raise
        allowed = f"{error.allowed}; or a study of cases: {', '.join(studies)}"
        hint = did_you_mean(options.scene, studies) or error.hint
        raise RequestError(error.problem, where=error.where, got=error.got, allowed=allowed, hint=hint) from error


def _compare_scene(options: argparse.Namespace) -> int:
    """Compare the runs of one scene."""
    from contactlab.comparison import compare as run_all
    from contactlab.reports.table import failed_alike, failure

    registry = registry_with(options.files)
    vary = parse_vary(options.vary) if options.vary else None
    changes = parse_settings(options.settings)
    name = options.scene.removesuffix(".toml").rpartition("/")[2]
    with results_folder(options.out, name, options.resume) as folder:
        try:
            result = run_all(
                options.scene, vary, out=folder, jobs=options.jobs, registry=registry, changes=changes,
                progress=not options.quiet,
                effects=options.effects, resume=options.resume, time_limit=options.time_limit,
                scheduler=options.scheduler, repeat=options.repeat,
                reference=options.reference,
                keep=options.keep,
            )  # fmt: skip
        except KeyboardInterrupt:
            return interrupted(options, folder)
    status = 0 if any(row.finished for row in result.rows) else 1
    if options.json:
        print_json({"folder": str(folder), **json.loads((folder / "table.json").read_text(encoding="utf-8"))})
    elif options.quiet:
        for rows in failed_alike(result):
            print(visible(f"contactlab: {failure(rows)}"), file=sys.stderr)
    else:
        _print(result, folder, registry, options)
    return status


def _print(result: Table, folder: Path, registry: Registry, options: argparse.Namespace) -> None:
    from contactlab.reports.breakdown_table import render_breakdown
    from contactlab.reports.table import every_number, render, times_sheet

    shown = console()
    shown.print(render(result) if result.breakdown is None else render_breakdown(result.breakdown, result.study.name))
    if options.verbose:
        shown.print(every_number(result, shown.width))
    if options.profile:
        shown.print(times_sheet(result))
    shown.say(f"report: {folder / 'report.html'}")
    print_how_to_look(folder, registry, shown)
