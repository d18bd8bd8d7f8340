"""Messages about a damaged `results.vtkhdf`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from contactlab.api.frame import Layout
from contactlab.errors import RequestError, one_line
from contactlab.results.checksums import Damage, broken_seals
from contactlab.results.frame_sums import StoredSums
from contactlab.results.result_file import FILE

BROKEN = (
    Damage, OSError, LookupError, ValueError, TypeError, AttributeError, RuntimeError, MemoryError, OverflowError,
)  # fmt: skip
"""Errors of reading a damaged file: our checksums, HDF5's, and errors from wrong headers."""

TABLES = "history.csv, contact.csv and summary.json in its folder are text and can be read without it"


@contextmanager
def damage_told(folder: Path) -> Iterator[None]:
    """Turn whatever a damaged file raises into one RequestError that says what can still be read."""
    try:
        yield
    except BROKEN as problem:
        raise RequestError(
            f"the file is damaged: {one_line(problem)}", where=str(folder / FILE), hint=_what_is_left(folder)
        ) from problem


def _what_is_left(folder: Path) -> str:
    from contactlab.results.load import load_results

    try:
        left = load_results(folder, salvage=True)
    except RequestError:
        return f"none of its content can be read; {TABLES}"
    state = f", its state at step {left.summary.get('steps')}" if left.restartable else ""
    return (
        f"contactlab.load_results(folder, salvage=True) gives the undamaged data: {len(left.frames)} frames, "
        f"{left.step_count} steps{state}; not {', '.join(left.lost) or 'the data named here'}; {TABLES}"
    )


def whole_frames(file: Any, layout: Layout, sums: StoredSums, count: int) -> list[int]:
    """Numbers of the frames of which every array is as it was written."""
    return [number for number in range(count) if _is_whole(file, layout, sums, number)]


def _is_whole(file: Any, layout: Layout, sums: StoredSums, number: int) -> bool:
    try:
        return all(sums.holds(number, name, _slab(file, layout, name, number)) for name in sums.place)
    except BROKEN:
        return False


def _slab(file: Any, layout: Layout, name: str, number: int) -> np.ndarray:
    """Read array `name` of one frame, as it was written."""
    grid, own = file["VTKHDF"], file["contactlab"]
    if name == "history":
        return np.asarray(own["history"][number])
    if name.startswith("curves of "):
        return np.asarray(own[f"contacts/{name.removeprefix('curves of ')}/curves"][number])
    if name == "points":
        table = grid["Points"]
    else:
        table = grid["PointData"][name] if name in grid["PointData"] else grid["CellData"][name]
    at_points = name == "points" or name in grid["PointData"]
    height = len(layout.nodes) if at_points else sum(len(body.cells) for body in layout.bodies)
    return np.asarray(table[number * height : (number + 1) * height])


def check_all(file: Any, layout: Layout, frames: int) -> None:
    """Raise Damage if anything of the first frames, or stored once, is not as it was written."""
    if broken := broken_seals(file):
        raise Damage(f"{', '.join(broken)} {'is' if len(broken) == 1 else 'are'} damaged")
    if frames:
        whole = whole_frames(file, layout, StoredSums(file["contactlab"]), frames)
        lost = sorted(set(range(frames)) - set(whole))
        if lost:
            raise Damage(f"{len(lost)} of {frames} frames are damaged, starting with number {lost[0]}")
