"""Records with every number changed, to see whether what is found in them follows from them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from typing import Any

import numpy as np

from contactlab.api import ContactCurve, Record

NUMBERS = tuple(name for name in ContactCurve.COLUMNS if name not in ("x", "y", "state"))
"""Columns of a curve whose numbers are changed: states stay, places are stretched, so that it is still a curve."""


Draw = Callable[[tuple[int, ...]], Any]
"""Random factors of a shape."""


def spoilt(record: Record, seed: int = 1, signs: bool = False) -> Record:
    """The record with each number multiplied by its own random factor between 1/2 and 2: no ratio stays either.

    signs  half of the factors are negative, so that what is counted by its sign changes, too
    """
    rng = np.random.default_rng(seed)

    def draw(shape: tuple[int, ...]) -> Any:
        return rng.uniform(0.5, 2.0, shape) * (rng.choice((-1.0, 1.0), shape) if signs else 1.0)

    curves = {name: [_curve(curve, draw) for curve in some] for name, some in record.curves.items()}
    changed = {
        field.name: _changed(getattr(record, field.name), draw)
        for field in fields(record)
        if field.name in ("summary", "history", "watched", "displacement", "velocity", "stress")
    }
    return replace(record, curves=curves, **changed)


def spoilt_curves(record: Record) -> Record:
    """The record with other numbers for all that acts in its curves; places and states stay."""
    others = spoilt(record).curves
    curves = {
        name: [replace(other, x=curve.x, y=curve.y) for other, curve in zip(others[name], some, strict=True)]
        for name, some in record.curves.items()
    }
    return replace(record, curves=curves)


def unknown(record: Record) -> Record:
    """The record with NaN for all that acts in its curves."""
    curves = {name: [_unknown(curve) for curve in some] for name, some in record.curves.items()}
    return replace(record, curves=curves)


def _unknown(curve: ContactCurve) -> ContactCurve:
    columns = {name: getattr(curve, name) for name in NUMBERS}
    return replace(curve, **{name: np.nan * column for name, column in columns.items() if column.dtype.kind == "f"})


def _curve(curve: ContactCurve, draw: Draw) -> ContactCurve:
    numbers = {name: _changed(getattr(curve, name), draw) for name in NUMBERS}
    return replace(curve, x=1.3 * curve.x, y=1.3 * curve.y, **numbers)


def _changed(value: Any, draw: Draw) -> Any:
    if isinstance(value, Mapping):
        return {name: _changed(item, draw) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return type(value)([_changed(item, draw) for item in value])
    if isinstance(value, np.ndarray):
        return value * draw(value.shape) if value.dtype.kind == "f" else value
    if isinstance(value, bool) or not isinstance(value, int | float):
        return value
    return type(value)(value * float(draw(())))
