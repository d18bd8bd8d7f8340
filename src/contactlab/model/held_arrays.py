"""All arrays that an object holds, found by walking it."""

from __future__ import annotations

import functools
import types
from collections import deque
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from contactlab.model.model import Model

DEPTH = 12
COMPILERS = ("numba", "llvmlite")  # kernels hold no arrays of a model
OPAQUE = (type, types.ModuleType, types.BuiltinFunctionType, str, bytes, int, float, bool, type(None), np.generic)


class HeldArray(NamedTuple):
    """An array: its path, its shape, and the bytes that are its own."""

    name: str
    shape: str
    bytes: int


def held_arrays(model: Model, **others: Any) -> list[HeldArray]:
    """Return all arrays reachable from a model and from `others`, each piece of memory once.

    Fields of the model's state come first; `others` are, for example, arrays bound by an integrator, under the name
    of their report. Arrays of classes and modules are not counted, all runs share them; empty
    arrays are not listed.
    """
    found = [_held(f"state.{name}", field) for name, field in model.state.fields.items()]
    seen = {id(model.state.buffer)}
    for name, value in ({"": model} | others).items():
        _walk(found, name, value, seen, DEPTH)
    return found


def _held(name: str, array: np.ndarray) -> HeldArray:
    return HeldArray(name, " x ".join(str(n) for n in array.shape), int(array.nbytes))


def _walk(found: list[HeldArray], name: str, value: object, seen: set[int], depth: int) -> None:
    """Add the arrays in `value` that were not seen before to those found."""
    if isinstance(value, np.ndarray):
        owner = _owner(value)
        if id(owner) not in seen:
            seen.add(id(owner))
            if owner.size:
                found.append(_held(name, owner))
            if owner.dtype == object:
                _walk_inside(found, name, {str(k): item for k, item in enumerate(owner.flat)}, seen, depth)
    elif depth > 0 and id(value) not in seen:
        seen.add(id(value))
        _walk_inside(found, name, _children(value), seen, depth)


def _walk_inside(found: list[HeldArray], name: str, children: Mapping[str, Any], seen: set[int], depth: int) -> None:
    for key, child in children.items():
        kind: Any = type(child)
        if not _opaque(kind):
            _walk(found, f"{name}.{key}".strip("."), child, seen, depth - 1)


@functools.cache
def _opaque(kind: Any) -> bool:
    """Whether nothing is looked for in objects of a type."""
    return issubclass(kind, OPAQUE) or kind.__module__.partition(".")[0] in COMPILERS


def _owner(array: np.ndarray) -> np.ndarray:
    """Return the array whose memory a view shows."""
    while isinstance(array.base, np.ndarray):
        array = array.base
    return array


def _children(value: object) -> Mapping[str, Any]:
    if isinstance(value, Mapping):
        return {str(key): child for key, child in value.items()}
    if isinstance(value, tuple | list | set | frozenset | deque):
        names = getattr(value, "_fields", None) or range(len(value))
        return {str(key): child for key, child in zip(names, value, strict=True)}
    if isinstance(value, types.MethodType):
        return {"": value.__self__}
    if isinstance(value, types.FunctionType):
        cells = zip(value.__code__.co_freevars, value.__closure__ or (), strict=True)
        return {name: cell.cell_contents for name, cell in cells if not _empty(cell)} | vars(value)
    if isinstance(value, functools.partial):
        return {"": (value.func, value.args, value.keywords)}
    return getattr(value, "__dict__", {})


def _empty(cell: types.CellType) -> bool:
    try:
        cell.cell_contents  # noqa: B018 - asks whether it has any
    except ValueError:
        return True
    return False
