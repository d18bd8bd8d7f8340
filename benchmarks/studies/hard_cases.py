"""build/docs/hard-cases.md from rows of cells (case_rows.py) and from those of million_steps.py: `make pages`.

Cells of hard cases are those of level 2, of `long-run` those of a million steps.
"""

from __future__ import annotations

from pathlib import Path

import case_rows
import cases_page
import kept_rows
from case_tables import counts, table
from kept_rows import Row

HERE = Path(__file__).parent
MILLION = HERE / "million_steps.csv"
LEVEL, STEPS = "level=2", "steps=1000000"


def stored() -> list[Row]:
    """Rows of hard cases at level 2."""
    return [row for row in case_rows.stored() if row["case"] in case_rows.HARD and row["variant"] == LEVEL]


def million_table(rows: list[Row]) -> list[str]:
    """One line per quantity, the algorithms side by side."""
    if not rows:
        return ["Not run yet."]
    lines = [
        "| | " + " | ".join(f"{row['cells']}, {row['algorithm']}, {row['forces']}" for row in rows) + " |",
        "|---" * (len(rows) + 1) + "|",
    ]
    return lines + [
        f"| {key} | " + " | ".join(row[key] for row in rows) + " |"
        for key in rows[0]
        if key not in ("cells", "algorithm", "forces")
    ]


def page(rows: list[Row]) -> str:
    """The page of these rows."""
    text = (HERE / "hard_cases.md").read_text()
    for case in case_rows.HARD:
        own = [row for row in rows if row["case"] == case]
        text = text.replace(f"<!-- {case} -->", "\n".join(cases_page.table(own) if own else ["Not run yet."]))
    text = text.replace("<!-- counts -->", f"Of {counts(rows)}")
    long = [row for row in case_rows.stored() if row["case"] in case_rows.LONG and STEPS in row["variant"]]
    text = text.replace("<!-- long-run -->", "\n".join(table(long)))
    return text.replace("<!-- million steps -->", "\n".join(million_table(kept_rows.read(MILLION))))
