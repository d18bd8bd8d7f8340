"""Folders for results: fresh ones by number, and never over results that are there."""

from __future__ import annotations

import contextlib
import json
import os
import re
from collections.abc import Iterable, Iterator
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
    "attempts",
)
OF_A_RUN = (
    "scene.toml", "summary.json", "history.csv", "iterations.csv", "contact.csv", "results.vtkhdf", "timeline.rrd",
    "last-steps", "crash.txt",
)  # fmt: skip
"""Files that a run writes into its folder."""
ATTEMPTS = "attempts"
"""Folder for results of integrators that did not get through."""
OF_A_BEGINNING = {"scene.toml", "history.csv", "summary.json"}
"""Files that a run may leave if it was killed before its first state was saved."""
WRITTEN = {
    ".toml", ".json", ".csv", ".txt", ".html", ".svg", ".png", ".pdf", ".gif", ".mp4", ".tex", ".vtkhdf", ".rrd",
    ".sqlite", ".new", ".packed", ".journal",
}  # fmt: skip
"""Endings of the files that results may consist of."""
BESIDE = ("runs", "last-steps", "finest", "chosen", "contact.csv", "iterations.csv", "crash.txt", "summary.json.new")
"""Files that may be written in addition to `RESULT_FILES`."""
HEADER = b"step,time,"
"""How `history.csv` begins."""


@contextmanager
def results_folder(out: Path | str | None, name: str, resume: bool = False) -> Iterator[Path]:
    """A folder to write results into: `out`, or the next free runs/NAME-NNN.

    It is removed again if it is still empty after an error. Raises RequestError if `out` has
    results (unless they are to be resumed) or cannot be a folder.
    """
    if out is not None and not str(out).strip():
        raise RequestError("no folder is named", where="--out", got=str(out), allowed="the name of a folder")
    if out is None and resume:
        found = sorted(RUNS.glob(f"{_plain(name)}-[0-9]*"))
        hint = f"--out {found[-1]}" if found else "omit --resume"
        raise RequestError("the folder of the run is needed", where="--resume", allowed="--out DIR", hint=hint)
    if out is None:
        folder = fresh_folder(name)
    else:
        folder = resumed_folder(Path(out)) if resume else claimed_folder(Path(out))
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
    """Return `folder`, created if necessary. Raises RequestError if it holds results."""
    try:
        found = [name for name in RESULT_FILES if os.path.lexists(folder / name)]
        anew = set(found) <= OF_A_BEGINNING and _has_only_begun(folder)
        _refuse_links(folder, [*RESULT_FILES, *BESIDE])
    except OSError as error:
        raise _unusable(folder, error) from error
    if anew:
        (folder / "summary.json").unlink(missing_ok=True)
    elif found:
        raise RequestError(
            "the folder holds results already",
            where=f"results folder {folder}",
            got=", ".join(found),
            allowed="a new or empty folder",
            hint="name another folder, or continue the run in it (--resume, in Python resume=True); without --out a "
            "new folder under runs/ is created",
        )
    return made_folder(folder)


def run_folder(out: Path | str | None, resume: bool) -> Path | None:
    """Return the folder that a run writes to: new or empty, or with `resume` the folder of an interrupted run."""
    if out is None:
        if resume:
            raise RequestError("a run can only be resumed in its folder", where="resume", allowed="a folder as out")
        return None
    folder = Path(out)
    if not resume:
        return claimed_folder(folder)
    over = [name for name in ("summary.json", "table.json") if (folder / name).exists()]
    if over == ["summary.json"] and _has_only_begun(folder):
        return claimed_folder(folder)
    if over and not (folder / "results.vtkhdf").exists():
        raise RequestError(
            "the folder holds no run that could be resumed",
            where=f"results folder {folder}",
            got=f"{over[0]} without results.vtkhdf",
            hint="omit record.recorders, or add vtkhdf to it",
        )
    return resumed_folder(folder)


def resumed_folder(folder: Path) -> Path:
    """`folder`, made if need be, with the results that are to be continued. Raises RequestError."""
    made_folder(folder)
    try:
        _refuse_links(folder, [p.name for p in folder.iterdir() if p.suffix in WRITTEN or p.name in BESIDE])
    except OSError as error:
        raise _unusable(folder, error) from error
    return folder


def _refuse_links(folder: Path, names: Iterable[str]) -> None:
    """Raise RequestError if one of these is a link: whoever made the folder could have us write anywhere."""
    for name in names:
        path = folder / name
        if path.is_symlink():
            raise RequestError(
                "a symbolic link has the name of a result file",
                where=f"results folder {folder}",
                got=f"{name} -> {path.readlink()}",
                allowed="the file itself, or nothing",
                hint="replace the link by the file, remove it, or name another folder",
            )


def _has_only_begun(folder: Path) -> bool:
    """Return whether a run began here and ended before it saved a state: it can begin again without loss.

    Its history then has the initial state at most, and its summary (of a full disk, or by `crash_watch`) no steps.
    """
    history, summary = folder / "history.csv", folder / "summary.json"
    if (folder / "results.vtkhdf").exists() or not (history.exists() or summary.exists()):
        return False
    with contextlib.suppress(FileNotFoundError), history.open("rb") as file:
        lines = file.readlines(1 << 20)
        if len(lines) > 2 or not b"".join(lines).startswith(HEADER[: len(lines) and len(lines[0])]):
            return False
    try:
        told = json.loads(summary.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return True
    except ValueError:
        return False
    return isinstance(told, dict) and told.get("status") == "failed" and told.get("steps", 0) == 0


@contextmanager
def full_disk_told(folder: Path, what: str) -> Iterator[None]:
    """Turn a disk that takes no more into a failure in one sentence; runs that are stored stay."""
    try:
        yield
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise SimulationFailure(
            "failed",
            f"{what} cannot be written to {folder}: {reason}; the runs stored so far are kept, and the same "
            "command with --resume writes the rest when there is space",
        ) from error


def made_folder(folder: Path) -> Path:
    """Return `folder`, created if necessary, whatever it holds. Raises RequestError if it cannot be a folder."""
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
