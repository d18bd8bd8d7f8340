"""The gap over the arc length of a slave surface: a height is a power of ten, overlap is below the zero line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import rerun as rr

from contactlab.api.drawing.colours import rgb
from contactlab_rerun.axes import Axes
from contactlab_rerun.decades import heights, segment_length
from contactlab_rerun.gathered import Appearance, Gathered
from contactlab_rerun.profiles import Curves, Profile, along_surface, curves_of, in_brackets, log_axes
from contactlab_rerun.projection import line_strips
from contactlab_rerun.timelines import frame_times

FOLDER = "gap-along"
MOST_POINTS = 8000  # of the curves of a run, beside its frames and last steps: pictures have all steps
DECADES = 8  # below the length of a segment: smaller gaps are drawn at zero


def log_gaps(
    recording: rr.RecordingStream, pressure: Profile, runs: Sequence[tuple[str, Gathered, Appearance]]
) -> Profile:
    """The plot beside that of the pressure, with curves of all `runs`, each with the name of its contact."""
    curves = [_curves(pressure.axes, run, name) for name, run, _ in runs]
    first = next(contact for contact in runs[0][1].layout.contacts if contact.name == runs[0][0])
    least = 10.0 ** (round(np.log10(segment_length(runs[0][1], first))) - DECADES)
    every = np.concatenate([heights(gaps[np.isfinite(gaps)], least) for _, _, gaps in curves])
    high, low = np.ceil(every.max(initial=1.0)), np.floor(every.min(initial=0.0))
    axes = replace(pressure.axes, path=f"{pressure.axes.path}-gap", low=float(low), high=float(high))
    profile = replace(pressure, axes=axes, what="gap", folder=FOLDER)
    log_axes(recording, profile, f"gap{in_brackets(pressure.units.length)}", _ticks(axes, least), runs)
    for (name, run, appearance), (shown, s, gaps) in zip(runs, curves, strict=True):
        path = f"{appearance.path}/{FOLDER}/{name}/gap"
        covered = np.isfinite(gaps)
        points = axes.points(np.broadcast_to(s, gaps.shape)[covered], heights(gaps[covered], least))
        lines = line_strips(points, covered.sum(axis=1))
        when = frame_times(run, shown.step.tolist(), shown.time.tolist())
        recording.send_columns(path, when, rr.LineStrips3D.columns(strips=lines).partition([1] * len(gaps)))
        recording.log(path, rr.LineStrips3D.from_fields(colors=[rgb(appearance.colour)], radii=[-1.3]), static=True)
    return profile


def _curves(axes: Axes, run: Gathered, contact: str) -> tuple[Curves, np.ndarray, np.ndarray]:
    """Instants, arc lengths (k,) within the axes and gaps (n, k) there."""
    order = along_surface(axes, run.surfaces[contact])
    shown = curves_of(run, contact, len(order), MOST_POINTS)
    return shown, run.surfaces[contact].s[order], np.asarray(shown.gap[:, order], np.float64)


def _ticks(axes: Axes, least: float) -> list[tuple[float, str]]:
    """Every other power of ten on either side of zero."""
    powers = [*range(-int(axes.high) // 2 * 2, 0, 2), *range(2, int(axes.high) + 1, 2)]
    there = sorted({power for power in powers if axes.low <= power <= axes.high})
    first = round(np.log10(least))
    return [(0.0, "0"), *((float(p), f"{'-' if p < 0 else ''}1e{first + abs(p)}") for p in there)]
