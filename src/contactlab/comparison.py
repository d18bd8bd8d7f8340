"""`contactlab.compare`: run a study, and write its tables, report and timeline."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Integral, Real
from pathlib import Path
from typing import Any

from contactlab.arguments import NAME, arguments
from contactlab.errors import RequestError
from contactlab.jobs.archive import StoredRow
from contactlab.jobs.driver import Driver
from contactlab.jobs.keys import row_key
from contactlab.jobs.rows import finite
from contactlab.jobs.scheduler import LOCAL, checked_scheduler
from contactlab.parts.registry import Registry, default_registry
from contactlab.reports.page import write_report
from contactlab.reports.progress import progress_of
from contactlab.results.last_steps_file import drop_last_steps
from contactlab.results.result_file import FILE
from contactlab.run.folders import claimed_folder, full_disk_told, made_folder
from contactlab.scene.scene import Scene
from contactlab.studies.plan import Vary
from contactlab.studies.recordings import RUNS
from contactlab.studies.runner import planned, run_study
from contactlab.studies.study import Study
from contactlab.studies.table import Row, Table


@arguments(
    scene_or_study=(Scene, Study, *NAME), vary=Mapping, out=NAME, jobs=Integral, registry=Registry, progress=bool,
    changes=Mapping, effects=bool, resume=bool, time_limit=Real, scheduler=str, repeat=Integral, reference=NAME,
    keep=str,
)  # fmt: skip
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
    jobs            runs at a time; one per core by default
    changes         scene keys and values for all runs, also instead of what the study varies
    progress        a progress display on standard error; by default if that is a terminal
    effects         instead of combinations, the scene without each of its effects in turn: `Table.breakdown`
    resume          continue in `out`: finished runs are kept, interrupted ones continued, damaged records made again
    time_limit      wall time of one run without compilation [s], instead of the study's own: a run over it is stopped,
                    and killed if it does not answer; a row "timed-out"
    repeat          runs of each combination, instead of the study's own; the costs are medians
    reference       reference of the pressures, instead of the study's own: a name, a JSON file, a CSV file
                    with columns x and p, or "finest": runs on meshes twice as fine as the finest compared
    keep            runs whose `results.vtkhdf` and recordings stay in `out`: "all", "failed" or "none";
                    an interrupted comparison keeps all, so that it can continue
    scheduler       "local", "dask" (a cluster on this machine) or tcp://HOST:PORT of a dask scheduler

    Each row goes into `archive.sqlite` in `out` as soon as its runs end.

    A run that fails, or whose process is killed, is a row with its status and reason.
    Raises RequestError when the request itself is wrong, and KeyboardInterrupt after Ctrl-C or SIGTERM,
    when all finished rows have been written. The first signal lets runs save their state, a second ends them.
    """
    checked_keep(keep)
    checked_scheduler(scheduler)
    plan = planned(scene_or_study, vary, registry, changes, effects, time_limit, repeat, reference)
    driver = Driver(None, jobs, scheduler, plan.study.time_limit)  # a wrong request makes no folder
    driver.folder = _folder(out, resume)
    driver.progress = progress_of(len(plan.jobs), progress)

    def kept(row: Row, scene: Scene, machine: str) -> None:
        if driver.archive is not None:
            driver.archive.add_row(_stored(row, scene, machine))

    with driver:
        table = run_study(plan, driver, kept, results_stay=keep == "all")
    if table.folder is not None:
        with full_disk_told(table.folder, "the report"):
            write_report(table, table.folder)
        if not table.interrupted:
            drop_files(table.folder, table.rows, keep, registry or default_registry())
    if table.interrupted:
        raise KeyboardInterrupt
    return table


def _folder(out: str | Path | None, resume: bool) -> Path | None:
    if out is None:
        if resume:
            raise RequestError("a comparison can only be resumed in its folder", where="resume", allowed="a folder")
        return None
    return made_folder(Path(out)) if resume else claimed_folder(Path(out))


def _stored(row: Row, scene: Scene, machine: str) -> StoredRow:
    ends = (row.algorithm, row.slave, row.level, row.status, row.reason)
    return StoredRow(row_key(scene, row.name), scene.name, row.name, *ends, finite(row.record()), scene.toml(), machine)


KEEP = ("all", "failed", "none")
"""Runs whose files are kept: all runs, runs that did not finish, none."""


def checked_keep(keep: str) -> str:
    """Return a member of `KEEP`. Raises RequestError for another word."""
    if keep not in KEEP:
        raise RequestError("there is no such choice", where="keep", got=keep, allowed=", ".join(KEEP))
    return keep


def drop_files(folder: Path, rows: Sequence[Row], keep: str, registry: Registry) -> None:
    """Remove results and recordings of the runs that are not kept; the small text files of all runs stay.

    The recording of the comparison has its runs in it, and stays as well.
    """
    shown = (registry.part_class("recorder", name).shown_file for name in registry.names("recorder"))
    large = {FILE, *filter(None, shown)}
    for row in rows:
        if keep == "none" or (keep == "failed" and row.status == "finished"):
            for name in large:
                (folder / RUNS / row.name / name).unlink(missing_ok=True)
            drop_last_steps(folder / RUNS / row.name)
