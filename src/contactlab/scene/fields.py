"""Tables of a scene file become frozen dataclasses: the one place where written values are checked.

Parts and the tables of a scene are declared alike, as frozen dataclasses whose fields are the keys.
A field of a scene table says more about itself with `key` (bounds, unit, meaning) or `part` (the
field names a part of this kind).
"""

from __future__ import annotations

import dataclasses
import math
import re
import types
import typing
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, TypeVar, get_args, get_origin

from contactlab.errors import NOTHING, Location, SceneError, Where, below, did_you_mean

T = TypeVar("T")

PartSpec = dict[str, Any]
"""A part as a scene names it: `use` and the part's own fields, all defaults written out."""

ReadPart = Callable[[str, Any, Where], PartSpec]
"""Checks a part of the given kind as it was written (kind, value, where)."""

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


def keys_of(cls: type) -> dict[str, dataclasses.Field[Any]]:
    """The keys that a table read into `cls` may have, in the order of declaration."""
    return {f.name: f for f in dataclasses.fields(cls) if f.init and not f.metadata.get("hidden")}


def is_required(field: dataclasses.Field[Any]) -> bool:
    """True if the key has no default."""
    return field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING


def read_table(cls: type[T], table: Any, where: Where, read_part: ReadPart | None = None, **extra: Any) -> T:
    """An instance of the dataclass `cls` from a table as it was written.

    Raises SceneError for unknown or missing keys, wrong types, numbers out of bounds and for
    whatever the class's own `__post_init__` refuses with ValueError.
    """
    if not isinstance(table, Mapping):
        raise SceneError("a table is needed here", where=where, got=table, allowed=f"keys {', '.join(keys_of(cls))}")
    known = keys_of(cls)
    for name in table:
        if name not in known:
            raise unknown_key(name, list(known), where)
    hints = typing.get_type_hints(cls)
    reader = _Reader(read_part)
    values = {}
    for name, field in known.items():
        if name in table:
            values[name] = reader.field(field, hints[name], table[name], below(where, name))
        elif is_required(field):
            raise _missing_key(cls, field, hints[name], where)
    return construct(cls, {**values, **extra}, where)


def construct(cls: type[T], values: Mapping[str, Any], where: Where) -> T:
    """`cls(**values)`; a ValueError "name: got ..., allowed: ..." becomes an error at that key."""
    try:
        return cls(**values)
    except ValueError as error:
        raise _refused(cls, str(error), values, where) from error


_REFUSAL = re.compile(r"(?P<name>\w+): (?:got (?P<got>.+?), allowed:? (?P<allowed>.+)|(?P<other>.+))", re.DOTALL)


def _refused(cls: type, message: str, values: Mapping[str, Any], where: Where) -> SceneError:
    match = _REFUSAL.fullmatch(message)
    if match is None or match["name"] not in keys_of(cls):
        return SceneError(message or f"{cls.__name__} refuses these values", where=where, got=dict(values))
    at, got = below(where, match["name"]), values.get(match["name"], NOTHING)
    if match["other"]:
        return SceneError(match["other"], where=at, got=got)
    return SceneError("this value is not allowed", where=at, got=got, allowed=match["allowed"])


def unknown_key(name: str, known: list[str], where: Where) -> SceneError:
    """The error for a key that nothing reads."""
    return SceneError(
        f'unknown key "{name}"',
        where=below(where, name),
        got=name,
        allowed=", ".join(known) if known else "no keys at all",
        hint=did_you_mean(name, known),
    )


def _missing_key(cls: type, field: dataclasses.Field[Any], hint: Any, where: Where) -> SceneError:
    says = field.metadata.get("says", "")
    return SceneError(
        f'the key "{field.name}" is missing' + (f" ({says})" if says else ""),
        where=where,
        allowed=_allowed(hint, field.metadata),
        hint=f"add {field.name} = ...",
    )


def as_data(instance: Any) -> dict[str, Any]:
    """A dataclass as a plain nested dict; keys without a value, or with an empty table, are left out."""
    names = keys_of(type(instance))
    values = {name: getattr(instance, name) for name in names}
    return {name: _plain(value) for name, value in values.items() if value is not None and value != {}}


def _plain(value: Any) -> Any:
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
    for hint in _steps(typing.get_type_hints(cls)[path[0]]):
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


