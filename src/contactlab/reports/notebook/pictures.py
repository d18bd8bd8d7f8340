"""Figures of scenes, fields and contact curves."""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from matplotlib.animation import FuncAnimation
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from contactlab.api.arrays import Floats
from contactlab.api.drawing.colours import FIELD, REFERENCE, STYLES
from contactlab.api.drawing.units import Units
from contactlab.api.frame import ContactCurve
from contactlab.reports.body_plot import outline
from contactlab.reports.figures import FAINT, INK, MUTED, house_style
from contactlab.reports.notebook.fields import Moment, moment_of, title_of, values_of
from contactlab.results.results import Results
from contactlab.scene.scene import Scene
from contactlab.studies.shape import Shape

WIDTH = 7.6  # inches
BODIES = ("#dfe6ee", "#efe5d8", "#e2ecdf", "#ece0ea", "#f0e9c9", "#d9ebec")
"""Pale colours of bodies in pictures of scenes."""


class Plot(Figure):
    """A figure that shows itself in a notebook, whether or not pyplot is used there."""

    def savefig(self, *arguments: Any, **settings: Any) -> None:
        """Write the figure. Its layout takes two passes: after one alone, a title above wide axes may be cut off."""
        with house_style():
            self.draw_without_rendering()
            super().savefig(*arguments, **settings)

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        self.savefig(buffer, format="png", dpi=110)
        return buffer.getvalue()


def field_figure(results: Results, name: str, frame: int) -> Figure:
    """The deformed bodies coloured by a field."""
    moment = moment_of(results, frame)
    values = values_of(results, moment, name)
    with house_style():
        figure, axes = _frame_of([_of_bodies(results, moment)])
        shown = _colour(axes, results, moment, values, _limits([values]))
        _colour_bar(figure, axes, shown, title_of(name, Units.of_label(results.layout.units)))
        _label(axes, results.layout.units, f"{results.layout.title}, t = {moment.time:.4g} {_time(results)}".rstrip())
    return figure


def field_animation(results: Results, name: str, stride: int) -> FuncAnimation:
    """All stored frames, every `stride`th one, with the same colours and axes in all of them."""
    moments = [moment_of(results, k) for k in range(0, len(results.frames), stride)] or [moment_of(results)]
    values = [values_of(results, moment, name) for moment in moments]
    limits = _limits(values)
    with house_style():
        figure, axes = _frame_of([_of_bodies(results, moment) for moment in moments])
        shown = _colour(axes, results, moments[0], values[0], limits)
        _colour_bar(figure, axes, shown, title_of(name, Units.of_label(results.layout.units)))

    def draw(number: int) -> Iterable[Any]:
        for artist in [*axes.collections]:
            artist.remove()
        _colour(axes, results, moments[number], values[number], limits)
        title = f"{results.layout.title}, t = {moments[number].time:.4g} {_time(results)}".rstrip()
        _label(axes, results.layout.units, title)
        return axes.collections

    return FuncAnimation(figure, draw, frames=len(moments), interval=80)


def curve_figure(curve: ContactCurve, units: str = "") -> Figure:
    """Pressure and shear along the slave, open nodes in grey, a line per chain."""
    names = Units.of_label(units)
    with house_style():
        figure = Plot(figsize=(WIDTH, 3.2), layout="constrained")
        axes = figure.subplots()
        for number in np.unique(curve.chain):
            here = curve.chain == number
            label = number == curve.chain.min()
            _line(axes, curve.s[here], curve.pressure[here], 0, "pressure" if label else "")
            if np.any(curve.shear != 0.0):
                _line(axes, curve.s[here], curve.shear[here], 1, "shear" if label else "")
        still = curve.state == 0
        axes.plot(curve.s[still], curve.pressure[still], "o", color=REFERENCE, markersize=3.2, label="open")
        axes.axhline(0.0, color=FAINT, linewidth=0.8, zorder=0)
        axes.set_xlabel("arc length of the slave" + (f" [{names.length}]" if names.length else ""))
        axes.set_ylabel("traction" + (f" [{names.pressure}]" if names.pressure else ""))
        axes.legend()
    return figure


def _line(axes: Axes, x: Floats, y: Floats, style: int, label: str) -> None:
    colour, marker = STYLES[style].colour, STYLES[style].marker
    axes.plot(x, y, color=colour, marker=marker, markersize=3, linewidth=1.3, label=label or None)


