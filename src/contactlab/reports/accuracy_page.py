"""`accuracy.html`: the page of a study of cases, one file with everything in it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from html import escape
from pathlib import Path

from matplotlib.figure import Figure

from contactlab.accuracy.evaluation import Evaluation
from contactlab.accuracy.run import WAITING, Accuracy
from contactlab.accuracy.targets import Cost, best_of
from contactlab.jobs.system import commit, system_facts
from contactlab.reports.accuracy_explore import Place, explore_section
from contactlab.reports.accuracy_plots import cost_figure, solved_figure
from contactlab.reports.accuracy_runs import write_run_pages
from contactlab.reports.accuracy_tables import (
    beside_sheet,
    limits_sheet,
    orders_sheet,
    points_sheet,
    references_sheet,
    target_sheet,
    winners_by_case,
)
from contactlab.reports.figures import laid_out, save
from contactlab.reports.html import ASSETS, document, facts_list, figure_section, section
from contactlab.reports.numbers import percent
from contactlab.reports.sheet import Sheet

_FRONT = (
    "Lower left is better. Each line is a method with the better of its slaves, and the other slave if it has a point "
    "of the front; numbers are mesh levels. The broad grey step is the front: no other run is both cheaper and "
    "more accurate. In the hatched band the reference is too uncertain. Crosses above are failed runs, arrowheads runs "
    "stopped at their limit. CPU seconds are medians of the steps, of one thread."
)
_SOLVED = (
    "A question is a case, a slave and a target that the reference can resolve. A line rises when a method meets "
    "another target; questions that it does not meet, or does not support, keep it below 100 %. The pale line is the "
    "best method of each question separately. Numbers: questions that are met, of all that a method supports."
)


def write_accuracy_page(evaluated: Evaluation, folder: Path, files: bool = True) -> None:
    """Write the page into the folder, and its figures as `files` of their own."""
    found = evaluated.found
    figures = {
        "error-against-cost": laid_out(cost_figure(found, evaluated.lines)),
        "solved": laid_out(solved_figure(found, evaluated.profiles)),
    }
    if files:
        for name, figure in figures.items():
            save(figure, folder, name)
    pages = write_run_pages(found, folder)
    (folder / "accuracy.html").write_text(page(evaluated, figures, pages), encoding="utf-8")


def page(evaluated: Evaluation, figures: dict[str, Figure], pages: Mapping[Place, str]) -> str:
    """The page as one HTML text that needs no other file; `pages` are where points lead to."""
    found = evaluated.found
    style = (ASSETS / "accuracy.css").read_text(encoding="utf-8")
    script = (ASSETS / "accuracy.js").read_text(encoding="utf-8")
    table = (
        f"<details><summary>{len(evaluated.orders)} lines</summary>{orders_sheet(evaluated.orders).html()}</details>"
    )
    sections = [
        f"<style>\n{style}</style>",
        _head(found),
        section("Cheapest method", _WINNERS + winners_by_case(found, evaluated.winners).html("costs winners")),
        figure_section(figures, "error-against-cost", "Error against cost, all cases", _FRONT),
        _costs(found, evaluated.costs),
        explore_section(found, evaluated.lines, pages),
        figure_section(figures, "solved", "Share of targets met in a given time", _SOLVED, narrow=True),
        _told("Distance from the optimum", _LIMITS, limits_sheet(found, evaluated.lines)),
        section("Orders of convergence", _ORDERS + table if evaluated.orders else ""),
        _told("Further costs", "", beside_sheet(found, evaluated.lines)),
        _points(found, pages),
        _told("The cases and their references", "", references_sheet(found.asked)),
        section("Machine and versions", facts_list(dict(system_facts()))),
        f"<script>\n{script}</script>",
    ]
    return document(found.study.name, sections)


def _head(found: Accuracy) -> str:
    finished = sum(point.finished for point in found.points)
    waiting = sum(point.status == WAITING for point in found.points)
    later = f" {waiting} points are still to come: reload the page, it is rewritten as they come." if waiting else ""
    rest: dict[str, int] = {}
    for point in found.points:
        if not point.finished and point.status != WAITING:
            rest[point.status] = rest.get(point.status, 0) + 1
    told = ", ".join(f"{count} {status}" for status, count in rest.items())
    beside = (
        f" {found.side_by_side} runs ran in parallel, which disturbs their times." if found.side_by_side > 1 else ""
    )
    facts = system_facts()
    made = f"{datetime.now(UTC):%Y-%m-%d}, contactlab {facts['contactlab']} {commit()}, {facts['processor']}".strip()
    files = ", ".join(f'<a href="{name}.csv">{name}.csv</a>' for name in ("accuracy", "winners", "costs"))
    return (
        f"<header>\n<h1>{escape(found.study.name)}</h1>\n"
        f'<p class="lead">{len(found.asked)} case{"s" * (len(found.asked) > 1)}, {len(found.contenders)} contenders, '
        f"{len(found.points)} points: "
        f"{finished} finished{f', {told}' if told else ''}.{beside}"
        f"{later}{' The study was interrupted.' if found.interrupted else ''}</p>\n"
        f'<p class="note">{escape(made)}. Rows of the figures: {files}.</p>\n</header>'
    )


_ORDERS = (
    "<p>q of error ~ C h<sup>q</sup> by least squares over points above the uncertainty of the reference, with its "
    "95 % interval; theory as the case gives it.</p>"
)
_LIMITS = (
    "<p>Efficiency: the error (in L2) of the best approximation of the exact pressure on the same slave nodes over "
    "the error of the run, at its finest level; with the better slave. At 1 no algorithm could do better on this mesh, "
    "at 0.5 one with half of the error is possible. Pressures are compared as continuous piecewise linear functions, "
    "also pressures of constant multipliers and of nodal forces. In brackets the level.</p>"
)
_COSTS = (
    "<p>CPU seconds of the cheapest run of each method that meets the target, with the better of its slaves. "
    "\N{BLACK STAR} is the cheapest, \N{ALMOST EQUAL TO} are methods that tie "
    "with it: their intervals overlap. \N{LESS-THAN OR EQUAL TO}: the coarsest mesh is already that good. "
    "\N{HORIZONTAL ELLIPSIS}: below three times the uncertainty of the reference. \N{MIDDLE DOT}: the case is not made "
    "for it. Hover for intervals and reasons.</p>"
)
_WINNERS = (
    "<p>The method that meets an error at the least cost: the median CPU time of the steps of a mesh that was run. "
    "Methods tie if the intervals of repeated runs, with the uncertainty of the reference, overlap. "
    "\N{LESS-THAN OR EQUAL TO}: the coarsest mesh is already that good. Empty: not requested.</p>"
)
_USUAL = 0.01


def _filter(table: str, what: str) -> str:
    """A field that leaves rows with certain words in the element `table`."""
    return (
        f'<input class="filter" data-table="{table}" type="search" placeholder="words that a {what} must have" '
        f'aria-label="filter the {what}s">'
    )


def _told(title: str, text: str, sheet: Sheet) -> str:
    """A section with a table; empty if that has no row."""
    return section(title, text + sheet.html() if sheet.rows else "")


def _costs(found: Accuracy, costs: Sequence[Cost]) -> str:
    """A table per target, one of them shown, all of them printed."""
    targets, best = found.targets, best_of(costs)
    first = _USUAL if _USUAL in targets else targets[0]
    tabs, tables, rules = [], [], []
    for number, target in enumerate(targets):
        checked, label = " checked" if target == first else "", f"{percent(target, 1)} %"
        tabs.append(
            f'<input type="radio" name="target" id="target-{number}"{checked}>'
            f'<label class="tab" for="target-{number}">{label}</label>'
        )
        table = target_sheet(found, best, target).html("costs", caption=f"CPU seconds to {label}")
        tables.append(f'<div class="target t{number}">{table}</div>')
        rules.append(f"#target-{number}:checked ~ .t{number} {{ display: block; }}")
    style = f"<style>{' '.join(rules)}</style>"
    parts = "".join((*tabs, *tables))
    filtered = f'{_filter("targets", "contender")}<div class="targets" id="targets">{parts}</div>'
    return section("CPU seconds to an accuracy", f"{_COSTS}{style}{filtered}")


def _points(found: Accuracy, pages: Mapping[Place, str]) -> str:
    table = points_sheet(found, pages).html("points all", "points", sortable=True)
    summary = f"<summary>{len(found.points)} points</summary>"
    return section("All points", f"<details>{summary}{_filter('points', 'row')}{table}</details>")
