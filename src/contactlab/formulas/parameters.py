"""The parameters p of formulas: the numbers among the fields of a plugin component."""

from __future__ import annotations

from collections import namedtuple
from dataclasses import fields
from functools import cache
from typing import Any

import numpy as np

from contactlab.api import Floats

_NUMBERS = {f"{kind}{rest}" for kind in ("float", "int", "bool") for rest in ("", " | None")}
_NUMBERS |= {str(kind) for kind in (float, int, bool)}


@cache
def numbers_of(kind: type) -> tuple[str, ...]:
    """Return names of the fields that hold a number."""
    return tuple(field.name for field in fields(kind) if str(field.type) in _NUMBERS)


@cache
def parameters_of(kind: type) -> Any:
    """Return the named tuple class of these fields."""
    return namedtuple("Parameters", numbers_of(kind))


def values_of(part: Any) -> Floats:
    """Return the numbers (n, 1) of a plugin component; NaN for None."""
    values = [getattr(part, name) for name in numbers_of(part.__class__)]
    return np.array([np.nan if x is None else float(x) for x in values]).reshape(-1, 1)
