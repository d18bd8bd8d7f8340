"""Findings of a comparison by algorithm: the few numbers that a reader wants first."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from contactlab.accuracy.lines import CLEAR
from contactlab.reports.numbers import MISSING, percent, significant
from contactlab.reports.series import series_of
from contactlab.studies.table import Row, Table


@dataclass(frozen=True)
class Finding:
    """Results of an algorithm over the runs of the study; ranges are (smallest, largest), NaN if unknown.

    peak_force, peak_pressure  [N/mm], [MPa] of the runs that carried the whole load
    """

    algorithm: str
    finished: int
    runs: int
    pressure_error: tuple[float, float]
    swap_asymmetry: tuple[float, float]
    peak_force: tuple[float, float]
    peak_pressure: tuple[float, float]
    cpu_s: tuple[float, float]


COUNTS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")


def heading(table: Table) -> str:
    """The name of the study and how many algorithms it compares: "Disc on block: three contact algorithms"."""
    count = len({row.algorithm for row in table.main})
    if count < 2:
        return table.study.name
    return f"{table.study.name}: {COUNTS[count] if count < len(COUNTS) else count} contact algorithms"


def findings(table: Table) -> list[Finding]:
    """A finding per algorithm, in the order of the study."""
    names = dict.fromkeys(row.algorithm for row in table.main)
    return [_finding(name, [row for row in table.main if row.algorithm == name]) for name in names]


def _finding(name: str, rows: Sequence[Row]) -> Finding:
    return Finding(
        algorithm=name,
        finished=sum(row.finished for row in rows),
        runs=len(rows),
        pressure_error=_range(row["pressure_error"] for row in rows),
        swap_asymmetry=_range(row["swap_asymmetry"] for row in rows),
        peak_force=_range(row["peak_force"] for row in rows if row.complete),
        peak_pressure=_range(row["peak_pressure"] for row in rows if row.complete),
        cpu_s=_range(row["cpu_s"] for row in rows),
    )


def _range(values: Iterable[float]) -> tuple[float, float]:
    known = [value for value in values if not math.isnan(value)]
    return (min(known), max(known)) if known else (math.nan, math.nan)


def span(values: tuple[float, float], unit: str) -> str:
    """A range in words: "1.2 to 3.4 %", one number where both ends are written alike."""
    write = percent if unit == "%" else significant
    if math.isnan(values[0]):
        return MISSING
    low, high = (write(value, 2) for value in values)
    return (f"{low} {unit}" if low == high else f"{low} to {high} {unit}").rstrip()


def sentence(table: Table) -> str:
    """Return the number of runs, and the most accurate run with its cost."""
    rows = table.main
    levels = sorted({row.level for row in rows})
    at = f" at level {levels[0]}" if len(levels) == 1 else ""
    if not any(row.complete for row in rows):
        return f"None of {len(rows)} runs{at} finished: {rows[0].status}, {rows[0].reason}."
    text = f"{len(rows)} runs{at}, {sum(row.finished for row in rows)} finished."
    measured = [row for row in rows if row.finished and row["pressure_error"] >= 0.0]
    return text + (_most_accurate(table, measured) if measured else "")


def _most_accurate(table: Table, rows: Sequence[Row]) -> str:
    """The most accurate run; if others tie within the uncertainty of the reference, all of them, with the cheapest."""
    # Errors below three times the uncertainty of the reference are alike, and so are errors no further apart than twice
    # that: each of them may be off by it.
    known = table.reference.pressure_uncertainty if table.reference is not None else 0.0
    known = 0.0 if math.isnan(known) else known
    best = min(row["pressure_error"] for row in rows)
    alike = [row for row in rows if row["pressure_error"] <= max(CLEAR * known, best + 2.0 * known)]
    best = min(alike, key=lambda row: row["cpu_s"])
    who = f"{series_of(best, table.main)} (slave {best.slave})"
    cost = f"{significant(best['cpu_s'], 2)} CPU seconds"
    if len(alike) == 1:
        error = percent(best["pressure_error"])
        return f" The pressure is most accurate with {who}: {error} % from the reference in {cost}."
    known = table.reference.pressure_uncertainty if table.reference is not None else 0.0
    return (
        f" {len(alike)} of them are equally accurate within the uncertainty of the reference, "
        f"{percent(known)} %: {span(_range(row['pressure_error'] for row in alike), '%')} from it. The cheapest of "
        f"these is {who}: {cost}."
    )
