"""The part's own length and time, by the fields that it names in `length_scale` and `time_scale`."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

from contactlab.testing.assertions import Check, NotApplicable, require

AROUND = (0.01, 1.0, 100.0)
"""Steps to try a part with that has a time of its own, over that time."""


def scale_of(part: Any, name: str, otherwise: float) -> float:
    """The value of the field that the class attribute `name` names; `otherwise` if it names none."""
    field = getattr(part, name)
    if not field:
        return otherwise
    known = [one.name for one in dataclasses.fields(part)]
    require(field in known, f"{name}: got {field!r}, allowed: fields of the part: {', '.join(known)}")
    value = getattr(part, field)
    sound = isinstance(value, int | float) and math.isfinite(value) and value > 0.0
    require(sound, f"{name}: its field {field} is {value!r}, allowed: a number above 0")
    return float(value)


def scales_are_fields(part: Any) -> None:
    """`length_scale` and `time_scale`, if given, name a field with a number above 0."""
    names = [name for name in ("length_scale", "time_scale") if getattr(part, name, "")]
    if not names:
        raise NotApplicable("the part declares no length and no time of its own")
    for name in names:
        scale_of(part, name, 1.0)


CHECKS: tuple[Check, ...] = (scales_are_fields,)
