"""The deformed bodies of one run, coloured by von Mises stress: what the comparison is about."""

from __future__ import annotations

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from contactlab.compare.table import Row, Table
from contactlab.reports.figures import FAINT, MUTED, house_style
from contactlab.reports.units import Units


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
    with house_style():
        figure = Figure(figsize=(8.6, float(np.clip(8.6 * height / width, 2.2, 7.0)) + 0.4), layout="constrained")
        axes = figure.subplots()
        cells = PolyCollection(
            list(corners), array=stress, cmap="cividis", edgecolors="face", linewidths=0.2, clim=(0.0, _top(stress))
        )
        axes.add_collection(cells)
        axes.autoscale_view()
        axes.set_aspect("equal")
        axes.grid(False)
        axes.set_xlabel(f"x [{units.length}]" if units.length else "x")
        axes.set_ylabel(f"y [{units.length}]" if units.length else "y")
        bar = figure.colorbar(
            cells, ax=axes, shrink=0.8, pad=0.02, extend="max" if stress.max() > _top(stress) else "neither"
        )
        bar.set_label(f"von Mises stress [{units.pressure}]" if units.pressure else "von Mises stress", color=MUTED)
        bar.outline.set_edgecolor(FAINT)
    return figure


def _top(stress: np.ndarray) -> float:
    """Upper end of the colours: a corner singularity must not leave the rest in the dark."""
    return float(np.percentile(stress, 99.5))
