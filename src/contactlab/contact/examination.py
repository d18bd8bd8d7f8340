"""Checks that results of contact algorithms are finite, and the messages if not: plugins get finite numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

from contactlab.api import ContactView, Floats
from contactlab.errors import WrongAnswer


def finite(*arrays: Floats) -> bool:
    """Return whether all numbers are finite; sums show it, without an array of booleans."""
    return all(bool(np.isfinite(array.sum())) or bool(np.isfinite(array).all()) for array in arrays)


def refuse(part: Any, method: str, what: str, place: str = "") -> None:
    """Raise WrongAnswer: a method of a plugin component gave a result that is not finite."""
    raise WrongAnswer(f"{type(part).__name__}: {method} gave {what} that is not finite{place}, from finite numbers")


def copies(view: ContactView) -> dict[str, Floats]:
    """Return copies of all arrays of a view except `memory`, which an algorithm may write."""
    return {name: array.copy() for name, array in _arrays(view).items()}


def refuse_written(view: ContactView, before: dict[str, Floats], part: Any, method: str) -> None:
    """Raise WrongAnswer if an algorithm wrote to its view, whose `copies` were made before.

    The surfaces belong to the model: gaps and forces would silently belong to other positions.
    """
    for name, array in _arrays(view).items():
        if not np.array_equal(array, before[name]):
            raise WrongAnswer(
                f"{type(part).__name__}: {method} wrote to {name} of its view, which it may only read\n"
                f"  allowed  a copy to work on: view.{name}.copy()"
            )


def _arrays(view: ContactView) -> dict[str, Floats]:
    parts = {
        "slave": vars(view.slave),
        "master": vars(view.master),
        "at": view.at._asdict(),
        "near": view.near._asdict(),
    }
    held = {f"{name}.{field}": value for name, fields in parts.items() for field, value in fields.items()}
    return {name: value for name, value in held.items() if isinstance(value, np.ndarray)}
