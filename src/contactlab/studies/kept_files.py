"""Which runs of a comparison keep what their recorders wrote."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from contactlab.errors import RequestError
from contactlab.parts.registry import Registry
from contactlab.results.last_steps_file import drop_last_steps
from contactlab.results.result_file import FILE
from contactlab.studies.recordings import RUNS
from contactlab.studies.table import Row

KEEP = ("all", "failed", "none")
"""Whose files are kept: of all runs, of those that did not finish, of none."""


def checked_keep(keep: str) -> str:
    """One of `KEEP`. Raises RequestError for another word."""
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
