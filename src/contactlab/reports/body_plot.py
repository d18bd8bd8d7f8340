"""The deformed bodies of one run, coloured by von Mises stress: what the comparison is about."""

from __future__ import annotations

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from contactlab.api.arrays import Floats
from contactlab.api.drawing.colours import FIELD
from contactlab.api.drawing.units import Units
from contactlab.reports.figures import FAINT, INK, MUTED, house_style
from contactlab.reports.notebook.canvas import with_unit
from contactlab.studies.shape import Shape
from contactlab.studies.table import Row, Table

_WIDTH = 8.6  # inches
_BESIDE, _BELOW = 1.5, 0.7  # inches for the colour bar and for the labels


def shown_row(table: Table) -> Row | None:
    """The run whose bodies are drawn: the first that finished, else the first that left any."""
    rows = [row for row in table.main if row.shapes]
    return next((row for row in rows if row.finished), rows[0] if rows else None)


def body_figure(table: Table) -> Figure | None:
    """All bodies at the end of `shown_row`; None when no run left any."""
    row = shown_row(table)
    if row is None:
        return None
    units = Units.of_label(table.scene.get("units"))
    corners = np.concatenate([shape.corners for shape in row.shapes.values()])
    stress = np.concatenate([shape.von_mises for shape in row.shapes.values()])
    width, height = np.ptp(corners.reshape(-1, 2), axis=0)
    top = float(np.percentile(stress, 99.5))
    with house_style():
        size = _WIDTH, float(np.clip((_WIDTH - _BESIDE) * height / width + _BELOW, 2.4, 7.5))
        figure = Figure(figsize=size, layout="constrained")
        axes = figure.subplots()
        colours = LinearSegmentedColormap.from_list("field", FIELD)
        cells = PolyCollection(list(corners), array=stress, cmap=colours, edgecolors="face", linewidths=0.2)
        cells.set_clim(0.0, top)
        axes.add_collection(cells)
        outlines = [line for shape in row.shapes.values() for line in outline(shape)]
        axes.add_collection(LineCollection(outlines, colors=INK, linewidths=1.1))
        axes.autoscale_view()
        axes.set_aspect("equal")
        axes.grid(False)
        axes.set_xlabel(with_unit("x", units.length))
        axes.set_ylabel(with_unit("y", units.length))
        bar = figure.colorbar(cells, ax=axes, shrink=0.85, pad=0.02, extend="max" if stress.max() > top else "neither")
        bar.set_label(with_unit("von Mises stress", units.pressure), color=MUTED)
        bar.outline.set_edgecolor(FAINT)
    return figure


def outline(shape: Shape) -> Floats:
    """The sides (k, 2, 2) that belong to one cell only."""
    sides = np.stack([shape.corners, np.roll(shape.corners, -1, axis=1)], axis=2).reshape(-1, 2, 2)
    # Cells share nodes, so the two copies of an inner side have bitwise equal ends, in opposite order.
    ends = {(*side[0], *side[1]) for side in sides}
    return sides[[(*side[1], *side[0]) not in ends for side in sides]]
