"""Force against displacement of every run of a comparison, in one plot."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from contactlab.api.drawing.units import Units
from contactlab.errors import RequestError
from contactlab.reports.figures import house_style, note
from contactlab.reports.notebook.canvas import canvas
from contactlab.reports.notebook.curves import draw_force, remark
from contactlab.reports.series import series_of, series_styles
from contactlab.results.force_curve import ForceCurve, force_curve
from contactlab.studies.table import Row, Table
from contactlab.studies.varied_text import varied_text

LINES = ("-", (0, (5, 1.2)), (0, (1.2, 1.2)), (0, (5, 1.2, 1.2, 1.2)))
"""Line styles by slave, level and further choices; colours are by algorithm."""
MANY = 12
"""Lines in the legend beyond which it is drawn outside the plot, small."""


def force_figure(table: Table, on: str = "", component: str = "", ax: Axes | None = None) -> Figure:
    """The curves of the driven support, or of the support or contact `on`. Raises RequestError for an unknown one."""
    rows = table.main
    curves = [(row, curve) for row in rows if (curve := curve_of(row, on, component)) is not None]
    units, chosen = Units.of_label(table.scene.get("units")), series_styles(table.rows)
    kinds = list(dict.fromkeys(map(_kind, rows)))
    with house_style():
        figure, axes = canvas(ax, 4.2)
        if not curves:
            note(axes, "no run has a force and a displacement")
        for row, curve in curves:
            colour = chosen[series_of(row, table.rows)].colour
            style = LINES[kinds.index(_kind(row)) % len(LINES)]
            draw_force(axes, curve, colour, label_of(row, rows), units, style)
        if curves:
            if len(curves) > MANY:
                axes.legend(fontsize=6.5, loc="center left", bbox_to_anchor=(1.01, 0.5))
            else:
                axes.legend(fontsize=8.0)
            remark(axes, [curve for _, curve in curves])
    return figure


def _kind(row: Row) -> tuple[str, int, str]:
    return row.slave, row.level, varied_text(row.choices)


def curve_of(row: Row, on: str = "", component: str = "") -> ForceCurve | None:
    """The curve of a run; None if it left none. Raises RequestError for an unknown support of a run that left some."""
    if not any(name.endswith(".fx") for name in row.history) or not len(row.history["time"]):
        return None
    return force_curve(row.history, on, {"history": {"curve": row.path}}, component)


def label_of(row: Row, rows: Sequence[Row]) -> str:
    """Label of a run: algorithm, choices, slave and level as far as they differ, and its status if not finished."""
    texts = [series_of(row, rows)]
    if len({each.slave for each in rows}) > 1:
        texts.append(f"slave {row.slave}")
    if len({each.level for each in rows}) > 1:
        texts.append(f"level {row.level}")
    return ", ".join(texts) + ("" if row.finished else f" ({row.status})")


def has_curves(table: Table) -> bool:
    """Return whether any run has a curve of at least 3 states."""
    try:
        return any(curve is not None and len(curve.x) > 2 for curve in map(curve_of, table.main))
    except RequestError:
        return False
