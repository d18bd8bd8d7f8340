"""The report is one well-formed page with every run in it and nothing from elsewhere."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest

from contactlab.api import RunWarning
from contactlab.reports.page import draw, page, write_report
from contactlab.studies.table import Row, Table

VOID = {"meta", "br", "link", "img", "input", "hr"}


class Outline(HTMLParser):
    """Checks that tags close in order; gathers texts, links, table runs and SVG source."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.texts: list[str] = []
        self.references: list[str] = []
        self.identifiers: list[str] = []
        self.runs: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = dict(attrs)
        self.references += [str(found[name]) for name in ("src", "href", "xlink:href", "action") if name in found]
        self.identifiers += [str(found["id"])] if "id" in found else []
        if found.get("class") == "run":
            self.runs.append("")
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts.append(data)
        if self.runs and "tbody" in self.open:
            self.runs[-1] += data


@pytest.fixture(scope="module")
def text(shared_table: Table) -> str:
    return page(shared_table, draw(shared_table))


@pytest.fixture(scope="module")
def outline(text: str) -> Outline:
    found = Outline()
    found.feed(text)
    return found


@pytest.mark.full
def test_tags_close_and_identifiers_are_unique(outline: Outline) -> None:
    assert outline.open == []
    assert len(set(outline.identifiers)) == len(outline.identifiers)


def test_every_run_is_in_the_table_with_its_status_and_reason(outline: Outline, table: Table) -> None:
    runs = outline.runs[: len(table)]
    for row, run in zip(table, runs, strict=True):
        for part in (row.algorithm, row.slave, str(row.level), row.status, row.reason):
            assert part in run


@pytest.mark.full
def test_what_a_run_says_against_itself_stands_beneath_it(table: Table) -> None:
    seen = RunWarning("other-slave", 3.0, 2.0, "contacts.0.swap", "segments are 3 <times> as long; swap")
    rows = [replace(row, warnings=[seen]) if row.name == "beta-disc-2" else row for row in table.rows]
    warned, outline = replace(table, rows=rows), Outline()
    outline.feed(page(warned, draw(warned)))
    told = [seen.text in text and seen.code in text for text in outline.runs[: len(table)]]
    assert told == [row.name == "beta-disc-2" for row in table]


def test_nothing_comes_from_elsewhere(outline: Outline, text: str) -> None:
    assert all(reference.startswith(("#", "data:")) for reference in outline.references)
    assert "@import" not in text
    assert "url(http" not in text


def test_it_says_what_it_compares_with_and_how_good_that_is(outline: Outline) -> None:
    text = " ".join(outline.texts)
    for part in (
        "A parabola",
        "Closed form, <by hand>.",
        "0.10 %",
        "666.7 ± 0.5",
        "nobody 2005",
        "numpy",
        "processor",
    ):
        assert part in text


def test_the_lead_names_the_most_accurate_finished_run(outline: Outline) -> None:
    lead = next(text for text in outline.texts if "most accurate" in text)
    assert "4 runs at level 2, 2 finished" in lead
    assert "beta (slave disc): 1.0 %" in lead


@pytest.mark.full
def test_plots_are_written_as_svg_and_png(table: Table, tmp_path: Path) -> None:
    write_report(table, tmp_path)
    for name in ("pressure", "error-against-cost", "bodies"):
        ET.parse(tmp_path / f"{name}.svg")
        assert (tmp_path / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    assert (tmp_path / "report.html").read_text().startswith("<!DOCTYPE html>")


@pytest.mark.full
def test_a_comparison_of_which_nothing_is_left_still_has_a_page(table: Table) -> None:
    def dead(row: Row) -> Row:
        return Row(row.name, row.algorithm, row.slave, row.level, row.varied, "failed", "gone", notes=["no pressure"])

    empty = Table([dead(row) for row in table], table.study, None, table.scene)
    found = Outline()
    found.feed(page(empty, draw(empty)))
    assert found.open == []
    assert sum("gone" in text for text in found.runs) == len(table)
    assert "Pressure error not computed: no pressure." in " ".join(found.texts)
