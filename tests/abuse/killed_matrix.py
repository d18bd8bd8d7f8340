"""A matrix that is killed again and again: resumed to its end, its archive is that of an undisturbed one.

    python tests/abuse/killed_matrix.py                        # 20 kills, 12 cases against all algorithms
    python tests/abuse/killed_matrix.py --kills 3 patch stack  # fewer

Twice undisturbed first: both must agree in every verdict and every run. Then the same matrix is killed with all of its
processes, by SIGKILL, at moments spread over its runs, each a random time after one was kept; and taken up
each time. In the end every run and every cell must be those of the first, times apart. Exit status 1 where not.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import json
import os
import random
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from contactlab.jobs.archive import CHOICES, FILE
from contactlab.jobs.record import from_bytes

CASES = (
    "patch", "pulled-block", "two-bars", "vertex-to-vertex", "shrink-fit", "dropped-block", "pressed-block",
    "westergaard", "two-rings", "incompressible", "rough-plate", "stack",
)  # fmt: skip
COMMAND = [sys.executable, "-c", "import sys; from contactlab.cli import main; sys.exit(main(sys.argv[1:]))", "matrix"]
TIMES = ("cost", "versions", "system", "machine")
"""Of a summary: what may differ between two equal runs."""


def started(cases: list[str], folder: Path) -> subprocess.Popen[bytes]:
    """The matrix in a process of its own, which takes up what is in the folder."""
    words = [*COMMAND, *cases, "--jobs", "1", "--out", str(folder), "--resume"]
    return subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)


def finished(cases: list[str], folder: Path) -> float:
    """Wall seconds to its end; the matrix must end well."""
    began = time.monotonic()
    status = started(cases, folder).wait()
    assert status == 0, f"the matrix in {folder} ended with {status}"
    return time.monotonic() - began


def killed(process: subprocess.Popen[bytes]) -> None:
    """End it and what it has started at once; only these."""
    children = _children(process.pid)
    for pid in (process.pid, *children):
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    process.wait()


def _children(pid: int) -> list[int]:
    path = Path(f"/proc/{pid}/task/{pid}/children")
    own = [int(word) for word in path.read_text().split()] if path.exists() else []
    return own + [grandchild for child in own for grandchild in _children(child)]


def count(folder: Path) -> int:
    """Runs that are kept."""
    try:
        with sqlite3.connect(f"file:{folder / FILE}?mode=ro", uri=True) as file:
            return int(file.execute("select count(*) from runs").fetchone()[0])
    except sqlite3.Error:
        return 0


def disturbed(cases: list[str], folder: Path, kills: int, runs: int, seconds: float, chance: random.Random) -> int:
    """Kill it so often, and let it end; gives back how many kills met a matrix that was at work."""
    met = 0
    for number in range(kills):
        process, wanted = started(cases, folder), round(runs * number / kills)
        while process.poll() is None and count(folder) < wanted:
            time.sleep(0.02)
        time.sleep(chance.uniform(0.0, 3.0 * seconds / runs))
        met += process.poll() is None
        killed(process)
    finished(cases, folder)
    return met


def contents(folder: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Runs and cells by their keys, times apart."""
    with sqlite3.connect(folder / FILE) as file:
        found = file.execute("select key, name, scene, status, reason, work, record from runs").fetchall()
        columns = ", ".join(f'"{name}"' for name in CHOICES)
        cells = file.execute(f"select key, {columns}, verdict, status, reason, measures, runs from cells").fetchall()
    return {row[0]: (*row[1:6], _plain(row[6])) for row in found}, {row[0]: row[1:] for row in cells}


def _plain(record: bytes) -> str:
    """All of a record but times, as text."""
    read = from_bytes(record)
    summary = {name: value for name, value in read.summary.items() if name not in TIMES}
    parts = (read.history, read.times, read.watched, read.stress, read.cells, read.curves)
    arrays = (read.nodes, read.displacement, read.velocity)
    return json.dumps([summary, _texts(parts), _texts(arrays)], sort_keys=True, default=str)


def _texts(value: Any) -> Any:
    """Arrays as their bytes, so that equal means equal in every bit."""
    if isinstance(value, np.ndarray):
        return [str(value.dtype), list(value.shape), value.tobytes().hex()]
    if isinstance(value, dict):
        return {str(name): _texts(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_texts(item) for item in value]
    return _texts(vars(value)) if hasattr(value, "__dict__") else value


def verdicts(folder: Path) -> list[tuple[str, ...]]:
    """Every row of matrix.csv without its times."""
    with (folder / "matrix.csv").open(newline="") as file:
        return [tuple(v for name, v in row.items() if name != "cpu_s") for row in csv.DictReader(file)]


def differences(one: Path, other: Path) -> list[str]:
    """What of two folders is not the same, in words."""
    found = []
    for what, a, b in zip(("run", "cell"), contents(one), contents(other), strict=True):
        for key in sorted({*a, *b}):
            if a.get(key) != b.get(key):
                how = "differs" if key in a and key in b else "is in one alone"
                found.append(f"{what} {(a.get(key) or b.get(key))[0]} ({key}) {how}")
    return found + ([] if verdicts(one) == verdicts(other) else ["matrix.csv differs"])


def main(words: list[str]) -> int:
    """Measure, print, and say whether all is the same."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("cases", nargs="*", default=list(CASES))
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(words)
    with TemporaryDirectory() as place:
        first, second, third = (Path(place, name) for name in ("first", "second", "killed"))
        for folder in (first, second):
            seconds = finished(options.cases, folder)
        again = differences(first, second)
        runs, cells = (len(found) for found in contents(first))
        print(f"undisturbed: {runs} runs, {cells} cells, {seconds:.0f} s; twice: {len(again)} differences", flush=True)
        met = disturbed(options.cases, third, options.kills, runs, seconds, random.Random(options.seed))
        found = differences(first, third)
        print(f"killed {options.kills} times, {met} of them at work: {len(found)} differences", flush=True)
    for line in again + found:
        print(line)
    return 1 if again or found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
