"""Stability as a distance: how far a case can be driven until an algorithm no longer meets every criterion."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Sequence
from concurrent.futures import as_completed
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from contactlab.api import Case, Setup
from contactlab.archive.archive import FILE, Archive
from contactlab.matrix.cell import CellResult, run_cell
from contactlab.matrix.plan import Cell, Request, plan
from contactlab.matrix.run import keep
from contactlab.parts.registry import Registry
from contactlab.studies.call import Call
from contactlab.studies.scheduler import LOCAL, open_pool

HALVINGS = 6
"""Of the distance between what is met and what is not (of its logarithm where both are positive): a 64th is left."""


@dataclass(frozen=True)
class Margin:
    """How far one field of a case can go with one algorithm.

    met, missed  largest value that meets every criterion, smallest that was seen not to (nan: none, up to `limit`)
    verdict, reason  at `missed`
    """

    case: str
    field: str
    contact: str
    start: float
    limit: float
    met: float
    missed: float
    verdict: str
    reason: str


def bisected(holds: Callable[[float], bool], start: float, limit: float) -> tuple[float, float]:
    """The last value that holds between `start` and `limit`, and the first that does not; nan where there is none."""
    if not holds(start):
        return math.nan, start
    if holds(limit):
        return limit, math.nan
    good, bad = start, limit
    for _ in range(HALVINGS):
        middle = math.sqrt(good * bad) if min(good, bad) > 0.0 else 0.5 * (good + bad)
        good, bad = (middle, bad) if holds(middle) else (good, middle)
    return good, bad


def find_margin(
    name: str, contact: str, registry: Registry, archive: Path, report: Callable[[Any], None]
) -> tuple[Margin, list[tuple[Cell, CellResult]]]:
    """The margin of a case that has one, and the cells that were made for it."""
    case: Case = registry.make("case", name)
    assert case.margin is not None
    field, limit = case.margin
    start, made = float(getattr(case, field)), {}

    def holds(value: float) -> bool:
        setup = Setup(contact, False, case.elements[0], case.integrators[0])
        cell = Cell(name, {} if value == start else {field: value}, setup)
        made[value] = cell, run_cell(cell, registry, archive, report)
        return made[value][1].verdict == "met"

    met, missed = bisected(holds, start, limit)
    worst = made[missed][1] if missed in made else CellResult("met", "", "")
    margin = Margin(name, field, contact, start, limit, met, missed, worst.verdict, worst.reason)
    return margin, list(made.values())


def run_margins(
    request: Request, registry: Registry, folder: Path, jobs: int, told: Callable[[str], None], scheduler: str = LOCAL
) -> list[Margin]:
    """Margins of all asked cases that have one, for all asked algorithms; margins.csv in `folder`."""
    asked = dict.fromkeys((cell.name, str(cell.setup.algorithm)) for cell in plan(request, registry))
    pairs = [pair for pair in asked if registry.make("case", pair[0]).margin is not None]
    found: dict[tuple[str, str], Margin] = {}
    with Archive(folder / FILE) as archive, open_pool(scheduler, jobs) as pool:
        futures = {pool.submit(Call(find_margin, (*pair, registry, folder / FILE))): pair for pair in pairs}
        for future in as_completed(futures):
            margin, cells = future.result()
            for cell, result in cells:
                keep(archive, cell, result, registry)
            found[futures[future]] = margin
            told(f"{len(found)}/{len(pairs)} {margin.case}, {margin.contact}: {margin.field} up to {margin.met:.4g}")
    margins = [found[pair] for pair in pairs]
    _write(margins, folder / "margins.csv")
    return margins


def _write(margins: Sequence[Margin], path: Path) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, [field.name for field in fields(Margin)])
        table.writeheader()
        table.writerows(asdict(margin) for margin in margins)
