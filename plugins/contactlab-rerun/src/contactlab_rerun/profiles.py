"""Pressure and shear over the arc length of a slave surface, at every frame and at recorded steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr

from contactlab.api.arrays import Floats
from contactlab.api.drawing.colours import rgb
from contactlab.api.drawing.units import Units
from contactlab.api.frame import ContactLayout
from contactlab_rerun.axes import Axes, dashed, dashed_columns, log_legend, solid_columns, ticks
from contactlab_rerun.gathered import Appearance, Gathered, Surface, nice
from contactlab_rerun.timelines import frame_times

MARGIN = 0.08  # of what is ever pressed, on both sides
MOST_POINTS = 1000  # of the curves of a run, in addition to its frames and last steps: pictures have all steps
LAST = 50  # steps before the end whose curves are always there


@dataclass(frozen=True)
class Profile:
    """A plot that several runs share: the slave surface, what is shown along it, and the folder of a run's curves."""

    axes: Axes
    slave: str
    what: str
    units: Units
    folder: str = "profile"


def profile_of(contact: ContactLayout, runs: Sequence[tuple[str, Gathered]], path: str, hang: float) -> Profile:
    """Axes for one slave surface in all `runs` that have it, each with the name of its contact."""
    surfaces = [run.surfaces[name] for name, run in runs]
    s = surfaces[0].s
    pressed = np.concatenate([surface.s[surface.state.any(axis=0)] for surface in surfaces])
    s0, s1 = (pressed.min(), pressed.max()) if len(pressed) else (s.min(), s.max())
    margin = max(MARGIN * (s1 - s0), 2.0 * np.diff(np.sort(s)).max(initial=0.0))
    frictional = any(c.friction for name, run in runs for c in run.layout.contacts if c.name == name)
    values = [values for surface in surfaces for values in (surface.pressure, surface.shear)]
    values += [run.records[name][what] for name, run in runs for what in run.records_of(name)]
    high = nice(max(float(part.max(initial=0.0)) for part in values))
    low = min(float(part.min(initial=0.0)) for part in values)
    low = -nice(-low) if low < -0.01 * high else 0.0
    what = "pressure (solid) and shear (dashed)" if frictional else "pressure"
    axes = Axes(path, max(s.min(), s0 - margin), min(s.max(), s1 + margin), low, high, hang)
    return Profile(axes, contact.slave, what, Units.of_label(runs[0][1].layout.units))


def log_profile(
    recording: rr.RecordingStream, profile: Profile, runs: Sequence[tuple[str, Gathered, Appearance]]
) -> None:
    """Axes, curves of all runs, and the names of several."""
    axes = profile.axes
    log_axes(recording, profile, f"p{in_brackets(profile.units.pressure)}", ticks(axes.low, axes.high), runs)
    for name, run, appearance in runs:
        _log_curves(recording, axes, run, appearance, name)


def log_axes(
    recording: rr.RecordingStream,
    profile: Profile,
    upwards: str,
    up: Sequence[tuple[float, str]],
    runs: Sequence[tuple[str, Gathered, Appearance]],
) -> None:
    """Axes with the title and the ticks of the upward one, and the names of several runs."""
    axes = profile.axes
    titles = f"s along {profile.slave}{in_brackets(profile.units.length)}", upwards
    axes.log(recording, titles, ticks(axes.x0, axes.x1), up)
    if len(runs) > 1:
        body = profile.slave.partition(".")[0]
        names = [
            (appearance.title.removesuffix(f", slave {body}"), rgb(appearance.colour)) for _, _, appearance in runs
        ]
        log_legend(recording, axes.path, names, axes.hang)


def along_surface(axes: Axes, surface: Surface) -> np.ndarray:
    """The nodes (k,) that are within the axes, along the surface."""
    order = surface.along
    return order[(surface.s[order] >= axes.x0 - 1e-12) & (surface.s[order] <= axes.x1 + 1e-12)]


def _log_curves(recording: rr.RecordingStream, axes: Axes, run: Gathered, appearance: Appearance, contact: str) -> None:
    surface = run.surfaces[contact]
    order = along_surface(axes, surface)
    shown = curves_of(run, contact, len(order))
    when, path = frame_times(run, shown.step.tolist(), shown.time.tolist()), f"{appearance.path}/profile/{contact}"
    pressure = axes.points(np.broadcast_to(surface.s[order], (len(shown.step), len(order))), shown.pressure[:, order])
    recording.send_columns(f"{path}/pressure", when, solid_columns(pressure))
    names = ["pressure"]
    if next(c.friction for c in run.layout.contacts if c.name == contact):
        lines = [dashed(surface.s[order], shear) for shear in shown.shear[:, order]]
        s: Floats = np.array([s for s, _ in lines])
        shears = axes.points(s, np.array([shear for _, shear in lines]))
        recording.send_columns(f"{path}/shear", when, dashed_columns(shears))
        names.append("shear")
    for name in names:
        style = rr.LineStrips3D.from_fields(colors=[rgb(appearance.colour)], radii=[-1.3])
        recording.log(f"{path}/{name}", style, static=True)


@dataclass(frozen=True)
class Curves:
    """Pressure, shear, gap and slip (n, m) of the slave nodes at n instants; slip is nan but in recorded steps."""

    step: np.ndarray
    time: np.ndarray
    pressure: np.ndarray
    shear: np.ndarray
    gap: np.ndarray
    slip: np.ndarray


def curves_of(run: Gathered, contact: str, nodes: int) -> Curves:
    """Curves of the frames, and of the contact record: all of its last steps, earlier ones up to `MOST_POINTS`."""
    surface, rows = run.surfaces[contact], run.records.get(contact, np.zeros(0))
    step, time = np.array([i.step for i in run.instants]), np.array([i.time for i in run.instants])
    slip = np.full_like(surface.gap, np.nan)
    if not len(rows):
        return Curves(step, time, surface.pressure, surface.shear, surface.gap, slip)
    _, frames, recorded = np.intersect1d(step, rows["step"], return_indices=True)
    slip[frames] = slips(rows[recorded])
    sparse = -(-len(rows) * nodes // MOST_POINTS)
    kept = np.union1d(np.arange(0, len(rows), sparse), np.arange(max(0, len(rows) - LAST), len(rows)))
    rows = rows[kept]
    rows = rows[~np.isin(rows["step"], step)]
    order = np.argsort(np.concatenate([step, rows["step"]]), kind="stable")
    shear = rows["shear"] if "shear" in (rows.dtype.names or ()) else np.zeros_like(rows["pressure"])
    # values that balance neighbours of open nodes are not tractions
    pressure, shear = (np.where(rows["state"] > 0, values, 0.0) for values in (rows["pressure"], shear))
    both = (
        (step, rows["step"]), (time, rows["time"]), (surface.pressure, pressure), (surface.shear, shear),
        (surface.gap, rows["gap"]), (slip, slips(rows)),
    )  # fmt: skip
    return Curves(*(np.concatenate(parts)[order] for parts in both))


def slips(rows: np.ndarray) -> np.ndarray:
    """Slip (n, m) of closed nodes in recorded steps, nan for open ones and without friction."""
    if "slip" not in (rows.dtype.names or ()):
        return np.full(rows["gap"].shape, np.nan)
    return np.where(rows["state"] > 0, rows["slip"], np.nan)


def in_brackets(unit: str) -> str:
    """Return the unit as in a title; an empty string without a unit."""
    return f" [{unit}]" if unit else ""
