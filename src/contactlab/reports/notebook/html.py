"""Notebook display of scenes, runs, comparisons and matrices: pictures, tables, warnings."""

from __future__ import annotations

import base64
from collections.abc import Callable, Mapping
from html import escape
from typing import Any

from contactlab.errors import ContactlabError
from contactlab.reports.matrix_table import matrix_sheet
from contactlab.reports.notebook.curves import curve_figure
from contactlab.reports.notebook.pictures import field_figure
from contactlab.reports.notebook.scene_picture import scene_figure
from contactlab.reports.notebook.texts import results_facts, scene_facts
from contactlab.reports.pressure_plot import pressure_figure
from contactlab.reports.sheet import facts
from contactlab.reports.table import runs_sheet
from contactlab.results.results import Results
from contactlab.scene.scene import Scene
from contactlab.studies.table import Table
from contactlab.verdicts.run import Matrix

STYLE = (
    ".contactlab .text{text-align:left;vertical-align:top} .contactlab .unit{display:block;font-weight:400} "
    ".contactlab .title{font-weight:600} .contactlab .refines{opacity:.7} .contactlab .reason td{text-align:left} "
    ".contactlab .met{color:#1a7f4b} .contactlab .missed{color:#9a5b00} .contactlab :is(.failed,.silent){color:#b42318}"
)
WARNING = "border-left:4px solid #9a5b00;padding:.2em .8em;margin:.4em 0"
FAULT = "border-left:4px solid #b42318;padding:.2em .8em;margin:.4em 0"
SHOWN = ("pressure_error", "reaction_error", "reaction", "max_penetration", "steps", "cpu_s")


def scene_html(scene: Scene) -> str:
    """A picture of the meshes, what the scene consists of, and all of it as TOML to be unfolded."""
    picture = _picture(lambda: scene_figure(scene))
    whole = f"<details><summary>TOML</summary><pre>{escape(scene.toml())}</pre></details>"
    return _block(f"Scene {escape(scene.name)}", _facts(scene_facts(scene)), picture, whole)


def results_html(results: Results) -> str:
    """Status of the run, its warnings, the von Mises stress at the end and the contact pressures."""
    facts = results_facts(results)
    reason = facts.pop("reason", "")
    said = [f'<div style="{FAULT}">{escape(reason)}</div>'] if reason else []
    said += [f'<div style="{WARNING}"><b>{escape(w.code)}</b>: {escape(w.text)}</div>' for w in results.warnings]
    shown = [_picture(lambda: field_figure(results, "von_mises", -1))]
    for contact in results.layout.contacts[:2]:
        curves = results.contact[contact.name].curves
        if curves:
            heading = f"<p><b>{escape(contact.title)}</b></p>"
            last = curves[-1]
            drawn = _picture(lambda last=last: curve_figure(last, results.layout.units))  # type: ignore[misc]
            shown.append(heading + drawn)
    title = f"{escape(results.layout.title)}: {escape(results.status)}"
    return _block(title, *said, _facts(facts), *shown)


def table_html(table: Table) -> str:
    """A row per run, failures with their reason, warnings, and the pressures of all runs."""
    drawn = _picture(lambda: pressure_figure(table)) if any(row.curve is not None for row in table.main) else ""
    return _block(escape(table.study.name), runs_sheet(table, SHOWN).html(), drawn)


def matrix_html(matrix: Matrix) -> str:
    """A line per case and variant, a column per algorithm; the verdict, and its reason when it is pointed at."""
    return _block(f"Matrix of {len(matrix.cells)} cells", matrix_sheet(matrix).html())


def _picture(draw: Callable[[], Any]) -> str:
    """A figure as an image, or the reason if it cannot be drawn."""
    try:
        data = base64.b64encode(draw()._repr_png_()).decode()
    except ContactlabError as error:
        return f"<p><i>no picture: {escape(str(error))}</i></p>"
    return f'<img style="max-width:100%" alt="figure" src="data:image/png;base64,{data}">'


def _facts(lines: Mapping[str, str]) -> str:
    return facts("", lines.items()).html()


def _block(title: str, *parts: str) -> str:
    return f"<div class=contactlab><style>{STYLE}</style><h4>{title}</h4>{''.join(parts)}</div>"
