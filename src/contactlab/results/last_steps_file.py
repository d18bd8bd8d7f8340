"""File with all fields of the last steps before a failure or a warning, in a folder below the run's.

It is a `results.vtkhdf` like the run's file, with a frame for every step: the same readers read it.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from contactlab.api.frame import Frame, Layout
from contactlab.api.recorder import FAILURE, WARNING
from contactlab.errors import RequestError
from contactlab.results.result_file import FILE

LAST = "last-steps"


@contextmanager
def last_steps_folder(run: Path, end: str) -> Iterator[Path]:
    """An empty folder that is moved below the folder of the run when everything is in it."""
    place, present = run / LAST / end, run / LAST / f"{end}.new"
    shutil.rmtree(present, ignore_errors=True)
    present.mkdir(parents=True)
    try:
        yield present
    except BaseException:
        shutil.rmtree(present, ignore_errors=True)
        raise
    shutil.rmtree(place, ignore_errors=True)
    present.replace(place)


def has_last_steps(run: Path, end: str) -> bool:
    """Return whether the last steps before `end` are stored."""
    return (run / LAST / end / FILE).is_file()


def drop_last_steps(run: Path, end: str = "") -> None:
    """Remove the last steps before `end`, or all of them."""
    shutil.rmtree(run / LAST / end, ignore_errors=True)


def stored_last_steps(run: Path) -> Mapping[str, Sequence[Frame]]:
    """The frames of the last steps, by what they came before; what cannot be read is left out."""
    from contactlab.results.load import load_results

    found: dict[str, Sequence[Frame]] = {}
    for end in (FAILURE, WARNING):
        if has_last_steps(run, end):
            try:
                found[end] = load_results(run / LAST / end).frames
            except RequestError:
                continue
    return found


def excerpt(layout: Layout, end: str, frames: Sequence[Frame]) -> dict[str, Any]:
    """The summary of such a file."""
    said = {FAILURE: "a run failed", WARNING: "a guard warned for the first time"}[end]
    return {
        "format": 1,
        "scene": layout.title,
        "status": "interrupted",
        "reason": f"steps {frames[0].step} to {frames[-1].step}, before {said}",
        "parts": dict(layout.parts),
        "versions": dict(layout.versions),
        "steps": frames[-1].step,
    }
