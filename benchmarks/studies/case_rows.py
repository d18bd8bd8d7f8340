"""Rows of cells from archives of `contactlab matrix`: what pages of cases and rates of warnings share.

A row is one measure of a cell. The newest cell of each configuration replaces an earlier one, and cells that are no
longer planned leave.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from contactlab.jobs.archive import CHOICES, Archive
from contactlab.jobs.rows import Row
from contactlab.parts.registry import default_registry
from contactlab.verdicts.plan import Cell, Request, plan

COLUMNS = (*CHOICES, "verdict", "measure", "role", "value", "least", "most", "unit", "cell", "reason", "cpu_s")

Key = tuple[str, ...]


def asked(*requests: Request) -> dict[Key, Cell]:
    """All cells of some matrices by their configurations."""
    return {tuple(cell.choices.values()): cell for request in requests for cell in plan(request, default_registry())}


def applying(cells: Mapping[Key, Cell]) -> dict[Key, Cell]:
    """Those of the cells that their cases do not refuse."""
    registry = default_registry()
    return {key: cell for key, cell in cells.items() if not cell.case(registry).applies(cell.setup)}


def key_of(row: Mapping[str, Any]) -> Key:
    """What tells the cell of a row from others."""
    return tuple(str(row[name]) for name in CHOICES)


def newest(cells: Iterable[Mapping[str, Any]], wanted: Container[Key]) -> Iterator[tuple[Key, Mapping[str, Any]]]:
    """The first, that is the newest, cell of each wanted configuration that its case did not refuse."""
    seen: set[Key] = set()
    for cell in cells:
        key = key_of(cell)
        if key in wanted and key not in seen and cell["verdict"] != "not-applicable":
            seen.add(key)
            yield key, cell


def rows_of(archive: Path, wanted: Container[Key]) -> list[Row]:
    """The newest cell of each wanted configuration in an archive, one row per measure."""
    found: list[Row] = []
    with Archive(archive, write=False) as kept:
        for key, cell in newest(kept.cells(), wanted):
            head = dict(zip(CHOICES, key, strict=True))
            seconds = "" if cell["cpu_s"] is None else f"{cell['cpu_s']:.2f}"
            reason = cell["reason"].splitlines()[0] if cell["reason"] else ""
            ends = {"cell": str(cell["verdict"]), "reason": reason, "cpu_s": seconds}
            found += [
                {
                    **head,
                    **{name: m[name] for name in ("verdict", "measure", "role", "unit")},
                    **{name: short(m[name]) for name in ("value", "least", "most")},
                    **ends,
                }
                for m in cell["measures"]
            ]
    return found


def short(value: float | None) -> str:
    """A number as pages show it; nothing for a bound that is none."""
    return "" if value is None or math.isinf(value) else "nan" if math.isnan(value) else f"{value:.4g}"


def merged(kept: Sequence[Row], new: Sequence[Row], wanted: Container[Key]) -> list[Row]:
    """New rows in place of those of the same cells; only of configurations that are still planned, sorted by them."""
    came = {key_of(row) for row in new}
    rows = [row for row in kept if key_of(row) in wanted and key_of(row) not in came]
    return sorted([*rows, *new], key=key_of)
