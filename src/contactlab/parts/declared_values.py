"""Check of the values of a part's class attributes against the contract."""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches
from typing import Any, ClassVar, Literal, get_args, get_origin, get_type_hints
from weakref import WeakKeyDictionary

import numpy as np

from contactlab.errors import did_you_mean, show

LEAST = {"degree": 1, "order": 1, "rows_per_node": 1}
"""Smallest value of the class attributes that count something; 0 for all others."""

SPELT = 0.85
"""Similarity above which a freely chosen name counts as a misspelt known name."""

_DECLARED: WeakKeyDictionary[type, dict[str, Any]] = WeakKeyDictionary()


def wrong_values(target: type) -> list[str]:
    """A line for each class attribute of `target` whose value the contract does not allow."""
    found = []
    for name, hint in declared(target).items():
        value = getattr(target, name, None)
        if not hasattr(target, name) or isinstance(value, property):
            continue
        allowed = _wanted(name, hint, value)
        if allowed:
            shown = show(value) if isinstance(value, str) else repr(value)[:80]
            found.append(f"its class attribute {name} is {shown}; allowed: {allowed}")
    return found + ([] if found else _unnamed_history(target))


def declared(target: type) -> Mapping[str, Any]:
    """Type of each class attribute that a class of the contract promises, by name; worked out once for a class."""
    if target in _DECLARED:
        return _DECLARED[target]
    hints: dict[str, Any] = {}
    for base in reversed(target.__mro__):
        if base.__module__.startswith("contactlab.api."):
            own = get_type_hints(base)
            hints |= {name: get_args(hint)[0] for name, hint in own.items() if get_origin(hint) is ClassVar}
    return _DECLARED.setdefault(target, hints)


def _wanted(name: str, hint: Any, value: Any) -> str:
    """Return what is allowed instead of `value`, empty if it is valid."""
    origin = get_origin(hint)
    if origin is Literal:
        choices = get_args(hint)
        if isinstance(value, str) and value in choices:
            return ""
        nearest = did_you_mean(value, choices) if isinstance(value, str) else ""
        return ", ".join(show(choice) for choice in choices) + (f"; {nearest}" if nearest else "")
    if hint is bool:
        return "" if isinstance(value, bool) else "True or False"
    if hint is int:
        least = LEAST.get(name, 0)
        return "" if _whole(value) and value >= least else f"a whole number of at least {least}"
    if hint is str:
        return "" if isinstance(value, str) else "a string"
    if origin is type:
        (base,) = get_args(hint)
        fits = isinstance(value, type) and issubclass(value, base)
        return "" if fits else f"{base.__name__} or a class derived from it"
    if origin is tuple:
        return _wanted_in_tuple(get_args(hint)[0], value)
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return _wanted_in_table(get_args(hint)[1], value)
    if origin is np.ndarray:
        fits = isinstance(value, np.ndarray) and value.dtype == np.float64 and bool(np.isfinite(value).all())
        return "" if fits else "a NumPy array of finite float64"
    return ""


def _wanted_in_table(entry: Any, value: Any) -> str:
    named = isinstance(value, Mapping) and all(isinstance(key, str) for key in value)
    if entry is str:
        return "" if named and all(isinstance(text, str) for text in value.values()) else "a table of strings by string"
    fits = named and all(isinstance(values, tuple) for values in value.values())
    return "" if fits else "a table of tuples by string"


def _wanted_in_tuple(entry: Any, value: Any) -> str:
    known = next((get_args(one) for one in (entry, *get_args(entry)) if get_origin(one) is Literal), ())
    if known:
        # freely chosen names may be mixed with known names: names that are nearly known are misspelt
        choices = ", ".join(map(show, known)) + (" and names of fields" if str in get_args(entry) else "")
        if not isinstance(value, tuple) or not all(isinstance(one, str) for one in value):
            return f"a tuple of strings among {choices}"
        others = [one for one in value if one not in known]
        if str in get_args(entry):
            others = [one for one in others if get_close_matches(one, known, 1, SPELT)]
        nearest = [did_you_mean(one, known) for one in others]
        return "; ".join([f"strings among {choices}", *filter(None, nearest[:1])]) if others else ""
    if entry is str:
        fits = isinstance(value, tuple) and all(isinstance(text, str) for text in value)
        return "" if fits else "a tuple of strings"
    if entry is float:
        fits = isinstance(value, tuple) and all(isinstance(x, float | int | np.number) for x in value)
        return "" if fits else "a tuple of numbers"
    if get_origin(entry) is not tuple:
        return "" if isinstance(value, tuple) and value else "a tuple that is not empty"
    fits = isinstance(value, tuple) and all(isinstance(row, tuple) and all(map(_whole, row)) for row in value)
    return "" if fits else "a tuple of tuples of whole numbers"


def _whole(value: Any) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool)


def _unnamed_history(target: type) -> list[str]:
    names, size = getattr(target, "history_names", ()), getattr(target, "history_size", 0)
    if isinstance(names, property) or isinstance(size, property) or len(names) == size:
        return []
    return [f"its history_names has {len(names)} names, its history_size is {size}; allowed: a name per number"]
