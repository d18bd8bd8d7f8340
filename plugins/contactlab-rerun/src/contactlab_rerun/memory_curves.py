"""Plots of the memory of contact laws along the slave surface, with a curve for every frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import rerun as rr

from contactlab.api.drawing.colours import rgb
from contactlab_rerun.axes import solid_columns, ticks
from contactlab_rerun.gathered import Appearance, Gathered, nice
from contactlab_rerun.profiles import Profile, along_surface, log_axes
from contactlab_rerun.timelines import frame_times

Runs = Sequence[tuple[str, Gathered, Appearance]]


def log_memories(recording: rr.RecordingStream, pressure: Profile, runs: Runs) -> list[Profile]:
    """Make a plot for each name, next to the pressure plot, with the curves of all `runs` that remember it.

    Each of the `runs` has the name of its contact.
    """
    names = dict.fromkeys(what for name, run, _ in runs for what in run.instants[0].curves[name].memory)
    return [
        _log(recording, pressure, [r for r in runs if what in r[1].instants[0].curves[r[0]].memory], what)
        for what in names
    ]


def _log(recording: rr.RecordingStream, pressure: Profile, runs: Runs, what: str) -> Profile:
    orders = [along_surface(pressure.axes, run.surfaces[name]) for name, run, _ in runs]
    curves = [
        np.array([instant.curves[name].memory[what][order] for instant in run.instants])
        for (name, run, _), order in zip(runs, orders, strict=True)
    ]
    high, low = (
        max(float(some.max(initial=0.0)) for some in curves),
        min(float(some.min(initial=0.0)) for some in curves),
    )
    high, low = nice(high) if high > 0.0 or low == 0.0 else 0.0, -nice(-low) if low < 0.0 else 0.0
    axes = replace(pressure.axes, path=f"{pressure.axes.path}-memory-{what}", low=low, high=high)
    profile = replace(pressure, axes=axes, what=what.replace("_", " "), folder=f"memory-{what}-along")
    log_axes(recording, profile, profile.what, ticks(low, high), runs)
    for (name, run, appearance), order, some in zip(runs, orders, curves, strict=True):
        path = f"{appearance.path}/{profile.folder}/{name}/{what}"
        s = run.surfaces[name].s[order]
        when = frame_times(run, [instant.step for instant in run.instants], [instant.time for instant in run.instants])
        recording.send_columns(path, when, solid_columns(axes.points(np.broadcast_to(s, some.shape), some)))
        recording.log(path, rr.LineStrips3D.from_fields(colors=[rgb(appearance.colour)], radii=[-1.3]), static=True)
    return profile
