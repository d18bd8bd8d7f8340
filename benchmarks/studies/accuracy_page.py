"""Write what `contactlab compare accuracy` found into docs/accuracy.md.

    contactlab compare accuracy --jobs 1 --out runs/accuracy
    python benchmarks/studies/accuracy_page.py runs/accuracy "how it was run"

Costs, ties and figures are worked out again from the points in `accuracy.json`.
"""

from __future__ import annotations

import json
import math
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from contactlab.accuracy.evaluation import Evaluation, evaluate
from contactlab.accuracy.files import COUNTS
from contactlab.accuracy.point import Point
from contactlab.accuracy.run import Accuracy, Asked
from contactlab.accuracy.study import find_case_study
from contactlab.accuracy.targets import Cost, best_of
from contactlab.reports.accuracy_page import told as told_predictions
from contactlab.reports.accuracy_plots import cost_figure
from contactlab.reports.figures import house_style

DOCS = Path(__file__).parents[2] / "docs"
BEGIN, END = "<!-- measured: begin -->", "<!-- measured: end -->"
TIMES = (0.3, 1.0, 3.0, 10.0, 30.0)
"""CPU seconds within which shares of questions are told."""


def read(path: Path) -> Accuracy:
    """The study in `accuracy.json`."""
    data = json.loads(path.read_text(encoding="utf-8"))
    study = find_case_study("accuracy")
    assert study is not None
    asked = [Asked(**{**case, "order": _number(case["order"])}) for case in data["cases"]]
    points = [_point(row) for row in data["points"]]
    return Accuracy(study, asked, data["contenders"], points, 1, data["interrupted"])


def _point(row: dict[str, Any]) -> Point:
    cost, kernels = _number(row["cpu_s"]), _number(row["kernels"])
    place = row["case"], row["contender"], row["slave"], row["level"], row["status"], row["reason"]
    counts = {name: row[name] for name in COUNTS if row[name] is not None}
    return Point(*place, _number(row["error"]), (cost,) if cost == cost else (), cost / kernels, counts,
                 best=_number(row.get("best_error")))  # fmt: skip


def _number(value: Any) -> float:
    return math.nan if value is None else float(value)


def section(evaluated: Evaluation, how: str) -> str:
    """The measured part of the page."""
    found = evaluated.found
    counted = Counter(point.status for point in found.points)
    words = {"interrupted": "not run yet"}
    ended = ", ".join(f"{count} {words.get(status, status)}" for status, count in counted.most_common())
    orders = [o for o in evaluated.orders if not math.isnan(o.half) and not math.isnan(o.theory)]
    told = [["case", "contender", "slave", "order", "theory"], ["---"] * 5]
    told += [[o.case, o.contender, o.slave, f"{o.order:.2f} ± {o.half:.2f}", f"{o.theory:g}"] for o in orders]
    return "\n".join(
        [
            BEGIN,
            how,
            f"{len(found.points)} points of {len(found.asked)} cases and {len(found.contenders)} contenders: {ended}.",
            "",
            "The cheapest contender of each case and target, with the better slave, and its CPU seconds; `≤` where the "
            "coarsest mesh is good enough, `+ n` where n others cannot be told from it, `grey` where the reference is "
            "not known well enough:",
            "", *_table(_cheapest(evaluated)), "",
            "![Error against cost, a panel per case](pictures/accuracy.svg)", "",
            "Share of all questions (case, slave, target) that a contender answers within so many CPU seconds; those "
            "that it cannot be asked, and failures, are never answered:",
            "", *_table(_shares(evaluated)), "",
            f"Predicted from coarser meshes: {told_predictions(evaluated.predictions)}", "",
            "Orders of convergence with 95 % intervals, where theory has one and three points are above the "
            f"uncertainty of the reference ({len(orders)} of {len(evaluated.lines)} lines):",
            "", *_table(told), END,
        ]
    )  # fmt: skip


def _cheapest(evaluated: Evaluation) -> list[list[str]]:
    """A row per case, a column per target."""
    targets = sorted(evaluated.found.study.targets, reverse=True)
    rows = [["case", *(f"{100.0 * target:g} %" for target in targets)], ["---"] * (len(targets) + 1)]
    best = best_of(evaluated.costs)
    for asked in evaluated.found.asked:
        cells = [[cost for place, cost in best.items() if place[::2] == (asked.label, target)] for target in targets]
        rows.append([asked.label, *map(_winner, cells)])
    return rows


def _winner(costs: Sequence[Cost]) -> str:
    there = [cost for cost in costs if cost.kind == "reached"]
    if not there:
        return "grey" if costs and costs[0].kind == "grey" else "nobody"
    first = min(there, key=lambda cost: cost.cost)
    tied = sum(cost.mark == "tied" for cost in there) - 1
    bound = "≤ " if first.coarsest else ""
    return f"{first.contender}: {bound}{first.cost:.2g}" + (f" + {tied}" if tied > 0 else "")


def _shares(evaluated: Evaluation) -> list[list[str]]:
    """A row per contender: who answers most in ten seconds first."""
    heads = ["contender", *(f"{time:g} s" for time in TIMES), "asked"]
    rows = [heads, ["---"] * len(heads)]
    for one in sorted(evaluated.profiles, key=lambda each: -each.share(10.0)):
        shares = [f"{100.0 * one.share(time):.0f} %" for time in TIMES]
        rows.append([one.contender, *shares, f"{one.put} of {one.asked}"])
    return rows


def _table(rows: Sequence[Sequence[str]]) -> list[str]:
    return [f"| {' | '.join(row)} |" for row in rows]


def main() -> None:
    """Write the section and its picture."""
    evaluated = evaluate(read(Path(sys.argv[1]) / "accuracy.json"))
    page = DOCS / "accuracy.md"
    text = page.read_text(encoding="utf-8")
    head, rest = text.split(BEGIN, 1)
    page.write_text(head + section(evaluated, sys.argv[2]) + rest.split(END, 1)[1], encoding="utf-8")
    with house_style():
        figure = cost_figure(evaluated.found, evaluated.lines)
        figure.savefig(DOCS / "pictures" / "accuracy.svg", metadata={"Date": None, "Creator": None})


if __name__ == "__main__":
    main()
