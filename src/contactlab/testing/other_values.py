"""The same part with other values of its fields: required numbers must have an effect."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np

from contactlab.scene.fields import is_required
from contactlab.testing.examples import USUAL

FACTOR = 1.3  # leaves usual numbers in their bounds: Poisson's ratio 0.3 becomes 0.39


def others(part: Any) -> Iterator[tuple[str, Any]]:
    """The part with each number that has no default changed in turn, and the name of the field."""
    for field, other in _changed(part):
        if is_required(field):
            yield field.name, other


def any_others(part: Any) -> Iterator[tuple[str, Any]]:
    """The part with each number changed in turn, one with a default as well, and the name of the field."""
    yield from changed(part)
    yield from switched_on(part)


def changed(part: Any) -> Iterator[tuple[str, Any]]:
    """The part with each number but 0 changed in turn, one with a default as well, and the name of the field."""
    yield from ((field.name, other) for field, other in _changed(part))


def _changed(part: Any) -> Iterator[tuple[Any, Any]]:
    for field in dataclasses.fields(part):
        value = getattr(part, field.name)
        if not _is_number(value):
            continue
        changed = tuple(FACTOR * np.asarray(value)) if isinstance(value, tuple) else FACTOR * value
        try:
            yield field, dataclasses.replace(part, **{field.name: changed})
        except ValueError:
            continue  # out of the bounds that the part sets itself


def switched_on(part: Any) -> Iterator[tuple[str, Any]]:
    """The part with each number that is 0 by default at its usual value, and the name of the field."""
    for field in dataclasses.fields(part):
        if field.default == 0.0 and getattr(part, field.name) == 0.0 and field.name in USUAL:
            yield field.name, dataclasses.replace(part, **{field.name: USUAL[field.name]})


def _is_number(value: Any) -> bool:
    numbers = value if isinstance(value, tuple) else (value,)
    return all(isinstance(n, float) and np.isfinite(n) for n in numbers) and any(numbers)
