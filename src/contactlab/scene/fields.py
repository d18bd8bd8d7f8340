"""Declaration of the keys of a scene's tables, and queries of such a declaration.

Parts and the tables of a scene are declared alike, as frozen dataclasses whose fields are the keys.
A field of a scene table says more about itself with `key` (bounds, unit, meaning) or `part` (the
field names a part of this kind).
"""

from __future__ import annotations

import dataclasses
import re
import types
import typing
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar, get_args, get_origin
from weakref import WeakKeyDictionary

from contactlab.errors import NOTHING, Where

T = TypeVar("T")

PartSpec = dict[str, Any]
"""A part as a scene names it: `use` and the part's own fields, all defaults written out."""

ReadPart = Callable[[str, Any, Where], PartSpec]
"""Checks a part of the given kind as it was written (kind, value, where)."""

_HINTS: WeakKeyDictionary[type, dict[str, Any]] = WeakKeyDictionary()
_KEYS: WeakKeyDictionary[type, dict[str, dataclasses.Field[Any]]] = WeakKeyDictionary()

NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_-]*")


def key(
    default: Any = NOTHING,
    *,
    says: str,
    unit: str = "",
    above: float | None = None,
    least: float | None = None,
    most: float | None = None,
) -> Any:
    """A key of a scene table: `above` is an open bound, `least` and `most` are closed ones."""
    metadata = {"says": says, "unit": unit, "above": above, "least": least, "most": most}
    return _field(default, metadata)


def part(kind: str, default: Any = NOTHING, *, says: str) -> Any:
    """A key that names a part of `kind`, or holds a table or list of such parts."""
    return _field(default, {"says": says, "part": kind})


def _field(default: Any, metadata: dict[str, Any]) -> Any:
    if default is NOTHING:
        return dataclasses.field(metadata=metadata)
    if isinstance(default, dict | list):
        return dataclasses.field(default_factory=default.copy, metadata=metadata)
    return dataclasses.field(default=default, metadata=metadata)


def hidden(default: Any) -> Any:
    """A field that is no key: nobody writes it in a file."""
    return dataclasses.field(default=default, repr=False, compare=False, metadata={"hidden": True})


def keys_of(cls: type) -> Mapping[str, dataclasses.Field[Any]]:
    """The keys that a table read into `cls` may have, in the order of declaration.

    A key that is a word of Python's own has a field with an underscore behind it: `from_` is the key `from`.
    """
    if cls not in _KEYS:
        fields = (f for f in dataclasses.fields(cls) if f.init and not f.metadata.get("hidden"))
        _KEYS[cls] = {f.name.rstrip("_"): f for f in fields}
    return _KEYS[cls]


def hints_of(cls: type) -> Mapping[str, Any]:
    """Types of the keys of a table, worked out once for a class."""
    if cls not in _HINTS:
        hints = typing.get_type_hints(cls)
        _HINTS[cls] = {name: hints[field.name] for name, field in keys_of(cls).items()}
    return _HINTS[cls]


def is_required(field: dataclasses.Field[Any]) -> bool:
    """True if the key has no default."""
    return field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING


def as_data(instance: Any) -> dict[str, Any]:
    """A dataclass as a plain nested dict; keys without a value, or with an empty table, are left out."""
    values = {name: getattr(instance, field.name) for name, field in keys_of(type(instance)).items()}
    return {name: _plain(value) for name, value in values.items() if value is not None and value != {}}


def _plain(value: Any) -> Any:
    if isinstance(value, str | float | int):  # most values
        return value
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return as_data(value)
    if isinstance(value, Mapping):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return str(value) if isinstance(value, Path) else value


def kind_at(cls: type, path: Sequence[str]) -> str | None:
    """The kind of the part that the key `path` names in a table read into `cls`, None if it names none."""
    if not path or path[0] not in keys_of(cls):
        return None
    field, rest = keys_of(cls)[path[0]], path[1:]
    for hint in _steps(hints_of(cls)[path[0]]):
        if dataclasses.is_dataclass(hint) and isinstance(hint, type):
            return kind_at(hint, rest)
        if hint in (PartSpec, PartSpec | None):
            return field.metadata.get("part") if not rest else None
        if not rest:
            return None
        rest = rest[1:]
    return None


def _steps(hint: Any) -> Iterator[Any]:
    """A type and what it holds, outermost first: a mapping or list takes one step of a path each."""
    while True:
        if get_origin(hint) in (typing.Union, types.UnionType) and hint != PartSpec | None:
            hint = next(
                (option for option in get_args(hint) if dataclasses.is_dataclass(option) or get_args(option)), None
            )
        yield hint
        inner = get_args(hint)
        if not inner:
            return
        hint = inner[0] if get_origin(hint) in (tuple, list) else inner[-1]


__all__ = [
    "NAME",
    "PartSpec",
    "ReadPart",
    "as_data",
    "hidden",
    "hints_of",
    "is_required",
    "key",
    "keys_of",
    "kind_at",
    "part",
]
