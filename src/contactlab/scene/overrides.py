"""Changes to a scene's data by dotted keys: what `--set`, `--vary` and `Scene.with_` do."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from typing import Any

from contactlab.errors import SceneError, did_you_mean, show

NAMED_LISTS = ("contacts", "supports", "loads")
"""Lists of tables whose entries can also be addressed by their `name`."""

DIGITS = 10
"""Digits of the number of an entry; Python refuses to read thousands of them."""

Switch = Callable[[str, Mapping[str, Any], str], dict[str, Any]]
"""(key path, old part, new name) -> the new part, with what it keeps of the old one."""


def changed(
    data: Mapping[str, Any], changes: Mapping[str, Any], is_part: Callable[[str], bool], switch: Switch
) -> tuple[dict[str, Any], list[str]]:
    """A copy of `data` with the changes, and their keys in the numbered form.

    A change of which part is used comes before changes of its fields, in whatever order they are
    given. None removes a key, and so does "none" for a part. Raises SceneError if a key does not exist.
    """
    result = copy.deepcopy(dict(data))
    numbered = [(_numbered(key, result), value) for key, value in changes.items()]
    for path, value in sorted(numbered, key=lambda change: len(change[0]) - (change[0][-1] == "use")):
        _set(result, path, _copied(value, path), is_part, switch)
    return result, [".".join(path) for path, _ in numbered]


def _copied(value: Any, path: list[str]) -> Any:
    try:
        return copy.deepcopy(value)
    except RecursionError as error:
        raise SceneError(
            "the value is nested too deeply", where=".".join(path), got=value, allowed="a value that TOML can hold"
        ) from error


def _numbered(key: str, data: Mapping[str, Any]) -> list[str]:
    path = key.split(".") if isinstance(key, str) else [""]
    if not all(path):
        raise SceneError("not a key", where="override", got=key, allowed="names joined by dots: contacts.0.swap")
    if len(path) > 1 and path[0] in NAMED_LISTS and not path[1].isdecimal() and isinstance(data.get(path[0], []), list):
        path[1] = str(_entry_named(path[0], path[1], data))
    return path


def _entry_named(table: str, name: str, data: Mapping[str, Any]) -> int:
    entries = data.get(table, [])
    names = [entry.get("name") if isinstance(entry, dict) else None for entry in entries]
    if name in names:
        return names.index(name)
    known = [known for known in names if known]
    numbers = [str(number) for number in range(len(entries))]
    raise SceneError(
        f"the scene has no entry of this name in {table}",
        where=f"{table}.{name}",
        got=name,
        allowed=", ".join([*numbers, *known]),
        hint=did_you_mean(name, known),
    )


def _set(data: dict[str, Any], path: list[str], value: object, is_part: Callable[[str], bool], switch: Switch) -> None:
    if path[-1] == "use" and is_part(".".join(path[:-1])):
        path = path[:-1]
    holder: Any = data
    for depth, name in enumerate(path[:-1]):
        holder = _step(holder, name, path[: depth + 1])
    key = ".".join(path)
    old = holder.get(path[-1]) if isinstance(holder, dict) else None
    if isinstance(value, str) and value == "none" and is_part(key):
        value = None
    elif isinstance(value, str) and is_part(key):
        value = switch(key, old, value) if isinstance(old, dict) else {"use": value}
    _put(holder, path, value)


def _step(holder: Any, name: str, path: list[str]) -> Any:
    """The table or list called `name` inside `holder`, created if it does not exist."""
    if isinstance(holder, dict):
        if name not in holder and path[:-1] in _BY_NAME:
            raise _no_such_entry(path, holder)
        inner = holder.setdefault(name, [] if name in NAMED_LISTS and len(path) == 1 else {})
    else:
        index = _index(holder, name, path)
        if index == len(holder):
            holder.append({})
        inner = holder[index]
    if isinstance(inner, dict | list):
        return inner
    key = ".".join(path)
    raise SceneError(
        "this key holds a value and has no keys inside",
        where=key,
        got=inner,
        allowed="a table or a list, for keys inside it",
        hint=f"set {key} as a whole: {{ ... }}",
    )


_BY_NAME = (["bodies"], ["materials"], ["rigid"], ["fields"])


def _no_such_entry(path: list[str], entries: Mapping[str, Any]) -> SceneError:
    key = ".".join(path)
    return SceneError(
        f"the scene declares no {path[-1]} under [{path[0]}]",
        where=key,
        got=path[-1],
        allowed=", ".join(entries) or "none: nothing is declared there",
        hint=did_you_mean(path[-1], entries) or f"set a new one as a whole: {key}={{ ... }}",
    )


def _put(holder: Any, path: list[str], value: object) -> None:
    name = path[-1]
    if isinstance(holder, list):
        index = _index(holder, name, path)
        holder[index : index + 1] = [] if value is None else [value]
    elif value is None:
        holder.pop(name, None)
    else:
        holder[name] = value


def _index(entries: list[Any], name: str, path: list[str]) -> int:
    """Position in a list; one past its end adds an entry."""
    if name.isdecimal() and len(name) < DIGITS and int(name) <= len(entries):
        return int(name)
    raise SceneError(
        "the list has no such entry",
        where=".".join(path),
        got=name,
        allowed=f"0 to {len(entries) - 1}, or {len(entries)} for a new entry" if entries else "0 for a new entry",
        hint=f"the list is {show(entries)}",
    )
