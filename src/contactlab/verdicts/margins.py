"""Stability as a distance: how far a case can be driven until an algorithm no longer meets every criterion."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from contactlab.api import Case, Setup
from contactlab.cases.methods import method_of
from contactlab.jobs.driver import Driver
from contactlab.jobs.rows import write_csv
from contactlab.parts.registry import Registry
from contactlab.verdicts.cell import CellResult, cell_plan, keep
from contactlab.verdicts.plan import Cell, Request, plan

HALVINGS = 6
"""Share of the distance between values met and missed (of its logarithm if both are positive): a 64th is left."""


@dataclass(frozen=True)
class Margin:
    """Margin of one field of a case with one algorithm.

    met, missed  largest value that meets every criterion, smallest known value that does not (nan: none, up to `limit`)
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


def bisection(start: float, limit: float) -> Generator[float, bool, tuple[float, float]]:
    """Yield values and get whether they hold; return the last that holds and the first that does not, nan for none."""
    if not (yield start):
        return math.nan, start
    if (yield limit):
        return limit, math.nan
    good, bad = start, limit
    for _ in range(HALVINGS):
        middle = math.sqrt(good * bad) if min(good, bad) > 0.0 else 0.5 * (good + bad)
        good, bad = (middle, bad) if (yield middle) else (good, middle)
    return good, bad


def margin_plan(
    name: str, contact: str, registry: Registry, judged: Callable[[Cell, CellResult], None]
) -> Generator[Any, Any, Margin | None]:
    """The margin of a case that has one, None if it was interrupted; `judged` gets the cells that are made for it."""
    case: Case = registry.make("case", name)
    assert case.margin is not None
    field, limit = case.margin
    start, made = float(getattr(case, field)), dict[float, CellResult]()
    search = bisection(start, limit)
    value = next(search)
    while True:
        algorithm, enforcement = method_of(contact, registry, "contactlab matrix")
        setup = Setup(algorithm, False, case.elements[0], case.integrators[0], enforcement=enforcement)
        cell = Cell(name, {} if value == start else {field: value}, setup)
        (made[value],) = yield [cell_plan(cell, registry)]
        if not made[value].whole:
            return None
        judged(cell, made[value])
        try:
            value = search.send(made[value].verdict == "met")
        except StopIteration as end:
            met, missed = end.value
            worst = made.get(missed, CellResult("met", "", ""))
            return Margin(name, field, contact, start, limit, met, missed, worst.verdict, worst.reason)


def run_margins(request: Request, registry: Registry, driver: Driver, folder: Path) -> list[Margin]:
    """Find margins of all requested cases that have one, for all requested algorithms; margins.csv in `folder`."""
    found: dict[int, Margin] = {}
    plans = [
        margin_plan(*pair, registry, lambda cell, result: keep(driver.archive, cell, result, registry))
        for pair in margins_asked(request, registry)
    ]
    for number, margin in driver.results(plans):
        if margin is not None:
            found[number] = margin
            driver.progress.told(f"{margin.case}, {margin.contact}: {margin.field} up to {margin.met:.4g}")
    margins = [found[number] for number in sorted(found)]
    write_csv(folder / "margins.csv", [field.name for field in fields(Margin)], map(asdict, margins))
    return margins


def margins_asked(request: Request, registry: Registry) -> list[tuple[str, str]]:
    """Cases that have a margin, with the requested methods."""
    asked = dict.fromkeys((cell.name, cell.choices["contact"]) for cell in plan(request, registry))
    return [pair for pair in asked if registry.make("case", pair[0]).margin is not None]
