"""Fields of a part that its code never names: a scene may set them, and nothing changes."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Iterator
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

from contactlab.api.formulas import Formula

ALL = {"asdict", "astuple", "fields", "vars", "__dict__", "attrgetter", "getattr"}
"""Names by which code may read fields without naming them."""
CONSTRUCTION = {"__init__", "__repr__", "__eq__", "__hash__", "__replace__", "__setattr__", "__delattr__"}
"""Methods that a dataclass makes, which look at fields without using them."""


def unused_fields(cls: type) -> list[str]:
    """Names of fields that no code of the part's package names outside the construction of the part.

    Empty if the code may read fields without naming them, or if its source is out of reach.
    """
    core = [base for base in cls.__mro__ if base.__module__.partition(".")[0] == "contactlab"]
    known = {name for base in core for name in (*vars(base), *vars(base).get("__annotations__", {}))}
    names = [field.name for field in dataclasses.fields(cls) if field.name not in known]
    if cls in core or not names:
        return []
    seen: set[str] = set()
    for code in _codes(cls):
        seen.update(code.co_names, *(_texts(constant) for constant in code.co_consts))
    return [] if seen & ALL else [name for name in names if name not in seen]


def _texts(constant: Any) -> tuple[str, ...]:
    """Strings of a constant: names that are handed on."""
    if isinstance(constant, str):
        return tuple(constant.replace(".", " ").split()) if len(constant) < 100 else ()
    return tuple(text for item in constant for text in _texts(item)) if isinstance(constant, tuple) else ()


def _codes(cls: type) -> Iterator[CodeType]:
    """Code of all functions of the packages that the class and its bases are from, without the core's."""
    packages = {base.__module__.partition(".")[0] for base in cls.__mro__} - {"contactlab", "abc", "builtins", "typing"}
    loaded: set[str] = set()
    for name, module in list(sys.modules.items()):
        if name.partition(".")[0] in packages and module is not None:
            loaded.add(str(getattr(module, "__file__", "")))
            for item in list(vars(module).values()):
                yield from _of(item, name)
    for package in packages & sys.modules.keys():
        for folder in getattr(sys.modules[package], "__path__", ()):
            for file in Path(folder).rglob("*.py"):
                if str(file) not in loaded:
                    yield from _nested(compile(file.read_bytes(), str(file), "exec"))


def _of(item: Any, module: str) -> Iterator[CodeType]:
    item = item.function if isinstance(item, Formula) else item
    item = getattr(item, "py_func", item)
    item = getattr(item, "__wrapped__", item)
    if isinstance(item, FunctionType) and item.__module__ == module:
        yield from _nested(item.__code__)
    elif isinstance(item, staticmethod | classmethod):
        yield from _of(item.__func__, module)
    elif isinstance(item, property):
        yield from _of(item.fget, module)
    elif isinstance(item, type) and item.__module__ == module:
        formulas = vars(item).get("__formulas__", {})
        for name, value in (*vars(item).items(), *formulas.items()):
            # limits of a field are not a use of it; values kept in other attributes are
            checks_only = name == "__post_init__" and "__setattr__" not in value.__code__.co_names
            if name not in CONSTRUCTION and not checks_only:
                yield from _of(value, module)


def _nested(code: CodeType) -> Iterator[CodeType]:
    """A function and the functions in it; without its docstring."""
    first = code.co_consts[:1]
    rest = code.co_consts[1:] if first and isinstance(first[0], str) else code.co_consts
    yield code.replace(co_consts=rest)
    for constant in rest:
        if isinstance(constant, CodeType):
            yield from _nested(constant)
