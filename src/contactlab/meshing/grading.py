"""Coordinates along one direction of a structured mesh: spans of cells, equal or geometrically graded."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from contactlab.api import Floats

Counts = int | tuple[int, ...]
"""Cells of each span at level 1; a number if there is one span."""

Ratios = float | tuple[float, ...]
"""Last over first cell size of each span; a number for all spans."""


@dataclass(frozen=True)
class Axis:
    """Stations (c + 1,) [mm] of the corner nodes along one direction, c cells.

    Nodes between corners lie in the middle, whatever the grading: a quadratic edge wants its inner
    node there.
    """

    stations: Floats

    @property
    def cells(self) -> int:
        """Number of cells along the graded direction."""
        return len(self.stations) - 1

    def __call__(self, s: Floats) -> Floats:
        """Coordinates [mm] at lattice positions s, 0 at the first and 1 at the last corner node."""
        return np.interp(s * self.cells, np.arange(self.cells + 1), self.stations)


def axis(ends: tuple[float, ...], counts: Counts, ratios: Ratios, level: int) -> Axis:
    """The axis through `ends` with `level` times `counts` cells.

    Within a span sizes form a geometric row. Corner nodes of level 1 are corner nodes of every level.
    """
    numbers = (counts,) if isinstance(counts, int) else counts
    given = (ratios,) if isinstance(ratios, int | float) else ratios
    grades = given * len(numbers) if len(given) == 1 else given
    parts = [np.array([ends[0]])]
    for low, high, count, ratio in zip(ends[:-1], ends[1:], numbers, grades, strict=True):
        parts.append(low + (high - low) * shares(count, float(ratio), level)[1:])
    return Axis(np.concatenate(parts))


def shares(count: int, ratio: float, level: int) -> Floats:
    """Positions (count * level + 1,) of the corner nodes of a span, from 0 to 1; `ratio` as at level 1."""
    xi = np.linspace(0.0, 1.0, count * level + 1)
    if ratio == 1.0 or count == 1:
        return xi
    growth = np.log(ratio) * count / (count - 1)
    return np.asarray(np.expm1(growth * xi) / np.expm1(growth))


def check_axis(name: str, ends: tuple[float, ...], place: int, counts: Counts, ratios: Ratios) -> None:
    """Raise ValueError if spans, counts and ratios do not fit; `place` is the axis' own in cells and grading."""
    if len(ends) < 2 or not all(low < high for low, high in pairwise(ends)):
        raise ValueError(f"{name}: got {list(ends)}, allowed: at least two increasing coordinates [mm]")
    check_counts(counts, len(ends) - 1, f"cells: got {counts} at place {place}")
    check_ratios(ratios, len(ends) - 1, f"grading: got {ratios} at place {place}")


def check_counts(counts: Counts, spans: int, got: str) -> None:
    """Raise ValueError unless there is a count of at least 1 for each span."""
    numbers = (counts,) if isinstance(counts, int) else counts
    if len(numbers) != spans or min(numbers) < 1:
        raise ValueError(f"{got}, allowed: a count of at least 1 for each of the {spans} spans")


def check_ratios(ratios: Ratios, spans: int, got: str) -> None:
    """Raise ValueError unless there are positive ratios, one for all spans or one for each."""
    numbers = (ratios,) if isinstance(ratios, int | float) else ratios
    if len(numbers) not in (1, spans) or not all(0.0 < ratio < np.inf for ratio in numbers):
        raise ValueError(f"{got}, allowed: last over first cell size, > 0, one for all {spans} spans or one for each")
