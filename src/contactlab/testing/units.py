"""Other units: a part whose docstring gives the unit of each field has the same answers in m, ms and kPa."""

from __future__ import annotations

import dataclasses
import re
from typing import Any

import numpy as np

from contactlab.parts.description import units_of
from contactlab.testing.assertions import NotApplicable

TIME, LONG, STRESS = 1e3, 1e-3, 1e3
"""Numbers in ms, m and kPa over those in s, mm and MPa."""
FORCE = STRESS * LONG
"""Factor of forces per thickness."""
CLOSE = 1e-6
"""Relative tolerance: constants below a millionth of the smallest number do not count."""


def scale_of_unit(unit: str, time: float = TIME) -> float | None:
    """Factor of a number in this unit, as `MPa/mm`, in m, ms and kPa; None if it is not made of known units.

    time  the number of new units of time in a second
    """
    base = {
        "mm": LONG, "s": time, "MPa": STRESS, "N": FORCE, "mJ": FORCE * LONG, "t": STRESS * LONG * time**2,
        "1": 1.0, "-": 1.0, "K": 1.0, "degree": 1.0,
    }  # fmt: skip
    scale = 1.0
    unit = re.split(", | or ", unit)[0]  # the first of several units, as for places of a function
    for number, side in enumerate(unit.split("/")):
        for word in side.replace("*", " ").split() or [""]:
            found = re.fullmatch(r"(-|1|[A-Za-z]+)\^?(\d*)", word)
            if found is None or found[1] not in base:
                return None
            scale *= base[found[1]] ** (int(found[2] or 1) * (-1 if number else 1))
    return scale


def in_other_units(part: Any, time: float = TIME) -> Any:
    """The part with its numbers in m, ms and kPa. Raises NotApplicable if the unit of a field is not known."""
    units, other = units_of(type(part)), {}
    for field in dataclasses.fields(part):
        value = getattr(part, field.name)
        numbers = value if isinstance(value, tuple) else (value,)
        if all(number is None or isinstance(number, bool | int | str) for number in numbers):
            continue
        by = scale_of_unit(units.get(field.name, ""), time)
        if by is None or not all(isinstance(number, float) for number in numbers):
            raise NotApplicable(f"its docstring gives no unit of {field.name} in mm, s and MPa")
        other[field.name] = tuple(by * n for n in value) if isinstance(value, tuple) else by * value
    if not other:
        raise NotApplicable("it has no fields with units")
    try:
        return dataclasses.replace(part, **other)
    except ValueError as refused:
        raise NotApplicable(f"the part refuses its numbers in other units: {refused}") from refused


def same_in_other_units(found: Any, wanted: Any, by: float, what: str) -> None:
    """Raise AssertionError unless the numbers in m, ms and kPa are `by` times the numbers in mm, s and MPa."""
    one, other = np.asarray(found, np.float64), by * np.asarray(wanted, np.float64)
    size = float(np.abs(other[np.isfinite(other)]).max(initial=0.0))
    wrong = ~np.isclose(one, other, rtol=CLOSE, atol=CLOSE * 1e-6 * size)
    if wrong.any():
        raise AssertionError(
            f"{what}: units of its fields are inconsistent, or it has a number with a unit of its own "
            f"(got {float(one[wrong][0]):.6g} in m, ms and kPa, expected {float(other[wrong][0]):.6g})"
        )