class _Reader:
    """Turns one written value into what a type annotation promises."""

    def __init__(self, read_part: ReadPart | None) -> None:
        self.read_part = read_part

    def field(self, field: dataclasses.Field[Any], hint: Any, value: Any, where: Where) -> Any:
        # a default may be what nobody can write, such as an infinite cap
        if not is_required(field) and type(value) is type(field.default) and value == field.default:
            return value
        return self.value(hint, value, where, field.metadata)

    def value(self, hint: Any, value: Any, where: Where, limits: Mapping[str, Any]) -> Any:
        if hint is Any:
            return value
        if "part" in limits and hint in (PartSpec, PartSpec | None):
            return self._part(limits["part"], hint, value, where)
        origin = get_origin(hint)
        if origin in (typing.Union, types.UnionType):
            return self._union(hint, value, where, limits)
        if origin is Literal:
            return _choice(hint, value, where, limits)
        if origin in (tuple, list):
            return self._sequence(hint, value, where, limits)
        if origin in _MAPPINGS or hint in _MAPPINGS:
            return self._mapping(hint, value, where, limits)
        if dataclasses.is_dataclass(hint) and isinstance(hint, type):
            return read_table(hint, value, where, self.read_part)
        return _scalar(hint, value, where, limits)

    def _part(self, kind: str, hint: Any, value: Any, where: Where) -> PartSpec | None:
        if self.read_part is None:
            raise TypeError(f"{where}: no registry to read a part of kind {kind}")
        if hint == PartSpec | None and value == "none":
            return None
        return self.read_part(kind, value, where)

    def _union(self, hint: Any, value: Any, where: Where, limits: Mapping[str, Any]) -> Any:
        options = [option for option in get_args(hint) if option is not type(None)]
        if value is None and len(options) < len(get_args(hint)):
            return None
        fitting = [option for option in options if _looks_like(option, value)]
        if not fitting:
            raise SceneError("wrong type", where=where, got=value, allowed=_allowed(hint, limits))
        return self.value(fitting[0], value, where, {**limits, "options": hint})

    def _sequence(self, hint: Any, value: Any, where: Where, limits: Mapping[str, Any]) -> Any:
        inner = get_args(hint) or (Any, ...)
        if not isinstance(value, list | tuple):
            raise SceneError("a list is needed here", where=where, got=value, allowed=_allowed(hint, limits))
        if get_origin(hint) is list or (len(inner) == 2 and inner[1] is Ellipsis):
            items = [self.value(inner[0], item, below(where, i), limits) for i, item in enumerate(value)]
        elif len(value) != len(inner):
            raise SceneError("wrong number of entries", where=where, got=value, allowed=_allowed(hint, limits))
        else:
            pairs = enumerate(zip(inner, value, strict=True))
            items = [self.value(kind, item, below(where, i), limits) for i, (kind, item) in pairs]
        return items if get_origin(hint) is list else tuple(items)

    def _mapping(self, hint: Any, value: Any, where: Where, limits: Mapping[str, Any]) -> dict[str, Any]:
        if not isinstance(value, Mapping):
            raise SceneError("a table is needed here", where=where, got=value, allowed=_allowed(hint, limits))
        inner = (get_args(hint) or (str, Any))[1]
        for name in value:
            if not NAME.fullmatch(str(name)):
                allowed = "letters, digits, - and _, not beginning with a digit"
                raise SceneError("not a usable name", where=below(where, name), got=name, allowed=allowed)
        return {name: self.value(inner, item, below(where, name), limits) for name, item in value.items()}


_MAPPINGS = (dict, Mapping, typing.get_origin(Mapping[str, int]))


def _looks_like(option: Any, value: Any) -> bool:
    """Whether a written value is meant as this member of a union."""
    origin = get_origin(option)
    if origin is Literal:
        return isinstance(value, str) if isinstance(get_args(option)[0], str) else value in get_args(option)
    if origin in (tuple, list):
        return isinstance(value, list | tuple)
    if origin in _MAPPINGS or option in _MAPPINGS or dataclasses.is_dataclass(option):
        return isinstance(value, Mapping)
    if option is bool:
        return isinstance(value, bool)
    if option in (int, float):
        return isinstance(value, int | float) and not isinstance(value, bool)
    return option is Any or isinstance(value, option)


