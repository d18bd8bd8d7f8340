"""Gaps and slips over the arc length of a slave surface: a height is a power of ten, negative ones are below zero."""

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

DECADES = {"gap": 8, "slip": 6}  # below the largest length: smaller ones are drawn at zero


def log_lengths(
    recording: rr.RecordingStream, pressure: Profile, runs: Sequence[tuple[str, Gathered, Appearance]], what: str
) -> Profile | None:
    """Plot the gap, or the slip in a step, next to the pressure; None if there are no such lengths.

    It has curves of all `runs`, each with the name of its contact. Slips belong to recorded steps.
    """
    curves = [_curves(pressure.axes, run, name, what) for name, run, _ in runs]
    known = [lengths[np.isfinite(lengths)] for _, _, lengths in curves]
    largest = _largest(runs[0], what, known)
    if not largest:
        return None
    least = 10.0 ** (round(np.log10(largest)) - DECADES[what])
    every = np.concatenate([heights(lengths, least) for lengths in known])
    high, low = np.ceil(every.max(initial=1.0)), np.floor(every.min(initial=0.0))
    axes = replace(pressure.axes, path=f"{pressure.axes.path}-{what}", low=float(low), high=float(high))
    profile = replace(pressure, axes=axes, what=what, folder=f"{what}-along")
    # every other power of ten on either side of zero
    powers = [*range(-int(axes.high) // 2 * 2, 0, 2), *range(2, int(axes.high) + 1, 2)]
    inside = sorted({power for power in powers if axes.low <= power <= axes.high})
    first = round(np.log10(least))
    ticks = [(0.0, "0"), *((float(p), f"{'-' if p < 0 else ''}1e{first + abs(p)}") for p in inside)]
    log_axes(recording, profile, f"{what}{in_brackets(pressure.units.length)}", ticks, runs)
    for (name, run, appearance), (shown, s, lengths) in zip(runs, curves, strict=True):
        path = f"{appearance.path}/{profile.folder}/{name}/{what}"
        there = np.isfinite(lengths)
        points = axes.points(np.broadcast_to(s, lengths.shape)[there], heights(lengths[there], least))
        lines = line_strips(points, there.sum(axis=1))
        when = frame_times(run, shown.step.tolist(), shown.time.tolist())
        recording.send_columns(path, when, rr.LineStrips3D.columns(strips=lines).partition([1] * len(lengths)))
        recording.log(path, rr.LineStrips3D.from_fields(colors=[rgb(appearance.colour)], radii=[-1.3]), static=True)
    return profile


def _largest(first: tuple[str, Gathered, Appearance], what: str, known: Sequence[np.ndarray]) -> float:
    """Reference length for the scale: the segments of the first run's slave for gaps, else the largest length."""
    name, run, _ = first
    if what == "gap":
        return segment_length(run, next(contact for contact in run.layout.contacts if contact.name == name))
    return max(float(np.abs(lengths).max(initial=0.0)) for lengths in known)


def _curves(axes: Axes, run: Gathered, contact: str, what: str) -> tuple[Curves, np.ndarray, np.ndarray]:
    """Instants, arc lengths (k,) within the axes and lengths (n, k) there, NaN where unknown."""
    order = along_surface(axes, run.surfaces[contact])
    shown = curves_of(run, contact, len(order))
    return shown, run.surfaces[contact].s[order], np.asarray(getattr(shown, what)[:, order], np.float64)
