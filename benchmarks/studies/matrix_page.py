"""Numbers of docs/matrix.md between its marks: how many cells there are, and what the quick matrix costs.

They come from the plan of today and from the rows of cases.csv, as everything on build/docs/cases.md.
"""

from __future__ import annotations

from collections import Counter
from functools import cache
from pathlib import Path

import case_rows
import cases_page
from filled import filled

from contactlab.jobs.archive import CHOICES
from contactlab.jobs.rows import Row
from contactlab.parts.registry import default_registry
from contactlab.verdicts.plan import Request

PAGE = Path(__file__).parents[2] / "docs" / "matrix.md"


def page(rows: list[Row]) -> str:
    """docs/matrix.md with its numbers put in."""
    return filled(PAGE, sizes=_sizes(), costs=_costs(rows))


@cache
def applying(full: bool) -> tuple[int, int]:
    """How many cells a matrix has, and how many of them apply."""
    cells = case_rows.asked(Request(full=full))
    return len(cells), len(case_rows.applying(cells))


def _sizes() -> str:
    (_, quick), (full, applied) = applying(full=False), applying(full=True)
    cases = len(default_registry().names("case"))
    return (
        f"There are {cases} cases. The quick matrix has {quick} cells; the full one has {full}, of which {applied} "
        "apply."
    )


def _costs(rows: list[Row]) -> str:
    """Counts of verdicts, CPU time of all cells, and the one that takes most."""
    cells = {tuple(row[name] for name in CHOICES): row for row in rows}
    seconds = {key: float(row["cpu_s"]) for key, row in cells.items() if row["cpu_s"]}
    verdicts = Counter(row["cell"] for row in cells.values())
    told = ", ".join(f"{verdicts[v]} {v}" for v in cases_page.ORDER if verdicts[v])
    dearest = max(seconds, key=lambda key: seconds[key])
    case, contact = dearest[CHOICES.index("case")], dearest[CHOICES.index("contact")]
    return (
        f"The runs of the quick matrix take {sum(seconds.values()):.0f} CPU seconds with warm kernels "
        f"({len(cells)} cells:\n{told}).\nThe most expensive cell is `{contact}` in `{case}`: {seconds[dearest]:.1f} s."
    )
