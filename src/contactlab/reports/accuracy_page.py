"""`accuracy.html`: the page of a study of cases, one file with everything in it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from html import escape
from pathlib import Path

from matplotlib.figure import Figure

from contactlab.accuracy.evaluation import Evaluation
from contactlab.accuracy.files import COUNTS, point_row
from contactlab.accuracy.lines import Line
from contactlab.accuracy.orders import Order
from contactlab.accuracy.point import Point
from contactlab.accuracy.run import WAITING, Accuracy
from contactlab.jobs.system import commit, system_facts
from contactlab.reports.accuracy_costs import costs_section, winners_section
from contactlab.reports.accuracy_explore import Place, explore_section
from contactlab.reports.accuracy_plots import cost_figure, solved_figure
from contactlab.reports.accuracy_runs import write_run_pages
from contactlab.reports.figures import laid_out, save
from contactlab.reports.html import ASSETS, document, facts_list, figure_section, plain_table, section
from contactlab.reports.numbers import percent, significant

_FRONT = (
    "Lower left is better. Each line is a contender with the better of its slaves, and the other one if it has a point "
    "of the front; numbers are mesh levels. The broad grey step is the front: no other run is both cheaper and "
    "more accurate. In the hatched band the reference cannot tell. Crosses above are runs that failed, arrowheads runs "
    "stopped at their limit. CPU seconds are medians of the steps, of one thread."
)
_SOLVED = (
    "A question is a case, a slave and one of the targets that the reference can tell. A line rises where a contender "
    "has answered one more; what it does not answer, or cannot be put to, keeps it below 100 % for ever. The pale line "
    "is the best contender of each question by itself. Numbers: questions that are answered, of those that a "
    "contender can be put to."
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
    sections = [
        f"<style>\n{style}</style>",
        _head(found),
        winners_section(found, evaluated.winners),
        figure_section(figures, "error-against-cost", "Error against cost, all cases", _FRONT),
        costs_section(found, evaluated.costs),
        explore_section(found, evaluated.lines, pages),
        figure_section(figures, "solved", "How much is answered in a given time", _SOLVED, narrow=True),
        limits_section(found, evaluated.lines),
        _orders(evaluated.orders),
        _beside(found, evaluated.lines),
        points_section(found, pages),
        _references(found),
        section("Machine and versions", facts_list(dict(system_facts()))),
        f"<script>\n{script}</script>",
    ]
    return document(found.study.name, sections)


def _head(found: Accuracy) -> str:
    finished = sum(point.finished for point in found.points)
    waiting = sum(point.status == WAITING for point in found.points)
    later = f" {waiting} points are still to come: load the page again, it is rewritten as they do." if waiting else ""
    rest: dict[str, int] = {}
    for point in found.points:
        if not point.finished and point.status != WAITING:
            rest[point.status] = rest.get(point.status, 0) + 1
    told = ", ".join(f"{count} {status}" for status, count in rest.items())
    beside = (
        f" {found.side_by_side} runs were made side by side and disturbed each other." if found.side_by_side > 1 else ""
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


def _orders(orders: Sequence[Order]) -> str:
    if not orders:
        return ""
    text = (
        "<p>q of error ~ C h<sup>q</sup> by least squares over points above what the reference can tell, with its 95 % "
        "interval; theory as the case gives it.</p>"
    )
    heads = ("case", "contender", "slave", "order", "± 95 %", "levels", "theory")
    rows = (
        (o.case, o.contender, o.slave, f"{o.order:.2f}", "" if math.isnan(o.half) else f"{o.half:.2f}",
         " ".join(map(str, o.levels)), "" if math.isnan(o.theory) else f"{o.theory:g}")
        for o in orders
    )  # fmt: skip
    table = plain_table(heads, rows, texts=3)
    return section("Orders of convergence", f"{text}<details><summary>{len(orders)} lines</summary>{table}</details>")


def _beside(found: Accuracy, lines: Sequence[Line]) -> str:
    """Memory and first compilation: costs that CPU seconds of runs do not show."""
    rows = []
    for name in found.contenders:
        points = [p for line in lines if line.contender == name for p in line.finished]
        if points:
            memory = max((p.memory_mib for p in points if p.memory_mib > 0.0), default=math.nan)
            compiled = max((p.compile_s for p in points if p.compile_s >= 0.0), default=math.nan)
            kernels = [p.cost / p.calibration for p in points if p.calibration > 0.0]
            most = max(kernels, default=math.nan)
            rows.append((name, significant(memory, 3), significant(compiled, 2), significant(most, 2)))
    if not rows:
        return ""
    heads = ("contender", "largest memory, MiB", "longest compiling or loading, s", "dearest run, calibration kernels")
    return section("Costs beside", plain_table(heads, rows, texts=1))


def _references(found: Accuracy) -> str:
    heads = ("case", "question", "error that counts", "reference", "known to, %", "why")
    rows = (
        (a.label, a.title, a.measure, a.reference, percent(a.uncertainty) if a.uncertainty else "exact", a.why)
        for a in found.asked
    )
    return section("The cases and their references", plain_table(heads, rows, texts=4))


_TEXT = (
    "<p>Efficiency: the error (in L2) of the best approximation of the exact pressure on the same slave nodes over "
    "the error of the run, at its finest level; with the better slave. At 1 no algorithm could do better on this mesh, "
    "at 0.5 one with half of the error is possible. Pressures are compared as continuous piecewise linear functions, "
    "those of constant multipliers and of nodal forces, too. In brackets the level.</p>"
)


def finest_efficiencies(lines: Sequence[Line]) -> dict[tuple[str, str], Point]:
    """Of each case and contender the finest point that has an efficiency, of the slave that has the better one."""
    found: dict[tuple[str, str], Point] = {}
    for line in lines:
        point = next((p for p in reversed(line.finished) if not math.isnan(p.efficiency)), None)
        place = line.case, line.contender
        if point is not None and (place not in found or _rank(point) > _rank(found[place])):
            found[place] = point
    return found


def _rank(point: Point) -> tuple[int, float]:
    return point.level, point.efficiency


def efficiency_rows(found: Accuracy, points: Mapping[tuple[str, str], Point]) -> list[list[str]]:
    """A row per contender that has one, a column per case; the cases first."""
    cases = [asked.label for asked in found.asked if any(case == asked.label for case, _ in points)]
    rows = [["contender", *cases]]
    for name in found.contenders:
        cells = [points.get((case, name)) for case in cases]
        if any(cells):
            rows.append([name, *(f"{p.efficiency:.2f} ({p.level})" if p else "" for p in cells)])
    return rows


def limits_section(found: Accuracy, lines: Sequence[Line]) -> str:
    """The table; empty where no case has an exact pressure."""
    points = finest_efficiencies(lines)
    if not points:
        return ""
    heads, *rows = efficiency_rows(found, points)
    return section("How near to the limit", _TEXT + plain_table(heads, rows, texts=1))


_HEADS = ("case", "contender", "slave", "level", "status", "error, %", "efficiency", "CPU s", "kernels", *COUNTS, "MiB")
_WORDS = ("case", "contender", "slave")
_NUMBERS = ("efficiency", "cpu_s", "kernels", *COUNTS, "memory_mib")


def points_section(found: Accuracy, pages: Mapping[Place, str]) -> str:
    """Every point, failures and what was not run included."""
    heads = "".join(
        f'<th scope="col"{" class=text" if n in (0, 1, 2, 4) else ""}>'
        f'<button type="button">{escape(head)}</button></th>'
        for n, head in enumerate(_HEADS)
    )
    rows = "\n".join(
        _row(point_row(p, found.side_by_side), pages.get((p.case, p.contender, p.slave, p.level), ""))
        for p in found.points
    )
    return section(
        "All points",
        f"<details><summary>{len(found.points)} points</summary>"
        '<input class="filter" data-table="points" type="search" placeholder="words that a row must have" '
        'aria-label="filter the points">'
        '<div class="scroll"><table class="sortable points all" id="points">'
        f"<thead><tr>{heads}</tr></thead>{rows}</table></div></details>",
    )


def _row(row: dict[str, object], page: str) -> str:
    words = "".join(f'<td class="text">{escape(str(row[name]))}</td>' for name in _WORDS)
    link = f'<a href="{escape(page)}">{row["level"]}</a>' if page else row["level"]
    level, status, reason = row["level"], str(row["status"]), str(row["reason"])
    state = f'<td class="text"><span class="status {status}" title="{escape(reason)}">{status}</span></td>'
    numbers = "".join(_number(_float(row[name]), significant(_float(row[name]), 3)) for name in _NUMBERS)
    error = _number(_float(row["error"]), percent(_float(row["error"]), 3))
    return f'<tbody class="run"><tr>{words}<td data-value="{level}">{link}</td>{state}{error}{numbers}</tr></tbody>'


def _number(value: float, text: str) -> str:
    return f'<td data-value="{"" if math.isnan(value) else repr(value)}">{text}</td>'


def _float(value: object) -> float:
    return float(value) if isinstance(value, int | float) else math.nan
