"""`report.html` of a breakdown: one table, one plot, and what was run."""

from __future__ import annotations

from html import escape
from pathlib import Path

from contactlab.reports.breakdown_plot import breakdown_figure
from contactlab.reports.breakdown_table import EXPLANATION, HEADS, by_cost, cells, reasons, sentence
from contactlab.reports.figures import save
from contactlab.reports.html import document, figure_section, machine_section, plain_table, scene_section, section
from contactlab.studies.cost_breakdown import CostBreakdown
from contactlab.studies.table import Table

_PLOT = (
    "Each point is an effect. Full: the scene declares it, and it was taken out. Hollow: the scene leaves it out, "
    "and it was added. Points far up matter to the answer; points far to the right cost much."
)


def write_breakdown_report(table: Table, breakdown: CostBreakdown, folder: Path) -> None:
    """Write `report.html` and the plot (SVG and PNG) into the folder."""
    figure = breakdown_figure(breakdown)
    save(figure, folder, "bill")
    notes = "".join(f'<p class="note">{escape(text)}</p>\n' for text in reasons(breakdown.effects))
    rows = (cells(cost, breakdown) for cost in by_cost(breakdown))
    head = (
        f'<header>\n<h1>{escape(table.study.name)}</h1>\n<p class="lead">{escape(sentence(breakdown))}</p>\n</header>'
    )
    explanation = f'<p class="note">{escape(EXPLANATION)}</p>\n'
    sections = [
        head,
        section("What each effect costs and changes", plain_table(HEADS, rows, texts=2) + explanation + notes),
        figure_section({"bill": figure}, "bill", "Which effects the scene needs", _PLOT, narrow=True),
        scene_section(table),
        machine_section(table),
    ]
    (folder / "report.html").write_text(document(table.study.name, sections), encoding="utf-8")
