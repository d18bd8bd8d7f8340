"""Profiles: spatial variation of values, a key that loads, supports, bodies and effects share."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

Vector = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Profile:
    """Variation of values along edges or over a body: `{ by = "x", cosine = [mean, amplitude, period] }`.

    Effects declare a field `profile: Profile | None = None` and ask their view for its `factors`.
    """

    by: Literal["x", "y", "angle", "s"] = field(
        metadata={
            "says": "what it varies with, where the mesh stands at the start; angle: in degrees from the x axis, -180 "
            "to 180; s: arc length along the edge set in mm, from where it begins with the body on the left"
        }
    )
    centre: Vector = field(default=(0.0, 0.0), metadata={"says": "of the angle", "unit": "mm"})
    cosine: tuple[float, float, float] | None = field(
        default=None,
        metadata={
            "says": "mean, amplitude and period [mm or degrees]: the factor is mean + amplitude cos(2 pi by/period)"
        },
    )
    table: tuple[Vector, ...] | None = field(
        default=None, metadata={"says": "pairs of [by, factor], rising; linear between them, constant beyond"}
    )
    file: Path | None = field(default=None, metadata={"says": "CSV file with such pairs, without a head"})
    function: dict[str, Any] | None = field(
        default=None, metadata={"says": "any other function of `by`", "part": "function"}
    )
    mean: float | None = field(
        default=None,
        metadata={
            "says": "of a load: all factors are multiplied by one number so that their mean along the edges of the "
            "mesh is this, so that the resultant is the same on every mesh; not written: factors stay as they are"
        },
    )

    def __post_init__(self) -> None:
        if sum(value is not None for value in (self.cosine, self.table, self.file, self.function)) != 1:
            raise ValueError("one of these four says how the values vary: cosine, table, file, function")
        if self.cosine is not None and not self.cosine[2] > 0.0:
            raise ValueError(f"cosine: got {list(self.cosine)}, allowed: a period > 0")
        if self.table is not None and (len(self.table) < 2 or any(b[0] <= a[0] for a, b in pairwise(self.table))):
            raise ValueError("table: got pairs that do not rise, allowed: two or more with rising first numbers")
