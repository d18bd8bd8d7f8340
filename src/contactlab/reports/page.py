"""`report.html`: one file with everything in it, and the plots as files next to it."""

from __future__ import annotations

import math
from html import escape
from pathlib import Path

from matplotlib.figure import Figure

from contactlab.api.drawing.colours import Style, styles
from contactlab.api.drawing.units import Units
from contactlab.reports.body_plot import body_figure, shown_row
from contactlab.reports.cost_plot import cost_figure
from contactlab.reports.figures import laid_out, save
from contactlab.reports.findings import Finding, findings, heading, sentence, span
from contactlab.reports.force_plot import force_figure, has_curves
from contactlab.reports.html import (
    document,
    facts_list,
    figure_section,
    machine_section,
    scene_section,
    section,
)
from contactlab.reports.numbers import percent, uncertain
from contactlab.reports.pressure_plot import is_map, pressure_figure
from contactlab.reports.sheet import Sheet, numbers
from contactlab.reports.table import runs_sheet, table_tex, times_sheet
from contactlab.studies.reference import Reference
from contactlab.studies.table import Table
from contactlab.studies.table_files import agreements


def write_report(table: Table, folder: Path) -> None:
    """Write `report.html`, `table.tex` and the plots (SVG and PNG) into the folder."""
    if table.breakdown is not None:
        from contactlab.reports.breakdown_plot import write_breakdown_report

        write_breakdown_report(table, table.breakdown, folder)
        return
    figures = {name: laid_out(figure) for name, figure in draw(table).items()}
    for name, figure in figures.items():
        save(figure, folder, name)
    (folder / "report.html").write_text(page(table, figures), encoding="utf-8")
    (folder / "table.tex").write_text(table_tex(table), encoding="utf-8")


def draw(table: Table) -> dict[str, Figure]:
    """Draw all figures; returns them by the name of their files."""
    figures = {"pressure": pressure_figure(table)}
    if has_curves(table):
        figures["force"] = force_figure(table)
    if any(row["pressure_error"] > 0.0 for row in table.rows):
        figures["error-against-cost"] = cost_figure(table)
    bodies = body_figure(table)
    return figures if bodies is None else {**figures, "bodies": bodies}


def page(table: Table, figures: dict[str, Figure]) -> str:
    """The report as one HTML text that needs no other file."""
    chosen = styles(row.algorithm for row in table.rows)
    pressure = _PRESSURE if table.reference is None else _PRESSURE + _PRESSURE_REFERENCE
    notes = dict.fromkeys(note for row in table.rows for note in row.notes)
    meanings = {column.title: column.meaning for column in table.measures}
    row = shown_row(table)
    bodies = "" if row is None else f"{row.algorithm}, slave {row.slave}, level {row.level}; one colour per cell."
    sections = [
        _head(table),
        _cards(table, chosen),
        figure_section(figures, "pressure", "Contact pressure", _MAP if is_map(table) else pressure),
        section("All runs", _runs(table) + "".join(f'<p class="note">{escape(note)}</p>\n' for note in notes)),
        figure_section(figures, "force", "Force against displacement", _FORCE, narrow=True),
        figure_section(figures, "error-against-cost", "What accuracy costs", _COST, narrow=True),
        figure_section(figures, "bodies", "The deformed bodies", bodies, narrow=True),
        _agreement(table),
        _times(table),
        _reference(table.reference, table),
        scene_section(table),
        machine_section(table),
        section("What the columns mean", f"<details><summary>All columns</summary>{facts_list(meanings)}</details>"),
    ]
    return document(heading(table), sections)


_PRESSURE = (
    "Markers are the nodal values of the multiplier, joined by their linear interpolant, over the deformed position. "
    "A dashed line belongs to a run that did not finish; its last frame is shown."
)
_PRESSURE_REFERENCE = " Grey: the reference; errors are relative L2 distances from it."
_FORCE = (
    "A line per run, along the motion of the driven support: a positive force resists it. Colours are algorithms, line "
    "styles all other choices. Thin lines: dynamic runs, whose final state alone is in equilibrium."
)
_MAP = (
    "A line per run, pressure as colour over the deformed position; a reference is the last line. A run that did not "
    "finish says how it ended; its last frame is shown."
)
_COST = (
    "Further left is cheaper, further down more accurate. Each line is one algorithm with one choice of slave; "
    "the numbers are mesh levels. CPU seconds are of one thread, without imports, "
    "building, and compiling or loading kernels."
)
_TIMES = (
    "Wall time of the steps, including kernels compiled or loaded in them, and the share of each phase and its parts. "
    "Shares of material models and elements were measured at the end; implicit runs solve contact together with the "
    "bodies."
)