def _choice(hint: Any, value: Any, where: Where, limits: Mapping[str, Any]) -> Any:
    choices = get_args(hint)
    for choice in choices:
        if value == choice and type(value) is type(choice):
            return choice
    hint_text = did_you_mean(value, [str(choice) for choice in choices]) if isinstance(value, str) else ""
    allowed = _allowed(limits.get("options", hint), limits)
    raise SceneError("not one of the choices", where=where, got=value, allowed=allowed, hint=hint_text)


def _scalar(hint: Any, value: Any, where: Where, limits: Mapping[str, Any]) -> Any:
    allowed = _allowed(limits.get("options", hint), limits)
    if hint in (int, float):
        return _number(hint, value, where, limits, allowed)
    if hint is Path and isinstance(value, str | Path):
        return _path(value, where)
    if isinstance(hint, type) and isinstance(value, hint):
        return value
    tip = "write true or false without quotes" if hint is bool and isinstance(value, str) else ""
    raise SceneError("wrong type", where=where, got=value, allowed=allowed, hint=tip)


def _path(value: str | Path, where: Where) -> Path:
    """Relative paths start where the text that names them lies."""
    folder = where.folder if isinstance(where, Location) else ""
    return (Path(folder) / value).resolve()


def _number(hint: type, value: Any, where: Where, limits: Mapping[str, Any], allowed: str) -> float | int:
    if isinstance(value, bool) or not isinstance(value, int | float) or (hint is int and isinstance(value, float)):
        raise SceneError("wrong type", where=where, got=value, allowed=allowed, hint=_number_hint(hint, value))
    try:
        number = hint(value)
    except OverflowError:
        number = math.inf
    if hint is float and not math.isfinite(number):
        raise SceneError("the number is not finite", where=where, got=value, allowed=allowed)
    if not _within(number, limits):
        raise SceneError("the number is out of bounds", where=where, got=value, allowed=allowed)
    return typing.cast("float | int", number)


def _number_hint(hint: type, value: Any) -> str:
    if isinstance(value, float) and value.is_integer():
        return f"write {int(value)}"
    if isinstance(value, str):
        try:
            float(value)
        except ValueError:
            return ""
        return f"write {value} without quotes"
    return ""


def _within(number: float, limits: Mapping[str, Any]) -> bool:
    above, least, most = limits.get("above"), limits.get("least"), limits.get("most")
    return (above is None or number > above) and (least is None or number >= least) and (most is None or number <= most)


def _allowed(hint: Any, limits: Mapping[str, Any]) -> str:
    """What a key accepts, in words."""
    unit = f" [{limits['unit']}]" if limits.get("unit") else ""
    return accepts(hint, limits) + unit


def accepts(hint: Any, limits: Mapping[str, Any]) -> str:
    """What a key of this type and with these limits accepts, in words, without the unit."""
    origin, inner = get_origin(hint), get_args(hint)
    if "part" in limits and hint in (PartSpec, PartSpec | None):
        return f"the name of a part of kind {limits['part']}, or {{ use = NAME, ... }}"
    if origin in (typing.Union, types.UnionType):
        return " or ".join(accepts(option, limits) for option in inner if option is not type(None))
    if origin is Literal:
        return " or ".join(f'"{choice}"' if isinstance(choice, str) else str(choice) for choice in inner)
    if origin is list or (origin is tuple and inner[-1] is Ellipsis):
        return f"a list, each entry {accepts(inner[0], limits)}"
    if origin is tuple:
        return f"[{', '.join(accepts(item, limits) for item in inner)}]"
    if dataclasses.is_dataclass(hint) and isinstance(hint, type):
        return "a table {" + ", ".join(keys_of(hint)) + "}"
    if origin in _MAPPINGS or hint in _MAPPINGS:
        return f"tables by name, each {accepts(inner[1], limits)}" if inner else "a table"
    words = {int: "a whole number", float: "a number", str: "a text", bool: "true or false", Path: "a path"}
    return words.get(hint, getattr(hint, "__name__", str(hint))) + (_bounds(limits) if hint in (int, float) else "")


def _bounds(limits: Mapping[str, Any]) -> str:
    signs = {"above": ">", "least": ">=", "most": "<="}
    given = [f"{sign} {limits[name]:g}" for name, sign in signs.items() if limits.get(name) is not None]
    return f" {' and '.join(given)}" if given else ""


__all__ = [
    "NAME",
    "PartSpec",
    "ReadPart",
    "accepts",
    "as_data",
    "construct",
    "hidden",
    "is_required",
    "key",
    "keys_of",
    "kind_at",
    "part",
    "read_table",
    "unknown_key",
]
