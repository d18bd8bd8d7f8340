"""`contactlab.compare`: run a study, and write its tables, report and timeline."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from contactlab.archive.rows import RowKeeper
from contactlab.parts.registry import Registry, default_registry
from contactlab.reports.page import write_report
from contactlab.reports.progress import progress_bars
from contactlab.run.folders import full_disk_told
from contactlab.scene.scene import Scene
from contactlab.studies.finest import make_finest
from contactlab.studies.kept_files import checked_keep, drop_files
from contactlab.studies.plan import Vary
from contactlab.studies.runner import run_study
from contactlab.studies.scheduler import LOCAL
from contactlab.studies.study import Study
from contactlab.studies.table import Table


def compare(
    scene_or_study: Scene | Study | str | Path,
    vary: Vary | None = None,
    out: str | Path | None = None,
    jobs: int | None = None,
    registry: Registry | None = None,
    progress: bool | None = None,
    changes: Mapping[str, Any] | None = None,
    effects: bool = False,
    resume: bool = False,
    time_limit: float | None = None,
    scheduler: str = LOCAL,
    repeat: int | None = None,
    reference: str | None = None,
    keep: str = "all",
) -> Table:
    """Run every combination and measure accuracy against cost.

    scene_or_study  a scene, a study, the name of a bundled one, or a TOML file of either
    vary            scene keys and lists of values, instead of the study's own
    out             folder for `table.csv`, `table.json`, plots, `report.html` and the runs; none: no files
    jobs            processes at a time; all cores by default
    changes         scene keys and values for all runs, also instead of what the study varies
    progress        bars on standard error; by default where that is a terminal
    effects         instead of combinations, the scene with each of its effects taken out in turn: `Table.breakdown`
    resume          go on with the comparison in `out`: runs that are over are read back, the others go on
    time_limit      wall time that one run may take [s], instead of the study's own: a run over it is stopped, and
                    killed where it does not answer; a row "timed-out"
    repeat          runs of each combination, instead of the study's own; the costs are medians
    reference       what pressures are measured against, instead of the study's own: a name, a JSON file, a CSV file
                    with columns x and p, or "finest": runs on meshes twice as fine as the finest compared
    keep            whose `results.vtkhdf` and recordings stay in `out`: "all" runs', of those that "failed", or "none";
                    a comparison that was interrupted keeps all, so that it can go on
    scheduler       "local", "dask" (a cluster on this machine) or tcp://HOST:PORT of a dask scheduler

    Each row goes into `archive.sqlite` in `out` as soon as its run is over.

    A run that fails, or whose process is killed, is a row with its status and reason.
    Raises RequestError when the request itself is wrong, and KeyboardInterrupt after Ctrl-C or SIGTERM,
    when what there is has been written. The first one lets runs save their state, a second one ends them at once.
    """
    checked_keep(keep)
    bars = partial(progress_bars, show=progress)
    with RowKeeper(out) as rows:
        table = run_study(
            scene_or_study, vary, out, jobs, registry, bars, changes, effects, resume, time_limit, scheduler, rows.keep,
            repeat, reference, make_finest, results_stay=keep == "all",
        )  # fmt: skip
    if table.folder is not None:
        with full_disk_told(table.folder, "the report"):
            write_report(table, table.folder)
        if not table.interrupted:
            drop_files(table.folder, table.rows, keep, registry or default_registry())
    if table.interrupted:
        raise KeyboardInterrupt
    return table
