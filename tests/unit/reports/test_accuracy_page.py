"""The page of a study of cases: what it holds, and what a browser makes of it."""

from __future__ import annotations

import html
import json
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from tiers import some

from contactlab.accuracy.evaluation import evaluate
from contactlab.accuracy.point import Point
from contactlab.accuracy.run import WAITING, Accuracy, Asked
from contactlab.accuracy.study import CaseStudy
from contactlab.api import ContactCurve, Record
from contactlab.jobs.archive import FILE, Archive, StoredRun
from contactlab.jobs.record import to_bytes
from contactlab.jobs.system import machine
from contactlab.reports.accuracy_page import page, write_accuracy_page
from contactlab.reports.accuracy_plots import cost_figure

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
CASES = [f"case {n}" for n in range(9)]
CONTENDERS = [f"{algorithm} {element} {way}" for algorithm in ("mortar-p0", "mortar-p1", "node-on-segment")
              for element in ("q1", "q2") for way in ("statics", "explicit")]  # fmt: skip

ASK = """<script>addEventListener("load", () => setTimeout(() => {
  const told = {wide: document.documentElement.scrollWidth - document.documentElement.clientWidth};
  const shown = () => Bokeh.documents[0].get_model_by_name("points-shown").data;
  told.first = shown().x.length;
  const choices = document.querySelector(".explore form");
  choices.elements.case.value = "case 3";
  choices.querySelector("input[value='mortar-p0']").checked = false;
  choices.dispatchEvent(new Event("change", {bubbles: true}));
  told.cases = [...new Set(shown().case)]; told.algorithms = [...new Set(shown().algorithm)];
  told.pages = shown().page.filter(Boolean);
  const field = document.querySelector("input[data-table=targets]");
  field.value = "q2 explicit"; field.dispatchEvent(new Event("input"));
  told.rows = [...document.querySelectorAll(".t0 tbody")].filter((row) => !row.hidden).length;
  document.title = JSON.stringify(told);
}, 500));</script>"""


def study() -> Accuracy:
    """1080 points of order 1 with costs in proportion to the cells; one has failed, one has a run."""
    asked = [Asked(name, "title", "L2", "exact", 1e-3, 1.0, "") for name in CASES]
    points = [
        Point(case, name, slave, level, "finished", "", 0.1 * (1 + k) / level, (0.05 * (2 + k) * level**2,), 3e-3,
              {"steps": 1.0, "iterations": 5.0})
        for case in CASES for k, name in enumerate(CONTENDERS) for slave in ("declared", "exchanged")
        for level in (1, 2, 3, 4, 6)
    ]  # fmt: skip
    points[1] = Point(CASES[0], CONTENDERS[0], "declared", 2, "diverged", "<it> moved apart")
    place = next(n for n, p in enumerate(points) if (p.case, p.contender) == ("case 3", "mortar-p1 q1 statics"))
    points[place] = Point(*(getattr(points[place], name) for name in ("case", "contender", "slave", "level", "status")),
                          "", 0.05, (0.2,), 3e-3, {"steps": 1.0}, runs=("key-of-it",))  # fmt: skip
    return Accuracy(CaseStudy((), (), name="a study"), asked, CONTENDERS, points, 1)


def first(cases: int) -> Accuracy:
    """The same of fewer cases."""
    whole = study()
    return replace(whole, asked=whole.asked[:cases], points=[p for p in whole.points if p.case in CASES[:cases]])


def two() -> Accuracy:
    """One case of which a point has failed, and one of which a point has a run."""
    whole = study()
    asked = [asked for asked in whole.asked if asked.label in (CASES[0], CASES[3])]
    return replace(whole, asked=asked, points=[p for p in whole.points if p.case in (CASES[0], CASES[3])])


def record() -> Record:
    s = np.linspace(0.0, 1.0, 5)
    columns = dict.fromkeys(ContactCurve.COLUMNS, s)
    return Record(
        "finished", "", {"steps": 3, "status": "finished"}, {"time": s, "energy.stored": s**2},
        {"contacts.0": np.array([1.0])}, {"contacts.0": [ContactCurve(**columns)]},
    )  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("page")
    with Archive(made / FILE) as archive:
        end = ("finished", "", 3.0, 0.2, to_bytes(record()))
        archive.add_run(StoredRun("key-of-it", "case 3 pressed", 'name = "pressed"\n', *end, machine()))
    write_accuracy_page(evaluate(two()), made)
    return made


