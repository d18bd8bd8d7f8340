"""Write what `contactlab compare accuracy` found into docs/accuracy.md.

    contactlab compare accuracy --quick --jobs 1 --out runs/accuracy
    python benchmarks/studies/accuracy_page.py runs/accuracy "how it was run"

Costs, ties and figures are worked out again from the points in `accuracy.json`.
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

import pictures

from contactlab.accuracy.lines import lines_of
from contactlab.accuracy.orders import orders_of
from contactlab.accuracy.point import Point
from contactlab.accuracy.run import Accuracy, Asked
from contactlab.accuracy.study import find_case_study
from contactlab.accuracy.targets import best_of, costs_of, shown
from contactlab.reports.accuracy_plots import cost_figure
from contactlab.reports.figures import house_style

DOCS = Path(__file__).parents[2] / "docs"
BEGIN, END = "<!-- measured: begin -->", "<!-- measured: end -->"
MARKS = {"cheapest": "**{}**", "tied": "*{}*"}


def read(path: Path) -> Accuracy:
    """The study in `accuracy.json`."""
    data = json.loads(path.read_text(encoding="utf-8"))
    study = find_case_study("accuracy")
    assert study is not None
    asked = [Asked(**{**case, "order": _number(case["order"])}) for case in data["cases"]]
    return Accuracy(study, asked, data["contenders"], [_point(row) for row in data["points"]], 1)


def _point(row: dict[str, Any]) -> Point:
    cost, kernels = _number(row["cpu_s"]), _number(row["kernels"])
    place = row["case"], row["contender"], row["slave"], row["level"], row["status"], row["reason"]
    return Point(*place, _number(row["error"]), (cost,) if cost == cost else (), cost / kernels)


def _number(value: Any) -> float:
    return math.nan if value is None else float(value)


def section(found: Accuracy, how: str) -> str:
    """The measured part of the page."""
    lines = lines_of(found)
    targets = sorted(found.study.targets, reverse=True)
    best = best_of(costs_of(found, lines))
    heads = ["case", "contender", *(f"{100.0 * t:g} %" for t in targets)]
    rows = [heads, ["---"] * len(heads)]
    for asked in found.asked:
        for name in found.contenders:
            cells = [best.get((asked.label, name, target)) for target in targets]
            if any(cells):
                texts = [MARKS.get(c.mark, "{}").format(shown(c)) if c else "" for c in cells]
                rows.append([asked.label, name, *texts])
    orders = [o for o in orders_of(found, lines) if not math.isnan(o.half)]
    told = [["case", "contender", "slave", "order", "theory"], ["---"] * 5]
    told += [
        [
            o.case,
            o.contender,
            o.slave,
            f"{o.order:.2f} +- {o.half:.2f}",
            "" if math.isnan(o.theory) else f"{o.theory:g}",
        ]
        for o in orders
    ]
    finished = sum(point.finished for point in found.points)
    return "\n".join(
        [
            BEGIN,
            how,
            f"{finished} of {len(found.points)} points finished. CPU seconds to reach an error with the better slave;",
            "the cheapest is bold, those that cannot be distinguished from it are in italics:",
            "", *_table(rows), "",
            "![Error against cost, a panel per case](pictures/accuracy.svg)", "",
            f"Orders of convergence with 95 % intervals, where three points are above the uncertainty of the reference "
            f"({len(orders)} of {len(lines)} lines):",
            "", *_table(told), END,
        ]
    )  # fmt: skip


def _table(rows: list[list[str]]) -> list[str]:
    return [f"| {' | '.join(row)} |" for row in rows]


def main() -> None:
    """Write the section and its picture."""
    found = read(Path(sys.argv[1]) / "accuracy.json")
    page = DOCS / "accuracy.md"
    text = page.read_text(encoding="utf-8")
    head, rest = text.split(BEGIN, 1)
    page.write_text(head + section(found, sys.argv[2]) + rest.split(END, 1)[1], encoding="utf-8")
    with house_style():
        figure = cost_figure(found, lines_of(found))
        figure.savefig(DOCS / "pictures" / "accuracy.svg", metadata={"Date": None, "Creator": None})
    pictures.keep(["pictures/accuracy.svg"])


if __name__ == "__main__":
    main()