def _head(table: Table) -> str:
    source = table.scene.get("source", "")
    where = f" ({escape(source)})" if source else ""
    return (
        f"<header>\n<h1>{escape(heading(table))}</h1>\n"
        f'<p class="lead">Scene <code>{escape(str(table.scene.get("name", table.study.scene)))}</code>{where}. '
        f"{escape(sentence(table))}</p>\n</header>"
    )


def _cards(table: Table, chosen: dict[str, Style]) -> str:
    units = Units.of_label(table.scene.get("units"))
    cards = (_card(finding, chosen[finding.algorithm], units) for finding in findings(table))
    return f'<div class="cards">\n{"".join(cards)}</div>'


def _card(finding: Finding, style: Style, units: Units) -> str:
    """Peaks, cost, and errors if there is a reference."""
    state = "finished" if finding.finished == finding.runs else "failed"
    facts = [
        ("pressure error", finding.pressure_error, "%"), ("swap asymmetry S", finding.swap_asymmetry, "%"),
        ("peak force", finding.peak_force, units.line_force), ("peak pressure", finding.peak_pressure, units.pressure),
        ("CPU time", finding.cpu_s, "s"),
    ]  # fmt: skip
    shown = [fact for fact in facts if not math.isnan(fact[1][0])]
    return (
        f'<div class="card" style="--colour: {style.colour}"><h3>{escape(finding.algorithm)}</h3><dl>'
        + "".join(f"<dt>{name}</dt><dd>{span(values, unit)}</dd>" for name, values, unit in shown)
        + f'<dt>finished</dt><dd class="{state}">{finding.finished} of {finding.runs}</dd></dl></div>\n'
    )


def _runs(table: Table) -> str:
    """All runs with all measures; those beyond the usual ones are shown on demand."""
    switch = '<p><button class="switch" type="button" data-all="runs">Show all columns</button></p>'
    sheet = runs_sheet(table, [column.name for column in table.measures], links=True)
    return switch + sheet.html(name="runs", sortable=True)


def _times(table: Table) -> str:
    """Times by phase, folded away; empty if no run left a summary."""
    sheet = times_sheet(table)
    folded = f"<details><summary>{len(table)} runs, phase by phase</summary>{sheet.html()}</details>"
    return section("Times by phase", f"<p>{_TIMES}</p>{folded}" if sheet.rows else "")


def _agreement(table: Table) -> str:
    pairs = agreements(table.main)
    if not pairs:
        return ""
    varied = any(pair.varied for pair in pairs)
    rows = (
        [f"{pair.first} and {pair.second}", *[pair.varied] * varied, pair.slave, str(pair.level),
         percent(pair.reaction), percent(pair.pressure, 3)]
        for pair in pairs
    )  # fmt: skip
    heads = ["algorithms", *["with"] * varied, "slave"]
    sheet = Sheet([*heads, *numbers("level", "reaction difference, %", "pressure difference, %")], rows)
    text = "<p>Differences between two algorithms on the same run; no reference is involved.</p>"
    return section("Do the algorithms agree?", text + sheet.html())


def _reference(reference: Reference | None, table: Table) -> str:
    if reference is None:
        why = next((note for row in table.rows for note in row.notes), "no run left a pressure")
        return section("Reference", f'<p class="note">Pressure error not computed: {escape(why)}.</p>')
    meaning = escape(str(reference.error_estimate.get("meaning", "")))
    facts = {
        "solution": reference.title,
        "origin": reference.origin,
        "uncertainty of the pressure": f"{percent(reference.pressure_uncertainty)} % ({meaning})",
    }
    for name, scalar in reference.scalars.items():
        label = str(scalar.get("meaning", name))
        facts[label] = uncertain(float(scalar["value"]), float(scalar["error"]))
    if reference.window is not None:
        low, high = reference.window
        facts["compared over"] = f"{low:g} < x < {high:g}"
    return section("Reference", facts_list(facts))
