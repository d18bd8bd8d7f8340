"""Figures and animations of fields on the deformed bodies."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.animation import FuncAnimation
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import Collection, LineCollection, PolyCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from contactlab.api.arrays import Floats, Ints
from contactlab.api.drawing.colours import FIELD
from contactlab.api.drawing.units import Units
from contactlab.errors import ContactlabError
from contactlab.reports.figures import FAINT, INK, MUTED, house_style
from contactlab.reports.notebook.canvas import WIDTH, Plot, canvas, figure_of, label_places
from contactlab.reports.notebook.conditions import draw_conditions, scene_of
from contactlab.reports.notebook.fields import Moment, moment_of, nodal_values_of, title_of, values_of
from contactlab.results.nodal import corners_of
from contactlab.results.results import Results
from contactlab.studies.shape import outline

COLOURS = LinearSegmentedColormap.from_list("field", FIELD)
LETTERS = 8.5  # bold letters of a title on an inch of a figure, of which labels and the colour bar take their part
PAUSE = 80  # ms between two pictures of an animation

Limits = tuple[float, float]


def field_figure(results: Results, name: str, frame: int, ax: Axes | None = None, flat: bool = False) -> Figure:
    """The deformed bodies coloured by a field: nodal averages, or one colour per cell if `flat`."""
    moment = moment_of(results, frame)
    values = _values(results, moment, name, flat)
    with house_style():
        figure, axes = frame_of([_of_bodies(results, moment)], ax)
        shown = draw_field(axes, results, moment, values, limits_of([values]))
        colour_bar(figure, axes, shown, title_of(name, Units.of_label(results.layout.units)))
        _conditions_of(results)(axes, moment.position)
        label_places(axes, results.layout.units, f"{results.layout.title}, {when(results, moment)}")
    return figure


def field_animation(
    results: Results, name: str, stride: int, ax: Axes | None = None, flat: bool = False
) -> FuncAnimation:
    """Every `stride`th stored frame and the last one, with the same colours and axes in all of them."""
    moments = _moments(results, stride)
    with house_style():
        figure, axes = frame_of([_of_bodies(results, moment) for moment in moments], ax)
        draw = animated(axes, results, moments, name, flat, results.layout.title)
        units = Units.of_label(results.layout.units)
        colour_bar(figure, axes, draw(0)[0], title_of(name, units))
    return FuncAnimation(figure, draw, frames=len(moments), interval=PAUSE)


def animated(
    axes: Axes, results: Results, moments: Sequence[Moment], name: str, flat: bool, title: str,
    limits: Limits | None = None,
) -> Any:  # fmt: skip
    """Return a function that redraws the moment of a number and returns its artists, the coloured ones first."""
    draw_supports_and_loads = _conditions_of(results)
    values = [_values(results, moment, name, flat) for moment in moments]
    within = limits or limits_of(values, values[-1:])
    before: list[Artist] = []

    def draw(number: int) -> list[Any]:
        with house_style():  # later frames are drawn by whoever saves or shows the animation
            for artist in before:
                artist.remove()
            known = set(axes.get_children())
            now = min(number, len(moments) - 1)
            moment = moments[now]
            shown = draw_field(axes, results, moment, values[now], within)
            draw_supports_and_loads(axes, moment.position)
            before[:] = [artist for artist in axes.get_children() if artist not in known]
            label_places(axes, results.layout.units, _wrapped(axes, f"{title}, {when(results, moment)}"))
        return [shown, *(artist for artist in before if artist is not shown)]

    return draw


def fields_figure(runs: Mapping[str, Results], name: str, frame: int, flat: bool = False) -> Figure:
    """The same field of several runs side by side, with common colours and axes."""
    moments = {title: moment_of(results, frame) for title, results in runs.items()}
    values = {title: _values(results, moments[title], name, flat) for title, results in runs.items()}
    limits = limits_of(list(values.values()))
    with house_style():
        figure, places = _grid(runs, moments.values())
        for (title, results), axes in zip(runs.items(), places, strict=False):
            shown = draw_field(axes, results, moments[title], values[title], limits)
            _conditions_of(results)(axes, moments[title].position)
            label_places(axes, results.layout.units, _wrapped(axes, f"{title}, {when(results, moments[title])}"))
        units = Units.of_label(next(iter(runs.values())).layout.units)
        colour_bar(figure, places, shown, title_of(name, units))
    return figure


def fields_animation(runs: Mapping[str, Results], name: str, stride: int, flat: bool = False) -> FuncAnimation:
    """Several runs side by side; a run with fewer frames stays at its last frame."""
    moments = {title: _moments(results, stride) for title, results in runs.items()}
    ends = [_values(results, moments[title][-1], name, flat) for title, results in runs.items()]
    limits = limits_of(ends)
    with house_style():
        figure, places = _grid(runs, [moment for several in moments.values() for moment in several])
        each = [
            animated(axes, results, moments[title], name, flat, title, limits)
            for (title, results), axes in zip(runs.items(), places, strict=False)
        ]
        shown = [draw(0)[0] for draw in each]
        units = Units.of_label(next(iter(runs.values())).layout.units)
        colour_bar(figure, places, shown[0], title_of(name, units))

    def all_of_them(number: int) -> list[Any]:
        return [artist for draw in each for artist in draw(number)]

    return FuncAnimation(figure, all_of_them, frames=max(map(len, moments.values())), interval=PAUSE)


def _moments(results: Results, stride: int) -> list[Moment]:
    """Every `stride`th stored frame and the last one; the end of a run without frames."""
    last = len(results.frames) - 1
    return [moment_of(results, k) for k in (*range(0, last, stride), last)] if last >= 0 else [moment_of(results)]


def _grid(runs: Mapping[str, Results], moments: Iterable[Moment]) -> tuple[Figure, list[Axes]]:
    """Axes for each run, with room for all positions."""
    points = np.concatenate([moment.position for moment in moments])
    width, height = np.maximum(np.ptp(points, axis=0), 1e-9)
    wide = 1 if len(runs) == 1 or width > 2.5 * height * len(runs) else 2 if len(runs) < 5 else 3
    high = -(-len(runs) // wide)
    each = 9.0 / wide
    tall = float(np.clip(each * height / width, 1.4, 5.0)) + 0.6
    figure = Plot(figsize=(10.0, min(14.0, tall * high)), layout="constrained")
    places = list(figure.subplots(high, wide, sharex=True, sharey=True, squeeze=False).ravel())
    low, high_ = points.min(axis=0), points.max(axis=0)
    for axes in places:
        _limit(axes, low, high_)
    for axes in places[len(runs) :]:
        axes.set_visible(False)
    return figure, places[: len(runs)]


def _wrapped(axes: Axes, title: str) -> str:
    """The title, broken into lines that fit above these axes and not over their neighbours."""
    wide = figure_of(axes).get_figwidth()
    grid = axes.get_subplotspec()
    return textwrap.fill(title, int(LETTERS * wide / (grid.get_gridspec().ncols if grid is not None else 1)))


def when(results: Results, moment: Moment) -> str:
    """The share of the load in statics, else the time."""
    if results.summary.get("reached", {}).get("of") == "load" and moment.share == moment.share:
        return f"{100.0 * moment.share:.0f} % of the load"
    return f"t = {moment.time:.4g} {Units.of_label(results.layout.units).time}".rstrip()


def _values(results: Results, moment: Moment, name: str, flat: bool) -> dict[str, Floats]:
    return values_of(results, moment, name) if flat else nodal_values_of(results, moment, name)


def frame_of(positions: Iterable[Floats], ax: Axes | None = None) -> tuple[Figure, Axes]:
    """Make axes with room for all positions, and their figure."""
    points = np.concatenate(list(positions))
    low, high = points.min(axis=0), points.max(axis=0)
    width, height = np.maximum(high - low, 1e-3 * np.max(high - low))
    figure, axes = canvas(ax, float(np.clip((WIDTH - 1.6) * height / width + 0.9, 2.2, 6.5)))
    _limit(axes, low, high)
    return figure, axes


def _limit(axes: Axes, low: Floats, high: Floats) -> None:
    margin = 0.06 * float(np.max(high - low))
    axes.set_xlim(low[0] - margin, high[0] + margin)
    axes.set_ylim(low[1] - margin, high[1] + margin)
    axes.set_aspect("equal")
    axes.grid(False)


def limits_of(fields: Sequence[Mapping[str, Floats]], ends: Sequence[Mapping[str, Floats]] = ()) -> Limits:
    """Ends of the colours, the upper one of `ends`: a corner singularity must not leave the rest in the dark."""
    low = float(np.percentile(_known(fields), 0.25))
    high = float(np.percentile(_known(ends or fields), 99.75))
    low = 0.0 if 0.0 <= low < 0.3 * high else low
    return (low, high) if high > low else (low, low + max(abs(low), 1.0) * 1e-6)


def _known(fields: Sequence[Mapping[str, Floats]]) -> Floats:
    values = np.concatenate([values for field in fields for values in field.values()])
    return np.asarray(values[np.isfinite(values)])


def draw_field(axes: Axes, results: Results, moment: Moment, values: Mapping[str, Floats], limits: Limits) -> Any:
    """Draw the bodies; returns the artist of the first coloured one."""
    found: list[Collection] = []
    for name, cells in results.cells.items():
        corners = moment.position[corners_of(cells)]
        if name not in values:
            axes.add_collection(PolyCollection(list(corners), facecolor="#eceef1"))
        elif len(values[name]) == len(cells) != len(moment.position):
            drawn = PolyCollection(list(corners), array=values[name], cmap=COLOURS, edgecolors="face", linewidths=0.2)
            axes.add_collection(drawn)
            found.append(drawn)
        else:
            x, y = moment.position.T
            mesh = Triangulation(x, y, triangles_of(cells))
            smooth = np.nan_to_num(values[name])  # nodes of other bodies, which no triangle has
            found.append(axes.tripcolor(mesh, smooth, shading="gouraud", cmap=COLOURS, rasterized=True))
        axes.add_collection(LineCollection(list(outline(corners)), colors=INK, linewidths=1.0))
    for artist in found:
        artist.set_clim(*limits)
    for lines in _rigid_lines(results, moment):
        axes.add_collection(LineCollection(lines, colors=MUTED, linewidths=2.0))
    return found[0]


def triangles_of(cells: Ints) -> Ints:
    """Triangles (k, 3) that cover the cells."""
    corners = corners_of(cells)
    return corners if corners.shape[1] == 3 else np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])


def _of_bodies(results: Results, moment: Moment) -> Floats:
    """Positions of the nodes that belong to cells: rigid surfaces may reach far beyond."""
    return np.asarray(moment.position[_own_nodes(results)])


def _own_nodes(results: Results) -> Ints:
    return np.unique(np.concatenate([cells.ravel() for cells in results.cells.values()]))


def _rigid_lines(results: Results, moment: Moment) -> Iterable[list[Floats]]:
    """Segments of masters that no body has."""
    own = _own_nodes(results)
    for contact in results.layout.contacts:
        if not np.isin(contact.master_nodes, own).any():
            yield list(moment.position[contact.master_nodes][contact.master_segments])


def _conditions_of(results: Results) -> Callable[[Axes, Floats], None]:
    """Return what draws supports and loads at nodes (N, 2); nothing if the scene or a mesh can no longer be read."""
    try:
        scene, bodies = scene_of(results)
    except (ContactlabError, OSError, ValueError):
        return lambda axes, position: None
    return lambda axes, position: draw_conditions(axes, scene, bodies, position)


def colour_bar(figure: Figure, axes: Any, shown: Any, title: str, extend: str = "neither") -> None:
    """Draw the colour bar of `shown` next to the axes; it may `extend` to values beyond its ends."""
    figure = figure if not isinstance(axes, Axes) else figure_of(axes)
    bar = figure.colorbar(shown, ax=axes, shrink=0.85, pad=0.02, extend=extend)
    bar.set_label(title, color=MUTED)
    bar.outline.set_edgecolor(FAINT)
