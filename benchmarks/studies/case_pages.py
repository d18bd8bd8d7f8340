"""Pages of cases in build/docs from rows of cells (case_rows.py) and of million_steps.py: `make pages`.

A page is its text, in which marks of the names of cases stand for their tables: a line per cell, or per group of
variants with the worst of each number. Cells of hard cases are those of level 2, of `long-run` those of a million
steps.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from pathlib import Path

import case_rows
import cases_page
import kept_rows
import numpy as np
from case_rows import OF_THE_RUN, key_of
from kept_rows import Row

from contactlab.jobs.archive import CHOICES

HERE = Path(__file__).parent
LEVEL, STEPS = "level=2", "steps=1000000"
WORST_OVER = {"patch": ("variant",)}
"""Choices of which a table shows the worst."""

Cell = Sequence[Row]
HEADS = {"contact": "algorithm"}


def cells_of(rows: Iterable[Row]) -> list[list[Row]]:
    """The rows of each cell together."""
    return [list(own) for _, own in groupby(sorted(rows, key=key_of), key_of)]


def counts(rows: Iterable[Row]) -> str:
    """How many cells have which verdict."""
    verdicts = [cell[0]["cell"] for cell in cells_of(rows)]
    order = ("silent", "failed", "missed", "not-judged", "ill-posed", "met")
    told = ", ".join(f"{verdicts.count(v)} {v}" for v in order if v in verdicts or v == "silent")
    return f"{len(verdicts)} cells: {told}."


def table(rows: Sequence[Row], worst_over: Sequence[str] = ()) -> list[str]:
    """One line per cell; cells that differ in `worst_over` alone share one, with their worst numbers.

    Numbers that are not met are bold. What is the same in all cells is left out.
    """
    cells = cells_of(rows)
    if not cells:
        return ["Not run yet."]
    told = [name for name in CHOICES[1:] if name not in worst_over and len({cell[0][name] for cell in cells}) > 1]
    measures = list(dict.fromkeys(row["measure"] for row in rows if row["role"] not in (OF_THE_RUN, "")))
    heads = [*(HEADS.get(name, name) for name in told), *(head(rows, name) for name in measures), "verdict"]
    lines = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    for chosen, group in groupby(sorted(cells, key=lambda c: _choice(c, told)), lambda c: _choice(c, told)):
        own = list(group)
        numbers = [_number([row for cell in own for row in cell if row["measure"] == name]) for name in measures]
        choice = [text or "default" for text in chosen]
        lines.append(f"| {' | '.join([*choice, *numbers, _verdict(own)])} |")
    return lines


def _choice(cell: Cell, told: Sequence[str]) -> tuple[str, ...]:
    return tuple(cell[0][name] for name in told)


def head(rows: Iterable[Row], measure: str) -> str:
    """A measure with its unit and what is allowed: the strictest and the widest where cells differ."""
    own = [row for row in rows if row["measure"] == measure]
    unit = f" [{own[0]['unit']}]" if own[0]["unit"] else ""
    if own[0]["role"] == "reported":
        return measure + unit
    bounds = sorted({(row["least"], row["most"]) for row in own}, key=_width)
    texts = list(dict.fromkeys(_bound(*bound) for bound in (bounds[0], bounds[-1])))
    return f"{measure}{unit} ({' or '.join(texts)})"


def _width(bound: tuple[str, str]) -> float:
    least, most = (float(text) if text else math.inf for text in bound)
    return most if math.isinf(least) else most - least


def _bound(least: str, most: str) -> str:
    if not least:
        return f"<= {most}"
    if not most:
        return f">= {least}"
    return f"+-{most}" if least == f"-{most}" else f"{least} to {most}"


def _number(rows: Sequence[Row]) -> str:
    """The worst of some values: one that is not met before others, then the largest."""
    values = [row for row in rows if row["value"] not in ("", "nan")]
    if not values:
        return ""
    worst = max(values, key=lambda row: (_bad(row), abs(float(row["value"]))))
    return f"**{worst['value']}**" if _bad(worst) else worst["value"]


def _bad(row: Row) -> bool:
    """Whether a number misses what is allowed, also where its cell has no verdict of its numbers."""
    least, most = (float(row[name]) if row[name] else math.inf for name in ("least", "most"))
    low = -math.inf if math.isinf(least) else least
    return row["role"] != "reported" and not low <= float(row["value"]) <= most


def _verdict(cells: Sequence[Cell]) -> str:
    """Of one cell with the invariants that it breaks; of several how many have which."""
    verdicts = [cell[0]["cell"] for cell in cells]
    broken = {row["measure"]: row["value"] for cell in cells for row in cell if row["role"] == OF_THE_RUN}
    told = f": {', '.join(f'{name} {value}' for name, value in broken.items())}" if broken else ""
    if len(cells) == 1:
        return f"{verdicts[0]}{told}" if verdicts[0] == "met" else f"**{verdicts[0]}**{told}"
    each = ", ".join(f"{verdicts.count(v)} {v}" for v in dict.fromkeys(sorted(verdicts)))
    return each + (f"; {', '.join(broken)}" if broken else "")


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


FORCE, SPEED = "reaction in the end", "reaction at half the speed, less one"
CONE, WORK = (
    "force beyond the cone over the largest pressure",
    "least work of friction between frames over internal energy",
)
HEAD = (
    "variant", "reaction of mortars [N/mm]", "spread over multipliers and slaves", "of nodes on segments",
    "largest change at half the speed", "largest violation of the cone", "least work of friction over internal energy",
)  # fmt: skip


def summary(rows: list[Row]) -> list[str]:
    """One line per friction and depth: how much slaves, multipliers and speeds differ."""
    lines = [f"| {' | '.join(HEAD)} |", "|---" * len(HEAD) + "|"]
    for variant in dict.fromkeys(row["variant"] for row in rows):
        own = [row for row in rows if row["variant"] == variant]
        mortars = _values(own, FORCE, nodes=False)
        spreads = [f"{np.ptp(v) / v.mean():.2%}" for v in (mortars, _values(own, FORCE, nodes=True))]
        speed, cone = (np.abs(_values(own, name)).max() for name in (SPEED, CONE))
        least = f"{_values(own, WORK).min():.1e}"
        numbers = (f"{mortars.mean():.6g}", *spreads, f"{speed:.3%}", f"{cone:.1e}", least)
        lines.append(f"| {' | '.join((variant or 'default', *numbers))} |")
    return lines


def _values(rows: list[Row], measure: str, nodes: bool | None = None) -> np.ndarray:
    """Values of a measure: of mortars, of nodes on segments, or of all."""
    own = [r for r in rows if r["measure"] == measure and nodes in (None, r["contact"] == "node-on-segment")]
    return np.array([float(row["value"]) for row in own])


def _filled(name: str, rows: list[Row], parts: Mapping[str, list[str]]) -> str:
    """The text of a page with its parts, and the counts of the cells that it shows."""
    text = (HERE / name).read_text().replace("<!-- counts -->", f"Of {counts(rows)}")
    for mark, lines in parts.items():
        text = text.replace(f"<!-- {mark} -->", "\n".join(lines))
    return text


def _of(rows: Iterable[Row], case: str) -> list[Row]:
    return [row for row in rows if row["case"] == case]


def hard_cases() -> str:
    """The page of hard cases at level 2, and of long runs."""
    stored = case_rows.stored()
    rows = [row for row in stored if row["case"] in case_rows.HARD and row["variant"] == LEVEL]
    parts = {case: cases_page.table(_of(rows, case)) for case in case_rows.HARD}
    long = [row for row in stored if row["case"] in case_rows.LONG and STEPS in row["variant"]]
    parts |= {"long-run": table(long), "million steps": million_table(kept_rows.read(HERE / "million_steps.csv"))}
    return _filled("hard_cases.md", rows, parts)


def statics_cases() -> str:
    """The page of static and implicit cases."""
    rows = [row for row in case_rows.stored() if row["case"] in case_rows.STATICS]
    return _filled(
        "statics_cases.md", rows, {case: table(_of(rows, case), WORST_OVER.get(case, ())) for case in case_rows.STATICS}
    )


def friction() -> str:
    """The page of `disc-with-friction`."""
    rows = [row for row in case_rows.stored() if row["case"] in case_rows.FRICTION]
    return _filled("friction.md", rows, {"summary": summary(rows), "rows": table(rows)})
