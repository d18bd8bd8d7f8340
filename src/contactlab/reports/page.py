"""`report.html`: one file with everything in it, and the plots beside it."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from contactlab.api.colours import Style, styles
from contactlab.compare.agreement import Agreement, agreements
from contactlab.compare.columns import MEASURES
from contactlab.compare.reference import Reference
from contactlab.compare.table import Table
from contactlab.reports.body_plot import body_figure, shown_row
from contactlab.reports.cost_plot import cost_figure
from contactlab.reports.figures import inline_svg, save
from contactlab.reports.findings import Finding, findings, sentence, span
from contactlab.reports.numbers import percent, significant, uncertain
from contactlab.reports.page_table import runs_table
from contactlab.reports.pressure_plot import pressure_figure
from contactlab.toml_text import write_toml

_ASSETS = Path(__file__).parent.parent / "data" / "report"


def write_report(table: Table, folder: Path) -> None:
    """Write `report.html` and the plots (SVG and PNG) into the folder."""
    figures = draw(table)
    for name, figure in figures.items():
        save(figure, folder, name)
    (folder / "report.html").write_text(page(table, figures), encoding="utf-8")


def draw(table: Table) -> dict[str, Figure]:
    """All figures by the name of their files."""
    figures = {"pressure": pressure_figure(table), "error-against-cost": cost_figure(table)}
    bodies = body_figure(table)
    return figures if bodies is None else {**figures, "bodies": bodies}


def page(table: Table, figures: dict[str, Figure]) -> str:
    """The report as one HTML text that needs no other file."""
    chosen = styles(row.algorithm for row in table.rows)
    sections = [
        _head(table),
        _cards(table, chosen),
        _figure(figures, "pressure", "Contact pressure", _PRESSURE),
        _section("All runs", runs_table(table, chosen) + _notes(table)),
        _figure(figures, "error-against-cost", "What accuracy costs", _COST, narrow=True),
        _agreement(table),
        _figure(figures, "bodies", "The deformed bodies", _bodies_caption(table), narrow=True),
        _reference(table.reference, table),
        _scene(table),
        _machine(table),
        _glossary(),
    ]
    style, script = ((_ASSETS / name).read_text(encoding="utf-8") for name in ("page.css", "page.js"))
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(table.study.name)}</title>\n<style>\n{style}</style>\n</head>\n<body>\n<main>\n"
        + "\n".join(filter(None, sections))
        + f"\n</main>\n<script>\n{script}</script>\n</body>\n</html>\n"
    )


_PRESSURE = (
    "Grey: the reference. Markers are the nodal values of the multiplier, joined by their linear interpolant, over the "
    "deformed position. A dashed line belongs to a run that did not finish; its last frame is shown. "
    "The errors are relative L2 distances from the reference."
)
_COST = (
    "Further left is cheaper, further down more accurate. Each line is one algorithm with one choice of slave; "
    "the numbers are mesh levels. CPU seconds are those of one thread, without import, building and the first step."
)


def _section(title: str, content: str) -> str:
    return f"<section>\n<h2>{escape(title)}</h2>\n{content}\n</section>" if content else ""


def _head(table: Table) -> str:
    source = table.scene.get("source", "")
    where = f" ({escape(source)})" if source else ""
    return (
        f"<header>\n<h1>{escape(table.study.name)}</h1>\n"
        f'<p class="lead">Scene <code>{escape(str(table.scene.get("name", table.study.scene)))}</code>{where}. '
        f"{escape(sentence(table))}</p>\n</header>"
    )


def _cards(table: Table, chosen: dict[str, Style]) -> str:
    cards = (_card(finding, chosen[finding.algorithm]) for finding in findings(table))
    return f'<div class="cards">\n{"".join(cards)}</div>'


def _card(finding: Finding, style: Style) -> str:
    state = "finished" if finding.finished == finding.runs else "failed"
    return (
        f'<div class="card" style="--colour: {style.colour}"><h3>{escape(finding.algorithm)}</h3><dl>'
        f"<dt>pressure error</dt><dd>{span(finding.pressure_error, '%')}</dd>"
        f"<dt>swap asymmetry S</dt><dd>{span(finding.swap_asymmetry, '%')}</dd>"
        f"<dt>CPU time</dt><dd>{span(finding.cpu_s, 's')}</dd>"
        f'<dt>finished</dt><dd class="{state}">{finding.finished} of {finding.runs}</dd></dl></div>\n'
    )


def _figure(figures: dict[str, Figure], name: str, title: str, caption: str, narrow: bool = False) -> str:
    if name not in figures:
        return ""
    svg = inline_svg(figures[name], name, escape(title))
    kind = ' class="narrow"' if narrow else ""
    return _section(title, f"<figure{kind}>\n{svg}\n<figcaption>{escape(caption)}</figcaption>\n</figure>")


def _notes(table: Table) -> str:
    notes = dict.fromkeys(note for row in table.rows for note in row.notes)
    return "".join(f'<p class="note">{escape(note)}</p>\n' for note in notes)


def _agreement(table: Table) -> str:
    pairs = agreements(table.main)
    if not pairs:
        return ""
    text = "<p>How far two algorithms are from each other on the same run; no reference is involved.</p>"
    heads = ("algorithms", "slave", "level", "reaction difference, %", "pressure difference, %")
    return _section("Do the algorithms agree?", text + _plain_table(heads, map(_agreement_cells, pairs), texts=2))


def _agreement_cells(pair: Agreement) -> tuple[str, ...]:
    names = f"{pair.first} and {pair.second}"
    return names, pair.slave, str(pair.level), percent(pair.reaction), percent(pair.pressure, 3)


def _plain_table(heads: Iterable[str], rows: Iterable[Iterable[str]], texts: int) -> str:
    """A table whose first `texts` columns are words."""

    def line(cells: Iterable[str], tag: str) -> str:
        kinds = (' class="text"' if k < texts else "" for k in range(100))
        return "".join(f"<{tag}{kind}>{escape(cell)}</{tag}>" for cell, kind in zip(cells, kinds, strict=False))

    body = "".join(f"<tr>{line(row, 'td')}</tr>\n" for row in rows)
    return f'<div class="scroll"><table><thead><tr>{line(heads, "th")}</tr></thead><tbody>{body}</tbody></table></div>'


def _bodies_caption(table: Table) -> str:
    row = shown_row(table)
    return "" if row is None else f"{row.algorithm}, slave {row.slave}, level {row.level}; one colour per cell."


def _reference(reference: Reference | None, table: Table) -> str:
    if reference is None:
        why = next((note for row in table.rows for note in row.notes), "no run left a pressure")
        return _section("Reference", f'<p class="note">There is no pressure error: {escape(why)}.</p>')
    meaning = escape(str(reference.error_estimate.get("meaning", "")))
    facts = {
        "solution": reference.title,
        "origin": reference.origin,
        "pressure known to": f"{percent(reference.pressure_uncertainty)} % ({meaning})",
    }
    for name, scalar in reference.scalars.items():
        label = str(scalar.get("meaning", name))
        facts[label] = uncertain(float(scalar["value"]), float(scalar["error"]))
    if reference.window is not None:
        low, high = reference.window
        facts["compared over"] = f"{low:g} < x < {high:g}"
    return _section("Reference", _facts(facts))


def _facts(facts: dict[str, Any]) -> str:
    rows = "".join(f"<dt>{escape(str(name))}</dt><dd>{escape(str(value))}</dd>\n" for name, value in facts.items())
    return f'<dl class="facts">\n{rows}</dl>'


def _scene(table: Table) -> str:
    study = f"<details><summary>The study</summary><pre>{escape(write_toml(table.study.as_data()))}</pre></details>"
    heading = "<summary>The scene, all defaults written out</summary>"
    return _section("What was run", f"{study}<details>{heading}<pre>{escape(table.scene_text)}</pre></details>")


def _machine(table: Table) -> str:
    facts = dict(table.rows[0].system) if table.rows else {}
    facts["whole comparison"] = f"{significant(table.wall_s, 3)} s of wall time, several runs at a time"
    return _section("Machine and versions", _facts(facts) + _parts(table))


def _parts(table: Table) -> str:
    parts = dict.fromkeys(f"{role}: {part}" for row in table.rows for role, part in dict(row.parts).items())
    return "".join(f'<p class="note">{escape(part)}</p>\n' for part in parts)


def _glossary() -> str:
    facts = {column.title: column.meaning for column in MEASURES}
    return _section("What the columns mean", f"<details><summary>All columns</summary>{_facts(facts)}</details>")
