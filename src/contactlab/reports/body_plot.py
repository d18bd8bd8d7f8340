"""The deformed bodies of one run, coloured by von Mises stress: what the comparison is about."""

from __future__ import annotations

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from contactlab.api.drawing.units import Units
from contactlab.reports.figures import INK, house_style
from contactlab.reports.notebook.canvas import label_places, with_unit
from contactlab.reports.notebook.pictures import COLOURS, colour_bar, frame_of
from contactlab.studies.shape import outline
from contactlab.studies.table import Row, Table


def shown_row(table: Table) -> Row | None:
    """The run whose bodies are drawn: the first that finished, else the first that left any."""
    rows = [row for row in table.main if row.shapes]
    return next((row for row in rows if row.finished), rows[0] if rows else None)


def body_figure(table: Table) -> Figure | None:
    """All bodies at the end of `shown_row`; None when no run left any."""
    row = shown_row(table)
    if row is None:
        return None
    units = str(table.scene.get("units") or "")
    corners = np.concatenate([shape.corners for shape in row.shapes.values()])
    stress = np.concatenate([shape.von_mises for shape in row.shapes.values()])
    top = float(np.percentile(stress, 99.5))
    with house_style():
        figure, axes = frame_of([corners.reshape(-1, 2)])
        cells = PolyCollection(list(corners), array=stress, cmap=COLOURS, edgecolors="face", linewidths=0.2)
        cells.set_clim(0.0, top)
        axes.add_collection(cells)
        outlines = [line for shape in row.shapes.values() for line in outline(shape.corners)]
        axes.add_collection(LineCollection(outlines, colors=INK, linewidths=1.1))
        name = with_unit("von Mises stress", Units.of_label(units).pressure)
        colour_bar(figure, axes, cells, name, "max" if stress.max() > top else "neither")
        label_places(axes, units, "")
    return figure
