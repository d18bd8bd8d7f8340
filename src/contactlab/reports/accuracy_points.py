"""All points of a study of cases as a table that sorts and filters."""

from __future__ import annotations

import math
from collections.abc import Mapping
from html import escape

from contactlab.accuracy.files import COUNTS, point_row
from contactlab.accuracy.run import Accuracy
from contactlab.reports.accuracy_explore import Place
from contactlab.reports.html import section
from contactlab.reports.numbers import percent, significant

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