def scene_figure(scene: Scene) -> Figure:
    """The meshes of a scene before the run, with rigid surfaces and the sides of its contacts."""
    from contactlab.model.bodies.build_bodies import build_bodies
    from contactlab.model.loading.rigid import build_rigid

    bodies = build_bodies(scene, scene.registry)
    rigid = build_rigid(scene, bodies) if scene.rigid else ()
    with house_style():
        figure, axes = _frame_of([body.mesh.nodes for body in bodies])
        for number, body in enumerate(bodies):
            corners = body.mesh.nodes[body.mesh.cells[:, :4]]
            colour = BODIES[number % len(BODIES)]
            axes.add_collection(PolyCollection(list(corners), facecolor=colour, edgecolor="#b9c0c8", linewidths=0.4))
            axes.add_collection(LineCollection(list(outline(Shape(corners, np.zeros(0)))), colors=INK, linewidths=1.0))
            middle = corners.reshape(-1, 2)
            x, y = (0.5 * (middle.min(axis=0) + middle.max(axis=0))).tolist()
            axes.text(x, y, body.name, ha="center", va="center")
        limits = axes.get_xlim(), axes.get_ylim()
        for surface in rigid:
            axes.plot(*surface.points.T, color=MUTED, linewidth=2.0)
        _contacts(axes, scene, {body.name: body.mesh for body in bodies})
        axes.set_xlim(*limits[0])
        axes.set_ylim(*limits[1])
        _label(axes, scene.units, scene.name)
    return figure


def _contacts(axes: Axes, scene: Scene, meshes: Mapping[str, Any]) -> None:
    """Slave sides in the first colour, master sides in the second."""
    drawn: set[str] = set()
    for contact in scene.contacts:
        for side, label, style in zip(contact.targets, ("slave", "master"), STYLES[:2], strict=True):
            for target in side:
                body, _, edges = target.partition(".")
                if body not in meshes:
                    continue
                mesh = meshes[body]
                lines = mesh.nodes[mesh.edges[edges][:, :2]] if edges in mesh.edges else np.zeros((0, 2, 2))
                axes.add_collection(LineCollection(list(lines), colors=style.colour, linewidths=2.2,
                                                   label=None if label in drawn else label))  # fmt: skip
                drawn.add(label)
    if drawn:
        axes.legend(loc="best", fontsize=8.5)


def _frame_of(positions: Iterable[Floats]) -> tuple[Figure, Axes]:
    """A figure whose axes have room for all positions."""
    points = np.concatenate(list(positions))
    low, high = points.min(axis=0), points.max(axis=0)
    width, height = np.maximum(high - low, 1e-3 * np.max(high - low))
    figure = Plot(figsize=(WIDTH, float(np.clip((WIDTH - 1.6) * height / width + 0.9, 2.2, 6.5))), layout="constrained")
    axes = figure.subplots()
    margin = 0.04 * max(width, height)
    axes.set_xlim(low[0] - margin, high[0] + margin)
    axes.set_ylim(low[1] - margin, high[1] + margin)
    axes.set_aspect("equal")
    axes.grid(False)
    return figure, axes


def _limits(fields: list[dict[str, Floats]]) -> tuple[float, float]:
    """Ends of the colours: a corner singularity must not leave the rest in the dark."""
    last = np.concatenate([*fields[-1].values()])
    every = np.concatenate([values for field in fields for values in field.values()])
    low, high = float(np.percentile(every, 0.25)), float(np.percentile(last, 99.75))
    low = 0.0 if 0.0 <= low < 0.3 * high else low
    return (low, high) if high > low else (low, low + max(abs(low), 1.0) * 1e-6)


def _colour(
    axes: Axes, results: Results, moment: Moment, values: Mapping[str, Floats], limits: tuple[float, float]
) -> PolyCollection:
    colours, found = LinearSegmentedColormap.from_list("field", FIELD), []
    for name, cells in results.cells.items():
        corners = moment.position[cells[:, :4]]
        drawn = PolyCollection(list(corners), facecolor="#eceef1")
        if name in values:
            drawn = PolyCollection(list(corners), array=values[name], cmap=colours, edgecolors="face", linewidths=0.2)
            drawn.set_clim(*limits)
            found.append(drawn)
        axes.add_collection(drawn)
        axes.add_collection(LineCollection(list(outline(Shape(corners, np.zeros(0)))), colors=INK, linewidths=1.0))
    for lines in _rigid_lines(results, moment):
        axes.add_collection(LineCollection(lines, colors=MUTED, linewidths=2.0))
    return found[0]


def _of_bodies(results: Results, moment: Moment) -> Floats:
    """Positions of the nodes that belong to cells: rigid surfaces may reach far beyond."""
    own = np.unique(np.concatenate([cells.ravel() for cells in results.cells.values()]))
    return np.asarray(moment.position[own])


def _rigid_lines(results: Results, moment: Moment) -> Iterable[list[Floats]]:
    """Segments of masters that no body has."""
    own = np.unique(np.concatenate([cells.ravel() for cells in results.cells.values()]))
    for contact in results.layout.contacts:
        if not np.isin(contact.master_nodes, own).any():
            yield list(moment.position[contact.master_nodes][contact.master_segments])


def _colour_bar(figure: Figure, axes: Axes, shown: PolyCollection, title: str) -> None:
    bar = figure.colorbar(shown, ax=axes, shrink=0.85, pad=0.02)
    bar.set_label(title, color=MUTED)
    bar.outline.set_edgecolor(FAINT)


def _label(axes: Axes, units: str, title: str) -> None:
    length = Units.of_label(units).length
    axes.set_xlabel(f"x [{length}]" if length else "x")
    axes.set_ylabel(f"y [{length}]" if length else "y")
    axes.set_title(title)


def _time(results: Results) -> str:
    return Units.of_label(results.layout.units).time
