"""Tables of a scene file become frozen dataclasses: the one place where written values are checked."""

from __future__ import annotations

import dataclasses
import re
import types
import typing
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, TypeVar, get_args, get_origin

from contactlab.errors import NOTHING, Gathered, SceneError, Where, below, did_you_mean, nearest
from contactlab.scene.accepts import MAPPINGS, in_words
from contactlab.scene.fields import NAME, PartSpec, ReadPart, hints_of, is_required, keys_of
from contactlab.scene.scalars import choice, scalar

T = TypeVar("T")


def read_table(cls: type[T], table: Any, where: Where, read_part: ReadPart | None = None, **extra: Any) -> T:
    """An instance of the dataclass `cls` from a table as it was written.

    Raises SceneError for unknown or missing keys, wrong types, numbers out of bounds, all of them in one error, and for
    whatever the class's own `__post_init__` refuses with ValueError.
    """
    if not isinstance(table, Mapping):
        raise SceneError("a table is needed here", where=where, got=table, allowed=f"keys {', '.join(keys_of(cls))}")
    known = keys_of(cls)
    gathered, unknown = Gathered(), [name for name in table if name not in known]
    gathered.found += [unknown_key(name, list(known), where) for name in unknown]
    meant = {nearest(str(name), known) for name in unknown}
    hints = hints_of(cls)
    reader = _Reader(read_part)
    values = {}
    for name, field in known.items():
        if name in table:
            with gathered:
                values[field.name] = reader.field(field, hints[name], table[name], below(where, name))
        elif is_required(field) and name not in meant:
            gathered.found.append(_missing_key(field, hints[name], list(table), where))
    gathered.tell()
    return construct(cls, {**values, **extra}, where)


def construct(cls: type[T], values: Mapping[str, Any], where: Where) -> T:
    """`cls(**values)`; a ValueError "name: got ..., allowed: ..." becomes an error at that key."""
    try:
        return cls(**values)
    except ValueError as error:
        raise _refused(cls, str(error), values, where) from error


_REFUSAL = re.compile(r"(?P<name>\w+): (?:got (?P<got>.+?), allowed:? (?P<allowed>.+)|(?P<other>.+))", re.DOTALL)


def _told(message: str, where: Where, got: object) -> SceneError:
    """The error of a message "problem: what is allowed"."""
    problem, _, allowed = message.rpartition(": ")
    return SceneError(problem or message, where=where, got=got, allowed=allowed if problem else "")


def _refused(cls: type, message: str, values: Mapping[str, Any], where: Where) -> SceneError:
    match = _REFUSAL.fullmatch(message)
    if match is None or match["name"] not in keys_of(cls):
        message = message or f"{cls.__name__} refuses these values"
        return _told(message, where, {key: value for key, value in values.items() if value is not None})
    at, got = below(where, match["name"]), values.get(keys_of(cls)[match["name"]].name, NOTHING)
    if match["other"]:
        return _told(match["other"], at, got)
    got = match["got"] if got is NOTHING else got
    return SceneError("this value is not allowed", where=at, got=got, allowed=match["allowed"])


def refused_later(cls: type, problem: str, message: str, where: Where) -> SceneError:
    """Return a part's refusal after it was read, "name: got ..., allowed: ...", as an error at that key."""
    match = _REFUSAL.fullmatch(message)
    if match is None or match["name"] not in keys_of(cls):
        return SceneError(f"{problem}: {message}", where=where)
    at = below(where, match["name"])
    if match["other"]:
        return SceneError(f"{problem}: {match['other']}", where=at)
    return SceneError(problem, where=at, got=match["got"], allowed=match["allowed"])


def unknown_key(name: str, known: list[str], where: Where) -> SceneError:
    """Make the error for a key that nothing reads."""
    return SceneError(
        f'unknown key "{name}"',
        where=below(where, name),
        got=name,
        allowed=", ".join(known) if known else "no keys at all",
        hint=did_you_mean(str(name), known),
    )


def _missing_key(field: dataclasses.Field[Any], hint: Any, written: list[str], where: Where) -> SceneError:
    says = field.metadata.get("says", "")
    return SceneError(
        f'the key "{field.name}" is missing' + (f" ({says})" if says else ""),
        where=where if str(where) else field.name,
        got=written,
        allowed=in_words(hint, field.metadata),
        hint=f"add {field.name} = ...",
    )


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
            return choice(hint, value, where, limits)
        if origin in (tuple, list):
            return self._sequence(hint, value, where, limits)
        if origin in MAPPINGS or hint in MAPPINGS:
            return self._mapping(hint, value, where, limits)
        if dataclasses.is_dataclass(hint) and isinstance(hint, type):
            return read_table(hint, value, where, self.read_part)
        return scalar(hint, value, where, limits)

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
            raise SceneError("wrong type", where=where, got=value, allowed=in_words(hint, limits))
        return self.value(fitting[0], value, where, {**limits, "options": hint})

    def _sequence(self, hint: Any, value: Any, where: Where, limits: Mapping[str, Any]) -> Any:
        inner = get_args(hint) or (Any, ...)
        if isinstance(value, str) and inner == (str, ...):
            value = [value]
        if not isinstance(value, list | tuple):
            raise SceneError("a list is needed here", where=where, got=value, allowed=in_words(hint, limits))
        if get_origin(hint) is list or (len(inner) == 2 and inner[1] is Ellipsis):
            items = list(self._all(inner[0], dict(enumerate(value)), where, limits).values())
        elif len(value) != len(inner):
            raise SceneError("wrong number of entries", where=where, got=value, allowed=in_words(hint, limits))
        else:
            pairs = enumerate(zip(inner, value, strict=True))
            items = [self.value(kind, item, below(where, i), limits) for i, (kind, item) in pairs]
        return items if get_origin(hint) is list else tuple(items)

    def _mapping(self, hint: Any, value: Any, where: Where, limits: Mapping[str, Any]) -> dict[str, Any]:
        if not isinstance(value, Mapping):
            raise SceneError("a table is needed here", where=where, got=value, allowed=in_words(hint, limits))
        inner = (get_args(hint) or (str, Any))[1]
        for name in value:
            if not NAME.fullmatch(str(name)):
                allowed = "letters, digits, - and _, not beginning with a digit"
                raise SceneError("not a usable name", where=below(where, name), got=name, allowed=allowed)
        return self._all(inner, value, where, limits)

    def _all(self, hint: Any, items: Mapping[Any, Any], where: Where, limits: Mapping[str, Any]) -> dict[Any, Any]:
        """Return all items as what `hint` promises. Raises one error for all that are wrong."""
        gathered, found = Gathered(), {}
        for name, item in items.items():
            with gathered:
                found[name] = self.value(hint, item, below(where, name), limits)
        gathered.tell()
        return found


def _looks_like(option: Any, value: Any) -> bool:
    """Return whether a written value is meant as this member of a union."""
    origin = get_origin(option)
    if origin is Literal:
        return isinstance(value, str) if isinstance(get_args(option)[0], str) else value in get_args(option)
    if origin in (tuple, list):
        return isinstance(value, list | tuple)
    if origin in MAPPINGS or option in MAPPINGS or dataclasses.is_dataclass(option):
        return isinstance(value, Mapping)
    if option is bool:
        return isinstance(value, bool)
    if option is Path:
        return isinstance(value, str | Path)
    if option in (int, float):
        return isinstance(value, int | float) and not isinstance(value, bool)
    return option is Any or isinstance(value, option)
