"""Folders for results: fresh ones by number, and never over results that are there."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from contactlab.errors import RequestError, SimulationFailure

RUNS = Path("runs")
LONGEST_NAME = 80  # characters of a scene's name that name its folder
RESULT_FILES = (
    "scene.toml",
    "summary.json",
    "history.csv",
    "results.vtkhdf",
    "timeline.rrd",
    "table.json",
    "table.csv",
    "matrix.csv",
    "archive.sqlite",
)


@contextmanager
def results_folder(out: Path | str | None, name: str, resume: bool = False) -> Iterator[Path]:
    """A folder to write results into: `out`, or the next free runs/NAME-NNN.

    It is taken away again if it is still empty after an error. Raises RequestError where `out` has
    results (unless they are to be resumed) or cannot be a folder.
    """
    if out is not None and not str(out).strip():
        raise RequestError("no folder is named", where="--out", got=str(out), allowed="the name of a folder")
    if out is None and resume:
        found = sorted(RUNS.glob(f"{_plain(name)}-[0-9]*"))
        hint = f"--out {found[-1]}" if found else "leave --resume away"
        raise RequestError("the folder of the run is needed", where="--resume", allowed="--out DIR", hint=hint)
    if out is None:
        folder = fresh_folder(name)
    else:
        folder = made_folder(Path(out)) if resume else claimed_folder(Path(out))
    try:
        yield folder
    except BaseException:
        with contextlib.suppress(OSError):
            folder.rmdir()
        raise


def fresh_folder(name: str) -> Path:
    """The next free runs/NAME-NNN, made now so that nobody else takes it."""
    number = 1
    while True:
        folder = RUNS / f"{_plain(name)}-{number:03d}"
        try:
            folder.mkdir(parents=True)
        except FileExistsError:
            number += 1
        except OSError as error:
            raise _unusable(folder, error) from error
        else:
            return folder


def _plain(name: str) -> str:
    return re.sub(r"[^\w.+-]+", "-", name)[:LONGEST_NAME].strip("-.") or "scene"


def claimed_folder(folder: Path) -> Path:
    """`folder`, made if need be. Raises RequestError where it holds results."""
    try:
        found = [name for name in RESULT_FILES if (folder / name).exists()]
    except OSError as error:
        raise _unusable(folder, error) from error
    if found:
        raise RequestError(
            "the folder holds results already",
            where=f"results folder {folder}",
            got=", ".join(found),
            allowed="a new or empty folder",
            hint="name another folder, or add --resume to go on with what is there; without --out a fresh one under "
            "runs/ is taken",
        )
    return made_folder(folder)


def run_folder(out: Path | str | None, resume: bool) -> Path | None:
    """The folder that a run writes to: a new or empty one, or with `resume` also that of an interrupted run."""
    if out is None:
        if resume:
            raise RequestError("a run can only be taken up in its folder", where="resume", allowed="a folder as out")
        return None
    folder = Path(out)
    if not resume:
        return claimed_folder(folder)
    over = [name for name in ("summary.json", "table.json") if (folder / name).exists()]
    if over and not list(folder.glob("results.vtkhdf*")):
        raise RequestError(
            "the folder holds no run that could be taken up",
            where=f"results folder {folder}",
            got=f"{over[0]} without results.vtkhdf",
            hint="leave record.recorders away, or name vtkhdf there",
        )
    return made_folder(folder)


@contextmanager
def full_disk_told(folder: Path, what: str) -> Iterator[None]:
    """Turn a disk that takes no more into a failure in one sentence; runs that are stored stay."""
    try:
        yield
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise SimulationFailure(
            "failed",
            f"{what} cannot be written to {folder}: {reason}; the runs that were stored are kept, and the same "
            "command with --resume writes the rest when there is room",
        ) from error


def made_folder(folder: Path) -> Path:
    """`folder`, made if need be, whatever it holds. Raises RequestError where it cannot be a folder."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:  # ValueError: NUL in the name
        raise _unusable(folder, error) from error
    return folder


def _unusable(folder: Path, error: OSError | ValueError) -> RequestError:
    reason = (getattr(error, "strerror", None) or str(error)).lower()
    return RequestError(
        f"no results can be written here: {reason}", where=f"results folder {folder}", allowed="a folder"
    )
