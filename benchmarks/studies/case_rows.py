"""Rows of cells of `contactlab matrix` that pages show, taken from archives and kept in case_rows.csv.

    contactlab matrix $(python benchmarks/studies/case_rows.py hard) --level 2 --out runs/hard
    contactlab matrix --full $(python benchmarks/studies/case_rows.py statics friction long) --out runs/statics
    make pages CASES="runs/hard runs/statics"

A row is one measure of a cell; invariants of runs that are kept, and for which no case asks, are left out. The newest
cell of each configuration replaces an earlier one, and cells that are no longer planned leave.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Container, Mapping, Sequence
from pathlib import Path
from typing import Any

import kept_rows
from kept_rows import Row

from contactlab.jobs.archive import CHOICES, Archive
from contactlab.parts.registry import default_registry
from contactlab.verdicts.plan import Cell, Request, plan

STORED = Path(__file__).parent / "case_rows.csv"
COLUMNS = (*CHOICES, "verdict", "measure", "role", "value", "least", "most", "unit", "cell", "reason", "cpu_s")
HARD = (
    "bouncing-bar", "two-bars", "block-on-incline", "corner-slide", "vertex-to-vertex", "initial-overlap", "stack",
    "dropped-block", "pressed-block", "spinning-pair",
)  # fmt: skip
STATICS = (
    "patch", "tresca-block", "nafems-cgs1", "mindlin", "rigid-punch", "elastic-punch", "rough-plate", "pulled-block",
    "stiffness-contrast", "incompressible", "mesh-ratio", "wall-impact", "two-beams", "resting-block", "ironing",
)  # fmt: skip
FRICTION = ("disc-with-friction",)
LONG = ("long-run",)
GROUPS = {"hard": HARD, "statics": STATICS, "friction": FRICTION, "long": LONG}

Key = tuple[str, ...]
OF_THE_RUN = "of the run"
"""Role of an invariant that a case does not ask for."""


def asked(*requests: Request) -> dict[Key, Cell]:
    """All cells of some matrices by their configurations."""
    return {tuple(cell.choices.values()): cell for request in requests for cell in plan(request, default_registry())}


def applying(cells: Mapping[Key, Cell]) -> dict[Key, Cell]:
    """Those of the cells that their cases do not refuse."""
    registry = default_registry()
    return {key: cell for key, cell in cells.items() if not cell.case(registry).applies(cell.setup)}


def of_pages() -> dict[Key, Cell]:
    """The cells that these pages show: hard cases on the finer meshes of level 2, the others in full."""
    return asked(Request(HARD, levels=(2,)), Request((*STATICS, *FRICTION, *LONG), full=True))


def key_of(row: Mapping[str, Any]) -> Key:
    """What tells the cell of a row from others."""
    return tuple(str(row[name]) for name in CHOICES)


def rows_of(archive: Path, wanted: Mapping[Key, Cell], all_invariants: bool = True) -> list[Row]:
    """The newest cell of each wanted configuration in an archive, one row per measure.

    Without `all_invariants`, those of the run itself, which no case asks for, are there where they are broken.
    """
    seen: set[Key] = set()
    found: list[Row] = []
    with Archive(archive, write=False) as kept:
        for cell in kept.cells():
            key = key_of(cell)
            if key in wanted and key not in seen and cell["verdict"] != "not-applicable":
                seen.add(key)
                found += _rows(cell) if all_invariants else _asked_rows(cell, wanted[key])
    return found


def _asked_rows(found: Mapping[str, Any], cell: Cell) -> list[Row]:
    """Rows of what a case asks for, and of what else is broken; one without a measure where there is neither."""
    own = {measure.name for measure in cell.case(default_registry()).measures(cell.setup)}
    rows = [row if row["measure"] in own else row | {"role": OF_THE_RUN} for row in _rows(found)]
    shown = [row for row in rows if row["role"] != OF_THE_RUN or row["verdict"] != "met"]
    ends = _ends(found)
    return shown or [dict(zip(CHOICES, key_of(found), strict=True)) | ends]


def _rows(cell: Mapping[str, Any]) -> list[Row]:
    head = dict(zip(CHOICES, key_of(cell), strict=True))
    ends = _ends(cell)
    numbers = ("value", "least", "most")
    return [
        {
            **head,
            **{name: m[name] for name in ("verdict", "measure", "role", "unit")},
            **{name: short(m[name]) for name in numbers},
            **ends,
        }
        for m in cell["measures"]
    ]


def _ends(cell: Mapping[str, Any]) -> Row:
    """What a row says of its whole cell."""
    seconds = "" if cell["cpu_s"] is None else f"{cell['cpu_s']:.2f}"
    return {"cell": str(cell["verdict"]), "reason": _first_line(cell["reason"]), "cpu_s": seconds}


def _first_line(reason: str | None) -> str:
    return reason.splitlines()[0] if reason else ""


def short(value: float | None) -> str:
    """A number as pages show it; nothing for a bound that is none."""
    return "" if value is None or math.isinf(value) else "nan" if math.isnan(value) else f"{value:.4g}"


def merged(kept: Sequence[Row], new: Sequence[Row], wanted: Container[Key]) -> list[Row]:
    """New rows in place of those of the same cells; only of configurations that are still planned, sorted by them."""
    came = {key_of(row) for row in new}
    rows = [row for row in kept if key_of(row) in wanted and key_of(row) not in came]
    return sorted([*rows, *new], key=key_of)


def keep(archive: Path) -> None:
    """Take what the pages show from an archive."""
    wanted = of_pages()
    kept_rows.write(STORED, COLUMNS, merged(stored(), rows_of(archive, wanted, all_invariants=False), wanted))


def stored() -> list[Row]:
    """The rows that are kept."""
    return kept_rows.read(STORED)


if __name__ == "__main__":
    print(*(case for group in sys.argv[1:] or GROUPS for case in GROUPS[group]))
