"""A page for each run of a study of cases: its scene, numbers, pressure, energy, and how to see its timeline."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from itertools import cycle
from pathlib import Path
from typing import Any

import bokeh
import numpy as np
from bokeh.embed import components

from contactlab.accuracy.point import Point
from contactlab.accuracy.run import Accuracy
from contactlab.api import Record
from contactlab.api.drawing.colours import STYLES
from contactlab.jobs.archive import FILE, Archive
from contactlab.jobs.system import machine
from contactlab.reports.accuracy_explore import Place, page_figure
from contactlab.reports.html import ASSETS, filled
from contactlab.reports.numbers import percent, significant
from contactlab.results.shown_pressure import shown_pressure

FOLDER = "runs"
LIBRARY = "bokeh.min.js"
TAIL = 200
"""Bytes at the end of a page that hold the key of its run."""
_PREFIX = "energy."
_COLOURS = tuple(style.colour for style in STYLES)


def write_run_pages(found: Accuracy, folder: Path) -> dict[Place, str]:
    """Write the pages that are missing, of all points whose runs the archive in `folder` has; gives where they are."""
    if not (folder / FILE).exists():
        return {}
    pages: dict[Place, str] = {}
    with Archive(folder / FILE, write=False) as archive:
        for point in found.points:
            if point.runs and (place := _page(archive, point, folder)):
                pages[point.case, point.contender, point.slave, point.level] = place
    return pages


def _page(archive: Archive, point: Point, folder: Path) -> str:
    """The page of a point's most expensive run, from the results folder; empty if the archive has no such run."""
    key = point.runs[-1]
    name = f"{point.case} {point.contender} {point.slave} {point.level}".replace(",", "").replace("/", "-")
    path = folder / FOLDER / f"{name.replace(' ', '_')}.html"
    where = f"{FOLDER}/{path.name}"
    if path.exists() and key in _tail(path):
        return where
    record, scene = archive.record(key, machine()), archive.scene(key, machine())
    if record is None:
        return ""
    path.parent.mkdir(exist_ok=True)
    if not (path.parent / LIBRARY).exists():
        shutil.copy(Path(bokeh.__file__).parent / "server" / "static" / "js" / LIBRARY, path.parent)
    path.with_suffix(".toml").write_text(scene, encoding="utf-8")
    plots = [each for each in (_pressure(record), _energy(record)) if each is not None]
    script, divisions = components(plots) if plots else ("", ())
    text = filled(
        "run.html", point=point, facts=_facts(point, record), scene=scene, file=path.with_suffix(".toml").name,
        library=LIBRARY, script=script, divisions=divisions, events=record.events, key=key,
        style=(ASSETS / "page.css").read_text(encoding="utf-8"),
    )  # fmt: skip
    path.write_text(text, encoding="utf-8")
    return where


def _tail(path: Path) -> str:
    """The end of a page, where its key stands."""
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - TAIL))
        return file.read().decode("utf-8", errors="replace")


def _facts(point: Point, record: Record) -> dict[str, str]:
    numbers = {name: value for name, value in record.summary.items() if isinstance(value, int | float)}
    return {
        "status": f"{point.status} {point.reason}".strip(),
        "error, %": percent(point.error, 3) if point.finished else "",
        "CPU time, s": significant(point.cost, 3),
        "memory, MiB": significant(point.memory_mib, 3),
        **{name.replace("_", " "): f"{value:.6g}" for name, value in numbers.items()},
    }


def _pressure(record: Record) -> Any:
    """The pressure of each contact at the end, over the position along it; None without contact."""
    found = [(name, curves[-1]) for name, curves in record.curves.items() if len(curves)]
    if not found:
        return None
    plot = _plot("contact pressure at the end", "position along the slave [mm]", "pressure [MPa]")
    for (name, curve), colour in zip(found, cycle(_COLOURS), strict=False):
        pressure = shown_pressure(curve)
        plot.line(curve.s, pressure, color=colour, line_width=1.5, legend_label=name)
        plot.scatter(curve.s, pressure, color=colour, size=4)
    return plot


def _energy(record: Record) -> Any:
    """Energies over time; None if fewer than two times were kept."""
    history: Mapping[str, Any] = record.history
    time = np.asarray(history.get("time", ()))
    kept = [name for name in history if name.startswith(_PREFIX) and np.any(history[name])]
    if len(time) < 2 or not kept:
        return None
    plot = _plot("energy", "time [s]", "energy [mJ per mm]")
    for name, colour in zip(kept, cycle(_COLOURS), strict=False):
        plot.line(
            time, np.asarray(history[name]), color=colour, legend_label=name.removeprefix(_PREFIX), line_width=1.5
        )
    return plot


def _plot(title: str, x: str, y: str) -> Any:
    return page_figure(
        title=title, x_axis_label=x, y_axis_label=y, height=340, tools="pan,wheel_zoom,box_zoom,reset,save,hover"
    )
