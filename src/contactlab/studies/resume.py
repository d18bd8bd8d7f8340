"""Taking up a comparison that was stopped: runs that are over are read back, the others go on."""

from __future__ import annotations

import shlex
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from contactlab.errors import RequestError
from contactlab.run.restart import finished_results
from contactlab.studies.plan import Plan
from contactlab.studies.recordings import RUNS
from contactlab.studies.run_job import Outcome, costs_in, outcome_of


def stored_outcomes(plan: Plan, folder: Path) -> dict[str, Outcome]:
    """Outcomes of the runs in `folder` that are over, by job name.

    Raises RequestError where the folder holds something else than runs of this plan.
    """
    _check_runs(plan, folder)
    found = {}
    for job in plan.jobs:
        place = folder / RUNS / job.name
        results = finished_results(place, job.scene)
        if results is not None and len(costs_in(place, results)) >= plan.study.repeat:
            found[job.name] = outcome_of(results, plan.contact, costs_in(place, results))
    return found


def _check_runs(plan: Plan, folder: Path) -> None:
    """All runs that are there must be asked for: a comparison goes on as it began."""
    names = {job.name for job in plan.jobs}
    others = sorted(place.name for place in (folder / RUNS).glob("*") if place.name not in names)
    if others:
        raise RequestError(
            "the folder holds another comparison",
            where=f"results folder {folder}",
            got=f"runs {', '.join(others[:4])}",
            allowed=f"runs {', '.join(sorted(names)[:4])}{', ...' if len(names) > 4 else ''}",
            hint="repeat --vary, --set and --effects as they were, or name another folder",
        )


def resume_line(
    request: str,
    vary: list[str],
    settings: list[str],
    files: list[str],
    effects: bool,
    folder: Path,
    time_limit: float | None = None,
    repeat: int | None = None,
    reference: str | None = None,
    keep: str = "all",
) -> str:
    """Write the command that takes a comparison up again."""
    words = [word for text in vary for word in ("--vary", text)]
    words += [word for text in settings for word in ("--set", text)]
    words += [word for text in files for word in ("--with", text)]
    words += ["--effects"] if effects else []
    words += ["--time-limit", f"{time_limit:g}"] if time_limit is not None else []
    words += ["--repeat", str(repeat)] if repeat is not None else []
    words += ["--reference", reference] if reference is not None else []
    words += ["--keep", keep] if keep != "all" else []
    return shlex.join(["contactlab", "compare", request, *words, "--out", str(folder), "--resume"])


@contextmanager
def sigterm_as_ctrl_c() -> Iterator[None]:
    """While it is entered, SIGTERM raises KeyboardInterrupt, so that runs are stopped in order."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
