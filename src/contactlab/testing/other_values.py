"""The same part with other values of its fields: required numbers must have an effect."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Callable, Iterator
from typing import Any, get_args

import numpy as np

from contactlab.scene.fields import hints_of, is_required
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


def without_effect(part: Any, observe: Callable[[Any], Any]) -> list[str]:
    """Fields with numbers of which no other value changes what is observed, whatever the other fields are.

    `observe` gives arrays or numbers of a part; what it raises under an extreme value is a change as well.
    """
    left = {f.name for f in dataclasses.fields(part) if _numbers(getattr(part, f.name))}
    for base in (part, *(other for _, other in varied(part))):
        plain = _observed(base, observe) if left else None
        for name in sorted(left):
            if any(not _same(_observed(other, observe), plain) for other in _extremes(base, name)):
                left.remove(name)
    return [f.name for f in dataclasses.fields(part) if f.name in left]


def _numbers(value: Any) -> bool:
    entries = value if isinstance(value, tuple) else (value,)
    return bool(entries) and all(isinstance(n, int | float) and not isinstance(n, bool) for n in entries)


def _extremes(part: Any, name: str) -> Iterator[Any]:
    """The part with a number a little and very different: a tolerance or a cut-off may act far away only."""
    value = getattr(part, name)
    entries = value if isinstance(value, tuple) else (value,)
    for factor in (FACTOR, 0.8, 1e-3, 1e3, 1e6, 1e-6, 0.0, -1.0):
        # of 0 and of no limit at all: a usual number in their place
        usual = USUAL.get(name, 1.0) if isinstance(USUAL.get(name, 1.0), float) else 1.0
        try:
            changed = [type(n)(factor * (n if n and np.isfinite(n) else usual)) for n in entries]
            yield dataclasses.replace(part, **{name: tuple(changed) if isinstance(value, tuple) else changed[0]})
        except (ValueError, TypeError, OverflowError):
            continue  # out of the bounds that the part sets itself


def _observed(part: Any, observe: Callable[[Any], Any]) -> Any:
    try:
        with np.errstate(all="ignore"):
            return observe(part)
    except Exception as error:
        return repr(error)


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(_same(one[name], other[name]) for name in one)
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(_same(a, b) for a, b in zip(one, other, strict=True))
    if isinstance(one, np.ndarray | float):
        return np.array_equal(one, other, equal_nan=True)
    return bool(one == other)


def varied(part: Any) -> Iterator[tuple[str, Any]]:
    """The part with each number, integer and choice changed in turn, each entry of a tuple for itself.

    Yields the name of the field, with the number of the entry for tuples, and the other part.
    """
    hints = hints_of(type(part))
    for field in dataclasses.fields(part):
        for name, value in _varied(field.name, getattr(part, field.name), hints[field.name]):
            try:
                other = dataclasses.replace(part, **{field.name: value})
            except ValueError:
                continue  # out of the bounds that the part sets itself
            yield name, other


def _varied(name: str, value: Any, hint: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(value, bool):
        yield name, not value
    elif isinstance(value, int):
        yield from ((name, value + 1), (name, value - 1))
    elif isinstance(value, float) and np.isfinite(value):
        yield from ((name, FACTOR * value if value else 0.6), (name, 0.8 * value if value else -0.7))
    elif isinstance(value, str):
        yield from ((name, other) for other in get_args(hint) if isinstance(other, str) and other != value)
    elif isinstance(value, tuple):
        for k, entry in enumerate(value):
            for _, other in _varied("", entry, None):
                yield f"{name}[{k}]", (*value[:k], other, *value[k + 1 :])


def _changed(part: Any) -> Iterator[tuple[Any, Any]]:
    for field in dataclasses.fields(part):
        value = getattr(part, field.name)
        numbers = value if isinstance(value, tuple) else (value,)
        if not (all(isinstance(n, float) and np.isfinite(n) for n in numbers) and any(numbers)):
            continue
        changed = tuple(FACTOR * np.asarray(value)) if isinstance(value, tuple) else FACTOR * value
        try:
            yield field, dataclasses.replace(part, **{field.name: changed})
        except ValueError:
            continue  # out of the bounds that the part sets itself


def switched_on(part: Any) -> Iterator[tuple[str, Any]]:
    """The part with each number that is 0 by default at its usual value, and the name of the field."""
    for name in _zeros(part):
        if name in USUAL:
            yield name, dataclasses.replace(part, **{name: USUAL[name]})


def set_from_zero(part: Any) -> Iterator[tuple[str, *tuple[Any, ...]]]:
    """The name of each number that is 0 by default, and the part with it set to 1, alone and with all such numbers.

    Zero often means that another number counts. Values that the part refuses are left out.
    """
    zero = {name: 1.0 for name in _zeros(part) if isinstance(getattr(part, name), float)}
    for name in zero:
        found = []
        for values in ({name: 1.0}, zero):
            with contextlib.suppress(ValueError):
                found.append(dataclasses.replace(part, **values))
        if found:
            yield name, *found


def _zeros(part: Any) -> list[str]:
    """Fields that are 0 by default and in the part."""
    return [f.name for f in dataclasses.fields(part) if f.default == 0.0 and getattr(part, f.name) == 0.0]
