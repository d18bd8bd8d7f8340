"""`contactlab plot`: pictures of a run or of a comparison."""

from __future__ import annotations

import argparse
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from contactlab.commands.common import console
from contactlab.errors import RequestError, did_you_mean
from contactlab.results.load import load_results
from contactlab.results.result_file import FILE
from contactlab.results.results import Results

STILL = (".png", ".svg", ".pdf")
MOVING = (".gif", ".mp4")
MOST = 6
"""Runs of a comparison in one picture of bodies."""

FRAMES_PER_SECOND = 12
DPI = 160


def plot(options: argparse.Namespace) -> int:
    """Write the picture and print its name."""
    folder = Path(options.path)
    moving = options.what == "animation"
    if not folder.is_dir():
        raise RequestError("there is no such folder", where="plot", got=str(folder), allowed="the folder of a run")
    file = _file(options.out, folder / f"{options.what}{'.gif' if moving else '.png'}", MOVING if moving else STILL)
    if (folder / "table.json").is_file():
        drawn = _of_comparison(folder, options)
    else:
        if options.runs:
            raise RequestError("--runs needs a comparison", where="--runs", got=str(folder), allowed="its folder")
        drawn = _of_run(load_results(folder), options)
    if moving:
        from contactlab.reports.figures import house_style

        writer = "ffmpeg" if file.suffix.lower() == ".mp4" else "pillow"
        with house_style():
            drawn.save(file, writer=writer, fps=FRAMES_PER_SECOND, dpi=100)
    else:
        drawn.savefig(file, **({"dpi": DPI} if file.suffix.lower() == ".png" else {}))
    console().say(f"{options.what}: {file}")
    return 0


def _file(out: str | None, default: Path, allowed: tuple[str, ...]) -> Path:
    """Path to write to. Raises RequestError for another kind of file, or if it cannot be written."""
    file = default if out is None else Path(out)
    suffix = file.suffix.lower()
    if suffix not in allowed:
        raise RequestError(
            "unsupported type of file", where="--out", got=str(file),
            allowed=f"a name that ends in {', '.join(allowed)}",
        )  # fmt: skip
    if suffix == ".mp4" and shutil.which("ffmpeg") is None:
        raise RequestError(
            "mp4 files need the program ffmpeg, which is not installed", where="--out", got=str(file),
            allowed="a name that ends in .gif", hint="install ffmpeg (apt-get install ffmpeg), or write a gif",
        )  # fmt: skip
    if not file.resolve().parent.is_dir():
        raise RequestError("there is no such folder", where="--out", got=str(file.parent), allowed="an existing folder")
    return file


def _of_run(run: Results, options: argparse.Namespace) -> Any:
    flat, field = options.flat, options.field
    drawings: Mapping[str, Callable[[], Any]] = {
        "force": lambda: run.plot_force(options.on or "", options.component or ""),
        "pressure": lambda: run.plot_pressure(options.on or ""),
        "stress": lambda: run.plot(field, _frame(options), flat=flat),
        "animation": lambda: run.animate(field, options.stride, flat=flat),
    }
    return drawings[options.what]()


def _of_comparison(folder: Path, options: argparse.Namespace) -> Any:
    from dataclasses import replace

    from contactlab.studies.load_table import load_table

    table = load_table(folder)
    names = [row.name for row in table.main]
    for name in options.runs:
        if name not in [row.name for row in table.rows]:
            raise RequestError("no such run", where="--runs", got=name, allowed=", ".join(names),
                               hint=did_you_mean(name, names))  # fmt: skip
    if options.runs:
        table = replace(table, rows=[row for row in table.rows if row.name in options.runs])
    if options.what == "force":
        return table.plot_force(options.on or "", options.component or "")
    if options.what == "pressure":
        return table.plot_pressures()
    return _bodies(folder, [row.name for row in table.main] or options.runs, options)


def _bodies(folder: Path, names: list[str], options: argparse.Namespace) -> Any:
    """Bodies of several runs side by side."""
    from contactlab.reports.notebook.pictures import fields_animation, fields_figure
    from contactlab.studies.recordings import runs_of, titled_runs

    found = runs_of(folder, names)
    runs = dict(list(titled_runs(found).items())[:MOST])
    if not runs:
        raise RequestError("no run of the comparison kept its results", where=str(folder), allowed=f"runs with {FILE}",
                           hint="compare with --keep all")  # fmt: skip
    if len(found) > MOST:
        line = f"showing the first {MOST} of {len(found)} runs; choose others by --runs NAME ..."
        console().say(line)
    if options.what == "stress":
        return fields_figure(runs, options.field, _frame(options), options.flat)
    return fields_animation(runs, options.field, options.stride, options.flat)


def _frame(options: argparse.Namespace) -> int:
    return -1 if options.frame is None else int(options.frame)
