"""Drawn plots: axes, curves of pressure and shear, the colour bar. The viewer has none of its own for these."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr

from contactlab.api.arrays import Floats
from contactlab.api.colours import rgb
from contactlab.api.frame import ContactLayout
from contactlab.api.units import Units
from contactlab_rerun.drawing import TABLE
from contactlab_rerun.gathered import Gathered, Look, nice, short
from contactlab_rerun.projection import camera, in_plane, line_strips
from contactlab_rerun.series import times

WIDTH = 1.7  # of a plot whose height is 1
BOX = (np.array([-0.22, -0.22]), np.array([WIDTH + 0.1, 1.14]))
"""Everything that is drawn of a plot but the legend."""

LEGEND = np.array([0.75, 0.0])
"""Width of the legend on its right."""
INK, GREY = (205, 210, 216), (74, 80, 88)
SHEAR_DIM = 0.55  # colours of shear are those of pressure, darker


@dataclass(frozen=True)
class Plot:
    """Axes that several runs share: arc length from `s0` to `s1` [mm], tractions from `low` to `high` [MPa]."""

    path: str
    slave: str
    what: str
    s0: float
    s1: float
    low: float
    high: float
    units: Units

    def points(self, s: Floats, traction: Floats) -> np.ndarray:
        """Where values lie in the drawing."""
        x = WIDTH * (s - self.s0) / (self.s1 - self.s0)
        y = (traction - self.low) / (self.high - self.low)
        return in_plane(np.stack([x, y], axis=-1))


def plot_for(contact: ContactLayout, runs: Sequence[tuple[str, Gathered]], path: str) -> Plot:
    """Axes for one slave surface in all `runs` that have it, each with the name of its contact."""
    curves = [instant.curves[name] for name, run in runs for instant in run.instants]
    pressed = [curve.s[curve.state > 0] for curve in curves]
    ends = np.concatenate([*pressed, np.zeros(0)])
    s = curves[0].s
    s0, s1 = (ends.min(), ends.max()) if len(ends) else (s.min(), s.max())
    margin = max(0.08 * (s1 - s0), 2.0 * np.diff(np.sort(s)).max(initial=0.0))
    high = max((float(max(c.pressure.max(), c.shear.max())) for c in curves), default=0.0)
    low = min((float(min(c.pressure.min(), c.shear.min())) for c in curves), default=0.0)
    high = nice(high)
    units = Units.of_label(runs[0][1].layout.units)
    low = -nice(-low) if low < -0.01 * high else 0.0
    what = "pressure, and shear (darker)," if any(c.friction for c in _contacts(runs)) else "pressure"
    return Plot(path, contact.slave, what, max(s.min(), s0 - margin), min(s.max(), s1 + margin), low, high, units)


def _contacts(runs: Sequence[tuple[str, Gathered]]) -> list[ContactLayout]:
    return [contact for name, run in runs for contact in run.layout.contacts if contact.name == name]


def log_axes(recording: rr.RecordingStream, plot: Plot) -> None:
    """Lines, ticks and labels of the axes."""
    recording.log(f"{plot.path}/view", camera(), static=True)
    ticks = _ticks(plot.low, plot.high)
    grid = [plot.points(np.array([plot.s0, plot.s1]), np.array([t, t])) for t in ticks]
    recording.log(f"{plot.path}/grid", rr.LineStrips3D(grid, colors=[GREY], radii=[-0.6]), static=True)
    corners = np.array([plot.s0, plot.s0, plot.s1]), np.array([plot.high, plot.low, plot.low])
    frame = rr.LineStrips3D([plot.points(*corners)], colors=[INK], radii=[-1.0])
    recording.log(f"{plot.path}/axes", frame, static=True)
    marks = _ticks(plot.s0, plot.s1)
    at = [plot.points(np.array([plot.s0]), np.array([t]))[0] + (-0.09, 0.0, 0.0) for t in ticks]
    at += [plot.points(np.array([s]), np.array([plot.low]))[0] + (0.0, -0.06, 0.0) for s in marks]
    at += [np.array([WIDTH / 2, -0.16, -1.0]), np.array([0.0, 1.07, -1.0])]
    length, pressure = _in(plot.units.length), _in(plot.units.pressure)
    labels = [short(t) for t in ticks] + [f"{s:.3g}" for s in marks] + [f"s along {plot.slave}{length}", f"p{pressure}"]
    recording.log(f"{plot.path}/labels", _labels(at, labels), static=True)


def log_legend(recording: rr.RecordingStream, plot: Plot, looks: Sequence[Look]) -> None:
    """The names of the runs in their colours, beside the plot."""
    for number, look in enumerate(looks):
        at = np.array([WIDTH + 0.45, 0.95 - 0.13 * number, -1.0])
        label = look.title.removesuffix(f", slave {plot.slave.partition('.')[0]}")  # they all have it
        recording.log(f"{plot.path}/legend/{number}", _labels([at], [label], rgb(look.colour)), static=True)


def log_curves(recording: rr.RecordingStream, plot: Plot, run: Gathered, look: Look, contact: str) -> None:
    """Pressure (and shear, with friction) over the arc length at every frame."""
    friction = next(c.friction for c in run.layout.contacts if c.name == contact)
    when = times([i.step for i in run.instants], [i.time for i in run.instants])
    for name, dim in (("pressure", 1.0), *((("shear", SHEAR_DIM),) if friction else ())):
        strips = [_strip(plot, instant.curves[contact], name) for instant in run.instants]
        path = f"{look.path}/profile/{contact}/{name}"
        lines = line_strips(np.concatenate(strips), [len(strip) for strip in strips])
        recording.send_columns(path, when, rr.LineStrips3D.columns(strips=lines).partition([1] * len(strips)))
        colour = tuple(int(dim * part) for part in rgb(look.colour))
        style = rr.LineStrips3D.from_fields(colors=[colour], radii=[-1.3])
        recording.log(path, style, static=True)


def _strip(plot: Plot, curve: object, name: str) -> np.ndarray:
    s, values = curve.s, getattr(curve, name)  # type: ignore[attr-defined]
    order = np.argsort(s, kind="stable")
    order = order[(s[order] >= plot.s0 - 1e-12) & (s[order] <= plot.s1 + 1e-12)]
    return plot.points(s[order], values[order])


def log_colour_bar(
    recording: rr.RecordingStream, path: str, label: str, top: float, low: Floats, high: Floats
) -> tuple[Floats, Floats]:
    """The scale of the field below the model's box; gives the box with it."""
    width, size = (high - low)[0], (high - low).max()
    x0, x1 = low[0] + 0.25 * width, low[0] + 0.75 * width
    y1 = low[1] - 0.07 * size
    y0 = y1 - 0.025 * size
    x = np.repeat(np.linspace(x0, x1, 65), 2)
    points = in_plane(np.stack([x, np.tile([y0, y1], 65)], axis=1))
    a = 2 * np.arange(64)
    triangles = np.concatenate([np.stack([a, a + 2, a + 3], axis=1), np.stack([a, a + 3, a + 1], axis=1)])
    colours = np.repeat(TABLE[np.linspace(0, len(TABLE) - 1, 65).astype(int)], 2)
    mesh = rr.Mesh3D(vertex_positions=points, triangle_indices=triangles, vertex_colors=colours)
    recording.log(f"{path}/bar", mesh, static=True)
    y = y0 - 0.035 * size
    at = [np.array([x0, y, -1.0]), np.array([0.5 * (x0 + x1), y, -1.0]), np.array([x1, y, -1.0])]
    recording.log(f"{path}/bar/labels", _labels(at, ["0", f"{label}", short(top)]), static=True)
    return np.array([low[0], y - 0.02 * size]), high


def _labels(at: Sequence[np.ndarray], texts: Sequence[str], colour: tuple[int, ...] = INK) -> rr.Points3D:
    return rr.Points3D(np.array(at, np.float32), labels=list(texts), radii=[0.0], colors=[colour], show_labels=True)


def _ticks(low: float, high: float) -> list[float]:
    """About five round numbers, with both ends of the range kept in view."""
    step = nice_step((high - low) / 5.0)
    first = np.ceil(low / step - 1e-9) * step
    return [round(float(t), 12) + 0.0 for t in np.arange(first, high + 1e-9 * step, step)]


def nice_step(value: float) -> float:
    """1, 2 or 5 times a power of ten, not below `value`."""
    unit = 10.0 ** np.floor(np.log10(value))
    return float(unit * next(m for m in (1.0, 2.0, 5.0, 10.0) if m * unit >= value * (1.0 - 1e-9)))


def _in(unit: str) -> str:
    return f" [{unit}]" if unit else ""
