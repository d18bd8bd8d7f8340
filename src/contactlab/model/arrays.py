"""Every array that a model really holds, found by walking it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from contactlab.model.model import Model


class HeldArray(NamedTuple):
    """An array of a model: where it hangs, its shape, and the bytes that are its own."""

    name: str
    shape: str
    bytes: int


def held_arrays(model: Model) -> list[HeldArray]:
    """All arrays reachable from the model, each piece of memory once, in the order of the model's fields."""
    seen: set[int] = set()
    found: list[HeldArray] = []
    for name, field in model.state.fields.items():
        seen.add(id(field))
        found.append(_held(f"state.{name}", field))
    seen.add(id(model.state.buffer))
    base = model.state.buffer
    for name, array in _walk("", model, seen, depth=6):
        if array.base is base or any(array is f for f in model.state.fields.values()):
            continue
        found.append(_held(name, array))
    return found


def _held(name: str, array: np.ndarray) -> HeldArray:
    return HeldArray(name, " x ".join(str(n) for n in array.shape), int(array.nbytes))


def _walk(name: str, value: Any, seen: set[int], depth: int) -> Iterator[tuple[str, np.ndarray]]:
    if id(value) in seen or depth < 0:
        return
    if isinstance(value, np.ndarray):
        seen.add(id(value))
        owner = value if value.base is None else value.base
        if isinstance(owner, np.ndarray) and owner is not value:
            if id(owner) in seen:
                return
            seen.add(id(owner))
        if value.size:
            yield name, value
        return
    for key, child in _children(value):
        seen.add(id(value))
        yield from _walk(f"{name}.{key}" if name else key, child, seen, depth - 1)


def _children(value: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping):
        yield from ((str(key), child) for key, child in value.items())
    elif isinstance(value, tuple | list):
        names = getattr(value, "_fields", None) or range(len(value))
        yield from ((str(key), child) for key, child in zip(names, value, strict=True))
    elif type(value).__module__.startswith("contactlab") and hasattr(value, "__dict__"):
        yield from vars(value).items()
