"""Convergence of Newton's iteration of the step at the cursor: residuals over iterations, rejected steps included."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

import numpy as np
import rerun as rr

from contactlab.api.drawing.colours import rgb
from contactlab.api.frame import IterationRow
from contactlab_rerun.axes import Axes, dashed
from contactlab_rerun.gathered import Appearance, Gathered
from contactlab_rerun.projection import line_strips
from contactlab_rerun.timelines import TIMELINE, times

PATH = "/axes/newton"
DASHES = 3  # between two iterations
FLOOR = 1e-17  # residuals below it are drawn there


def log_convergence(recording: rr.RecordingStream, runs: Sequence[tuple[Gathered, Appearance]], hang: float) -> bool:
    """The plot for all runs that iterate; False if none does."""
    found = [(run.iterations, appearance) for run, appearance in runs if run.iterations]
    if not found:
        return False
    shown = [rows for rows, _ in found]
    values = np.array([_power(value) for rows in shown for row in rows for value in (row.force, row.contact)])
    most = max(len(list(rows)) for run in shown for _, rows in groupby(run, key=lambda row: row.step))
    axes = Axes(
        PATH, 0.0, float(max(2, most)), float(np.floor(values.min())), float(np.ceil(values.max() + 1e-9)), hang
    )
    powers = range(int(axes.low), int(axes.high) + 1, 2 if axes.high - axes.low < 12 else 4)
    numbers = range(0, int(axes.x1) + 1, max(1, int(axes.x1) // 5))
    axes.log(
        recording,
        ("iteration of the step", "residual"),
        [(float(n), str(n)) for n in numbers if n],
        [(float(power), f"1e{power}") for power in powers],
    )
    for rows, appearance in found:
        _log_run(recording, axes, rows, appearance, rgb(appearance.colour))
    return True


def _log_run(
    recording: rr.RecordingStream,
    axes: Axes,
    rows: Sequence[IterationRow],
    appearance: Appearance,
    colour: tuple[int, ...],
) -> None:
    steps = [list(of_step) for _, of_step in groupby(rows, key=lambda row: row.step)]
    when = times([of_step[0].step for of_step in steps], [of_step[-1].time + of_step[-1].dt for of_step in steps])
    # while one walks through the iterations of a step it is the plot of that step
    begins = 1 + np.cumsum([0, *(len(of_step) for of_step in steps[:-1])])
    when.append(rr.TimeColumn(TIMELINE, sequence=begins))
    for name in ("force", "contact"):
        points, lengths, counts = [], [], []
        for of_step in steps:
            strips = _strips(axes, of_step, name)
            points += strips
            lengths += [len(strip) for strip in strips]
            counts.append(len(strips))
        lines = line_strips(np.concatenate(points), lengths)
        path = f"{appearance.path}/convergence/{name}"
        recording.send_columns(path, when, rr.LineStrips3D.columns(strips=lines).partition(counts))
        recording.log(path, rr.LineStrips3D.from_fields(colors=[colour], radii=[-1.3]), static=True)


def _strips(axes: Axes, rows: Sequence[IterationRow], name: str) -> list[np.ndarray]:
    """A line for each attempt of a step, in pieces if it is dashed; attempts follow one another."""
    strips: list[np.ndarray] = []
    begin = 0
    for _, attempt in groupby(rows, key=lambda row: row.attempt):
        values = [_power(getattr(row, name)) for row in attempt]
        x = np.arange(begin + 1.0, begin + len(values) + 1.0)
        begin += len(values)
        if len(values) == 1:  # a line needs two points
            x, values = np.array([x[0] - 0.1, x[0] + 0.1]), 2 * values
        if name == "force":
            strips.append(axes.points(x, np.array(values)))
        else:
            strips += list(axes.points(*dashed(x, np.array(values), DASHES * (len(values) - 1))).reshape(-1, 2, 3))
    return strips


def _power(residual: float) -> float:
    return float(np.log10(max(residual, FLOOR))) if np.isfinite(residual) else 0.0
