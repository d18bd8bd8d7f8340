"""`contactlab compare`: every combination of a study, accuracy against cost."""

from __future__ import annotations

import argparse
import json

from contactlab.commands.common import console, parse_settings, print_how_to_look, print_json, registry_with
from contactlab.commands.interruption import INTERRUPTED
from contactlab.errors import RequestError, SceneError, did_you_mean
from contactlab.run.folders import results_folder


def compare(options: argparse.Namespace) -> int:
    """Run the combinations and print their table; failed rows are results: the status is 0 unless all failed."""
    from contactlab.accuracy.study import bundled_case_studies, find_case_study

    cases = find_case_study(options.scene)
    if cases is not None:
        from contactlab.commands.accuracy import compare_accuracy

        return compare_accuracy(cases, options)
    if options.quick:
        raise RequestError(
            "only a study of cases has a quick form", where="--quick", got=options.scene, allowed="accuracy"
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
    from contactlab.reports.breakdown_table import print_breakdown
    from contactlab.reports.table import print_table
    from contactlab.studies.resume import resume_line
    from contactlab.studies.study import parse_vary

    registry = registry_with(options.files)
    vary = parse_vary(options.vary) if options.vary else None
    changes = parse_settings(options.settings)
    name = options.scene.removesuffix(".toml").rpartition("/")[2]
    with results_folder(options.out, name, options.resume) as folder:
        try:
            result = run_all(
                options.scene, vary, out=folder, jobs=options.jobs, registry=registry, changes=changes, progress=True,
                effects=options.effects, resume=options.resume, time_limit=options.time_limit,
                scheduler=options.scheduler, repeat=options.repeat,
                reference=options.reference,
                keep=options.keep,
            )  # fmt: skip
        except KeyboardInterrupt:
            line = resume_line(
                options.scene,
                options.vary,
                options.settings,
                options.files,
                options.effects,
                folder,
                options.time_limit,
                options.repeat,
                options.reference,
                options.keep,
            )
            console().print(f"interrupted; go on with: {line}", markup=False, highlight=False, soft_wrap=True)
            return INTERRUPTED
    if options.json:
        print_json({"folder": str(folder), **json.loads((folder / "table.json").read_text(encoding="utf-8"))})
        return 0 if any(row.complete for row in result.rows) else 1
    shown = console()
    (print_table if result.breakdown is None else print_breakdown)(result, shown)
    shown.print(f"report: {folder / 'report.html'}", markup=False, highlight=False, soft_wrap=True)
    print_how_to_look(folder, registry, shown)
    return 0 if any(row.complete for row in result.rows) else 1