@pytest.mark.full
def test_a_page_is_one_file_of_five_megabytes(folder: Path) -> None:
    page = folder / "accuracy.html"
    text = page.read_text(encoding="utf-8")
    assert page.stat().st_size < 5e6
    own = re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL)  # the library's text names its home page
    assert not re.search(r'(src|href)="(https?:)?//', own)
    assert "<script src" not in text
    points = text.partition('id="points"')[2].partition("</table>")[0]
    assert points.count('<tbody class="run">') == len(two().points)
    assert "&lt;it&gt; moved apart" in text


@pytest.mark.full
@pytest.mark.parametrize("cases", some([1, 2, 3, 9], [3]))
def test_the_legend_of_the_figure_is_within_it(cases: int) -> None:
    figure = cost_figure(found := first(cases), evaluate(found).lines)
    FigureCanvasAgg(figure).draw()
    (legend,) = figure.legends
    box = legend.get_window_extent()
    assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1
    assert figure.bbox.y0 <= box.y0 < box.y1 <= figure.axes[-1].get_window_extent().y0


def test_a_page_that_is_not_whole_says_what_is_to_come() -> None:
    found = first(1)
    points = [Point(p.case, p.contender, p.slave, p.level, WAITING, "not run yet") for p in found.points[1:]]
    text = page(evaluate(replace(found, points=[found.points[0], *points])), {}, {})
    assert "120 points: 1 finished. 119 points are still to come: reload the page" in text


@pytest.mark.full
def test_a_point_leads_to_the_page_of_its_run(folder: Path) -> None:
    (page,) = (folder / "runs").glob("*.html")
    assert f"runs/{page.name}" in (folder / "accuracy.html").read_text(encoding="utf-8")
    text = page.read_text(encoding="utf-8")
    for part in ("contact pressure at the end", "stored", "CPU time, s", page.with_suffix(".toml").name, "pressed"):
        assert part in text
    assert page.with_suffix(".toml").read_text() == 'name = "pressed"\n'
    assert not re.search(r'(src|href)="(https?:)?//', text)
    before, whole = page.stat().st_mtime_ns, study()
    one = replace(whole, asked=whole.asked[3:4], points=[p for p in whole.points if p.case == "case 3"])
    write_accuracy_page(evaluate(one), folder)
    assert page.stat().st_mtime_ns == before  # made once


@pytest.mark.full
@pytest.mark.skipif(BROWSER is None, reason="no Chromium here")
@pytest.mark.parametrize("width", [1300, 500])
def test_a_browser_draws_and_filters(folder: Path, tmp_path: Path, width: int) -> None:
    asked = folder / f"asked-{width}.html"
    asked.write_text((folder / "accuracy.html").read_text(encoding="utf-8") + ASK, encoding="utf-8")
    words = [str(BROWSER), "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--dump-dom",
             "--virtual-time-budget=20000", f"--user-data-dir={tmp_path}", f"--window-size={width},900"]  # fmt: skip
    dom = subprocess.run([*words, asked.as_uri()], capture_output=True, text=True, check=True).stdout
    (title,) = re.findall(r"<title>(.*?)</title>", dom)[:1]
    told = json.loads(html.unescape(title))
    assert told["wide"] == 0
    assert told["first"] == sum(p.case == CASES[0] for p in study().points)  # the failed one, too
    assert told["cases"] == ["case 3"]
    assert told["algorithms"] == ["mortar-p1", "node-on-segment"]
    assert len(told["pages"]) == 1
    assert told["rows"] == 3


@pytest.mark.full
@pytest.mark.skipif(BROWSER is None, reason="no Chromium here")
def test_it_is_printed_without_empty_pages(tmp_path: Path) -> None:
    """Winners, five tables of twelve rows, two figures and short sections on A4: headings stay with what follows."""
    words = [str(BROWSER), "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--no-pdf-header-footer",
             "--virtual-time-budget=20000", f"--user-data-dir={tmp_path}"]  # fmt: skip
    printed = tmp_path / "page.pdf"
    write_accuracy_page(evaluate(study()), tmp_path)
    page = (tmp_path / "accuracy.html").as_uri()
    subprocess.run([*words, f"--print-to-pdf={printed}", page], capture_output=True, check=True)
    (pages,) = re.findall(rb"/Type /Pages\s+/Count (\d+)", printed.read_bytes())[:1]
    assert 4 <= int(pages) <= 8
