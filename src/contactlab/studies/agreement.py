"""How far two algorithms are from each other on the same run: no reference needed."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

from contactlab.studies.measures import mutual_difference, relative_difference
from contactlab.studies.table import Row


@dataclass(frozen=True)
class Agreement:
    """Two algorithms on runs that differ in nothing else.

    varied    what else they share of what the study varies
    reaction  relative difference of the reactions
    pressure  2 ||p_a - p_b|| / (||p_a|| + ||p_b||)
    """

    first: str
    second: str
    slave: str
    level: int
    reaction: float
    pressure: float
    varied: str = ""


def agreements(rows: Sequence[Row]) -> list[Agreement]:
    """All pairs of algorithms whose runs carried the load to its end, run by run."""
    groups: dict[tuple[str, int, str], list[Row]] = {}
    for row in (row for row in rows if row.complete):
        groups.setdefault((row.slave, row.level, str(row.choices)), []).append(row)
    return [_compare(a, b) for group in groups.values() for a, b in itertools.combinations(group, 2)]


def _compare(a: Row, b: Row) -> Agreement:
    pressure = math.nan
    if a.profile is not None and b.profile is not None:
        pressure = mutual_difference(a.profile, b.profile)
    reaction = relative_difference(a["reaction"], b["reaction"])
    varied = ", ".join(f"{key} = {value}" for key, value in a.choices.items())
    return Agreement(a.algorithm, b.algorithm, a.slave, a.level, reaction, pressure, varied)
