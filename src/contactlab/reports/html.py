"""Pieces of the report pages: the frame, sections, figures, tables, facts."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from html import escape
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from matplotlib.figure import Figure

from contactlab.reports.figures import inline_svg
from contactlab.reports.numbers import significant
from contactlab.scene.toml_text import write_toml
from contactlab.studies.table import Table

ASSETS = Path(__file__).parent.parent / "data" / "report"
"""Styles, scripts and templates of pages."""


@cache
def _environment() -> Environment:
    return Environment(loader=FileSystemLoader(ASSETS), autoescape=True, undefined=StrictUndefined, trim_blocks=True)


def filled(name: str, **values: Any) -> str:
    """Fill the template of this name; what is filled in is escaped."""
    return _environment().get_template(name).render(**values)


def document(title: str, sections: Iterable[str]) -> str:
    """Write a whole page that needs no other file."""
    style, script = ((ASSETS / name).read_text(encoding="utf-8") for name in ("page.css", "page.js"))
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>\n{style}</style>\n</head>\n<body>\n<main>\n"
        + "\n".join(filter(None, sections))
        + f"\n</main>\n<script>\n{script}</script>\n</body>\n</html>\n"
    )


def section(title: str, content: str) -> str:
    """A section with a title; an empty string if it has no content."""
    return f"<section>\n<h2>{escape(title)}</h2>\n{content}\n</section>" if content else ""


def figure_section(figures: dict[str, Figure], name: str, title: str, caption: str, narrow: bool = False) -> str:
    """The figure of a name with its caption, empty if it was not drawn."""
    if name not in figures:
        return ""
    svg = inline_svg(figures[name], name, escape(title))
    kind = ' class="narrow"' if narrow else ""
    return section(title, f"<figure{kind}>\n{svg}\n<figcaption>{escape(caption)}</figcaption>\n</figure>")


def facts_list(facts: dict[str, Any]) -> str:
    """Write a list of names with their values."""
    rows = "".join(f"<dt>{escape(str(name))}</dt><dd>{escape(str(value))}</dd>\n" for name, value in facts.items())
    return f'<dl class="facts">\n{rows}</dl>'


def scene_section(table: Table) -> str:
    """Write the study and the scene as a section that unfolds."""
    study = f"<details><summary>The study</summary><pre>{escape(write_toml(table.study.as_data()))}</pre></details>"
    heading = "<summary>The scene, all defaults written out</summary>"
    return section("What was run", f"{study}<details>{heading}<pre>{escape(table.scene_text)}</pre></details>")


def machine_section(table: Table) -> str:
    """Processor, versions and parts, and how long all of it took."""
    facts = dict(table.rows[0].system) if table.rows else {}
    facts["whole comparison"] = f"{significant(table.wall_s, 3)} s of wall time, several runs at a time"
    parts = dict.fromkeys(f"{role}: {part}" for row in table.rows for role, part in dict(row.parts).items())
    return section(
        "Machine and versions", facts_list(facts) + "".join(f'<p class="note">{escape(part)}</p>\n' for part in parts)
    )
