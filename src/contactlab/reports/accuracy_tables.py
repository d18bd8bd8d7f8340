"""The tables of a study of cases: what an error costs, who wins, points, orders, efficiencies, references."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from contactlab.accuracy.files import COUNTS, point_row
from contactlab.accuracy.lines import Line
from contactlab.accuracy.orders import Order
from contactlab.accuracy.point import Point
from contactlab.accuracy.run import Accuracy, Asked
from contactlab.accuracy.targets import Cost, best_of, shown
from contactlab.accuracy.winners import Winner, told
from contactlab.reports.accuracy_explore import Place
from contactlab.reports.accuracy_plots import looks
from contactlab.reports.numbers import percent, significant
from contactlab.reports.sheet import Cell, Column, Sheet, numbers
from contactlab.reports.sheet import Line as Row

NOTES = (
    "* cheapest   ~ ties with the cheapest   \N{LESS-THAN OR EQUAL TO} the coarsest mesh is that good   "
    "\N{HORIZONTAL ELLIPSIS} below the uncertainty of the reference"
)
_MARKS = {"cheapest": "*", "tied": "~"}
_STARS = {"cheapest": "\N{BLACK STAR} ", "tied": "\N{ALMOST EQUAL TO} "}


# --- costs and winners ---


def costs_sheet(found: Accuracy, costs: Sequence[Cost]) -> Sheet:
    """CPU seconds: a row per case and contender, a column per target."""
    best, targets = best_of(costs), found.targets
    rows = []
    for asked in found.asked:
        cells = {name: [best.get((asked.label, name, target)) for target in targets] for name in found.contenders}
        there = [name for name, own in cells.items() if any(own)]
        for name in there:
            label = asked.label if name is there[0] else ""
            rows.append(Row([label, name, *map(_cost, cells[name])], ends=name is there[-1]))
    heads = [Column(f"{percent(target, 1)} %", number=True, whole=True, keep=True) for target in targets]
    title = f"{found.study.name}: CPU seconds to an error of"
    return Sheet([Column("case", keep=True), "contender", *heads], rows, title)


def _cost(cost: Cost | None) -> Cell:
    if cost is None:
        return Cell("")
    return Cell(f"{shown(cost)}{_MARKS.get(cost.mark, '')}", kind=cost.mark or cost.kind)


def target_sheet(found: Accuracy, best: Mapping[tuple[str, str, float], Cost], target: float) -> Sheet:
    """CPU seconds to one target: a row per contender, a column per case."""
    heads = [Column(asked.label, meaning=f"{asked.title}: {asked.measure}", number=True) for asked in found.asked]
    rows = []
    for name in found.contenders:
        cells = [best.get((asked.label, name, target)) for asked in found.asked]
        if any(cells):
            rows.append([name, *map(_pointed, cells)])
    return Sheet(["contender", *heads], rows)


def _pointed(cost: Cost | None) -> Cell:
    """A cost with its interval or reason, shown where a reader points at it."""
    if cost is None:
        return Cell("\N{MIDDLE DOT}", kind="none", hint="the case is not made for it")
    hint = cost.why
    if cost.kind == "reached":
        high = f"{cost.high:.2g}" if cost.high < math.inf else "unknown"
        hint = f"{cost.low:.2g} to {high} s, slave {cost.slave}"
        hint += ": the coarsest mesh is that good" if cost.coarsest else ""
    return Cell(f"{_STARS.get(cost.mark, '')}{shown(cost)}", kind=cost.mark or cost.kind, hint=hint)


def winners_sheet(winners: Sequence[Winner]) -> Sheet:
    """A row per case and target: who wins, at what cost, and by how much the next is dearer."""
    rows, label = [], ""
    for winner in winners:
        who, cost, after = told(winner)
        case, label = "" if winner.case == label else winner.case, winner.case
        rows.append([case, f"{percent(winner.target, 1)} %", Cell(who, kind=_kind(winner)), cost, after])
    return Sheet([Column(name, keep=True) for name in ("case", "error", "cheapest", "CPU time", "next")], rows,
                 "Cheapest method")  # fmt: skip


def _kind(winner: Winner) -> str:
    return "cheapest" if len(winner.group) == 1 else "tied" if winner.group else "grey"


def winners_by_case(found: Accuracy, winners: Sequence[Winner]) -> Sheet:
    """A row per case, a column per target."""
    chosen = looks(found)
    cells = {(winner.case, winner.target): winner for winner in winners}

    def cell(winner: Winner | None) -> Cell:
        if winner is None:
            return Cell("")
        who, cost, after = told(winner)
        if not winner.group:
            return Cell(who, kind=winner.kind)
        colours = tuple(dict.fromkeys(chosen[name].colour for name in winner.group))
        hint = f"{winner.low:.2g} to {winner.high:.2g} s, slave {winner.slave}"
        return Cell(f"{who}\n{cost}\n{after}", kind=_kind(winner), hint=hint, swatches=colours)

    rows = (
        [asked.label, *(cell(cells.get((asked.label, target))) for target in found.targets)] for asked in found.asked
    )
    return Sheet(["case", *(f"{percent(target, 1)} %" for target in found.targets)], rows)


# --- points ---


def points_sheet(found: Accuracy, pages: Mapping[Place, str]) -> Sheet:
    """Every point, failures and what was not run included; `pages` are where points lead to."""
    heads = [*map(Column, ("case", "contender", "slave", "level", "status"))]
    heads += numbers("error, %", "efficiency", "CPU s", "kernels", *COUNTS, "MiB")
    return Sheet(heads, (_point(point, found.side_by_side, pages) for point in found.points))


def _point(point: Point, side_by_side: int, pages: Mapping[Place, str]) -> list[Cell]:
    row = point_row(point, side_by_side)
    page = pages.get((point.case, point.contender, point.slave, point.level), "")
    values = (row[name] for name in ("efficiency", "cpu_s", "kernels", *COUNTS, "memory_mib"))
    return [
        Cell(point.case), Cell(point.contender), Cell(point.slave), Cell(str(point.level), point.level, link=page),
        Cell(point.status, kind=point.status, hint=point.reason), Cell(percent(point.error, 3), point.error),
        *(Cell(significant(value, 3), value) for value in values),
    ]  # fmt: skip


def orders_sheet(orders: Sequence[Order]) -> Sheet:
    """Orders of convergence."""
    rows = (
        [o.case, o.contender, o.slave, f"{o.order:.2f}", "" if math.isnan(o.half) else f"{o.half:.2f}",
         " ".join(map(str, o.levels)), "" if math.isnan(o.theory) else f"{o.theory:g}"]
        for o in orders
    )  # fmt: skip
    return Sheet(["case", "contender", "slave", *numbers("order", "± 95 %", "levels", "theory")], rows)


def beside_sheet(found: Accuracy, lines: Sequence[Line]) -> Sheet:
    """Memory and first compilation: costs that CPU seconds of runs do not show."""
    rows = []
    for name in found.contenders:
        points = [p for line in lines if line.contender == name for p in line.finished]
        if points:
            memory = max((p.memory_mib for p in points if p.memory_mib > 0.0), default=math.nan)
            compiled = max((p.compile_s for p in points if p.compile_s >= 0.0), default=math.nan)
            most = max((p.cost / p.calibration for p in points if p.calibration > 0.0), default=math.nan)
            rows.append([name, significant(memory, 3), significant(compiled, 2), significant(most, 2)])
    heads = numbers("largest memory, MiB", "longest compiling or loading, s", "costliest run, calibration kernels")
    return Sheet(["contender", *heads], rows)


def references_sheet(asked: Sequence[Asked]) -> Sheet:
    """The cases and what their runs are compared with."""
    rows = (
        [a.label, a.title, a.measure, a.reference, percent(a.uncertainty) if a.uncertainty else "exact", a.why]
        for a in asked
    )
    return Sheet(["case", "question", "error measure", "reference", *numbers("uncertainty, %", "why")], rows)


# --- how near to the limit ---


def finest_efficiencies(lines: Sequence[Line]) -> dict[tuple[str, str], Point]:
    """Finest point with an efficiency for each case and contender, with the slave that has the better efficiency."""
    found: dict[tuple[str, str], Point] = {}
    for line in lines:
        point = next((p for p in reversed(line.finished) if not math.isnan(p.efficiency)), None)
        place = line.case, line.contender
        if point is not None and (place not in found or _rank(point) > _rank(found[place])):
            found[place] = point
    return found


def _rank(point: Point) -> tuple[int, float]:
    return point.level, point.efficiency


def limits_sheet(found: Accuracy, lines: Sequence[Line]) -> Sheet:
    """Efficiencies: a row per contender that has one, a column per case, the level in brackets."""
    points = finest_efficiencies(lines)
    cases = [asked.label for asked in found.asked if any(case == asked.label for case, _ in points)]
    rows = []
    for name in found.contenders:
        cells = [points.get((case, name)) for case in cases]
        if any(cells):
            rows.append([name, *(f"{p.efficiency:.2f} ({p.level})" if p else "" for p in cells)])
    return Sheet(["contender", *numbers(*cases)], rows)
