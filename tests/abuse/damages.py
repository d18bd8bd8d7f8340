"""Random damage to stored files: bits that flip, blocks that are lost, ends that are missing."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import numpy as np

import contactlab
from contactlab.errors import RequestError
from contactlab.results.results import Results

KINDS = ("a bit", "a byte", "eight bytes", "zeros", "noise", "a page", "a swap", "truncated")


def damage(path: Path, chance: random.Random) -> str:
    """Change the file in one random way; gives the way in words."""
    data = bytearray(path.read_bytes())
    kind, size = chance.choice(KINDS), len(data)
    at = chance.randrange(size)
    if kind == "a bit":
        data[at] ^= 1 << chance.randrange(8)
    elif kind == "truncated":
        del data[at:]
    elif kind == "a swap":
        other, length = chance.randrange(size), chance.choice((8, 512))
        a, b = data[at : at + length], data[other : other + length]
        if len(a) == len(b) == length and abs(at - other) >= length:
            data[at : at + length], data[other : other + length] = b, a
    else:
        length = min({"a byte": 1, "eight bytes": 8, "zeros": 64, "noise": 64, "a page": 4096}[kind], size - at)
        zeros = kind in ("zeros", "a page")
        data[at : at + length] = bytes(length) if zeros else chance.randbytes(length)
    path.write_bytes(bytes(data))
    return f"{kind} at {at} of {size}"


def everything(folder: Path) -> dict[str, Any]:
    """All that can be read back of a run."""
    results = contactlab.load_results(folder)
    for name in ("cost", "resumed_at_steps"):  # they differ between any two runs
        results.summary.pop(name, None)
    steps = {name: values for name, values in results.steps.items() if not name.startswith("cost.")}
    return {"results": results, "frames": list(results.frames), "steps": steps}


def same(a: dict[str, Any], b: dict[str, Any]) -> bool:
    """Whether two runs were read back alike, to the last bit."""
    frames = zip(a["frames"], b["frames"], strict=False)
    return (
        a["results"].summary == b["results"].summary
        and _same_columns(a["steps"], b["steps"])
        and _same_columns(a["results"].history, b["results"].history)
        and np.array_equal(a["results"].displacement, b["results"].displacement)
        and np.array_equal(a["results"].velocity, b["results"].velocity)
        and list(a["results"].events) == list(b["results"].events)
        and list(a["results"].iterations) == list(b["results"].iterations)
        and len(a["frames"]) == len(b["frames"])
        and all(_same_frame(one, other) for one, other in frames)
    )


def _same_columns(a: dict[str, Any], b: dict[str, Any]) -> bool:
    return a.keys() == b.keys() and all(np.array_equal(values, b[name], equal_nan=True) for name, values in a.items())


def _same_frame(a: Any, b: Any) -> bool:
    fields = all(
        np.array_equal(a.cells[body][name], b.cells[body][name], equal_nan=True)
        for body in a.cells
        for name in a.cells[body]
    )
    moved = np.array_equal(a.displacement, b.displacement) and np.array_equal(a.velocity, b.velocity)
    return fields and moved and a.time == b.time and a.scalars == b.scalars and a.curves == b.curves


def outcome(folder: Path, whole: dict[str, Any]) -> str:
    """What reading a damaged run comes to: "as before", "told", "told, some salvaged", or what is wrong."""
    try:
        return "as before" if same(everything(folder), whole) else "other numbers in silence"
    except RequestError as error:
        if len(str(error).splitlines()) < 2:
            return f"told without what can be read: {error}"
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    try:
        left = contactlab.load_results(folder, salvage=True)
    except RequestError:
        return "told"
    except Exception as error:
        return f"salvage: {type(error).__name__}: {error}"
    return "told, some salvaged" if _part_of(left, whole) else "salvage gave other numbers"


def _part_of(left: Results, whole: dict[str, Any]) -> bool:
    """Whether all that was salvaged is as it was."""
    by_number = {frame.number: frame for frame in whole["frames"]}
    frames = all(_same_frame(frame, by_number[frame.number]) for frame in left.frames)
    steps = whole["steps"]["step"].tolist()
    rows = {step: row for row, step in enumerate(steps)}
    at = [rows[step] for step in left.steps.get("step", np.zeros(0)).tolist()]
    columns = all(
        np.array_equal(values, whole["steps"][name][at], equal_nan=True)
        for name, values in left.steps.items()
        if name in whole["steps"]
    )
    return frames and columns
