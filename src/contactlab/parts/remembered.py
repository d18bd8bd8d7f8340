"""Memory of parts by name: numbers are checked before they become a part of the state."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from contactlab.api import Floats
from contactlab.errors import WrongAnswer


def remember(part: Any, method: str, found: Mapping[str, Any], rows: Mapping[str, Floats]) -> None:
    """Write what a method of a part found into the rows (k,) of its memory; raise WrongAnswer for other names."""
    for name, values in found.items():
        if name not in part.memory:
            raise WrongAnswer(
                f"{type(part).__name__}: {method} gave {name}, needed: what its memory names, {part.memory}"
            )
        rows[name][:] = checked(part, f"{method} gave {name}", values, len(rows[name]))


def checked(part: Any, what: str, values: Any, k: int, least: float = -math.inf) -> Floats:
    """Numbers of at least `least` for k entries; raise WrongAnswer for others, and for another shape."""
    found = np.asarray(values, np.float64)
    if found.shape not in ((), (k,)):
        raise WrongAnswer(f"{type(part).__name__}: {what} of shape {found.shape}, needed: a number or ({k},)")
    if not (found >= least).all():  # not a number is not at least anything
        raise WrongAnswer(f"{type(part).__name__}: {what} {float(found.min()):g}, needed: numbers >= {least:g}")
    return found
