"""Allowed values of a key of a scene, in words: for messages, and for pages about parts."""

from __future__ import annotations

import dataclasses
import types
import typing
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

from contactlab.scene.fields import PartSpec, keys_of

MAPPINGS = (dict, Mapping, typing.get_origin(Mapping[str, int]))


def in_words(hint: Any, limits: Mapping[str, Any]) -> str:
    """Return the allowed values of a key of this type and with these limits, in words, with the unit."""
    unit = f" [{limits['unit']}]" if limits.get("unit") else ""
    return accepts(hint, limits) + unit


def accepts(hint: Any, limits: Mapping[str, Any]) -> str:
    """Return the allowed values of a key of this type and with these limits, in words, without the unit."""
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
    if origin in MAPPINGS or hint in MAPPINGS:
        return f"tables by name, each {accepts(inner[1], limits)}" if inner else "a table"
    words = {int: "a whole number", float: "a number", str: "a string", bool: "true or false", Path: "a path"}
    return words.get(hint, getattr(hint, "__name__", str(hint))) + (_bounds(limits) if hint in (int, float) else "")


def _bounds(limits: Mapping[str, Any]) -> str:
    signs = {"above": ">", "least": ">=", "most": "<="}
    given = [f"{sign} {limits[name]:g}" for name, sign in signs.items() if limits.get(name) is not None]
    return f" {' and '.join(given)}" if given else ""
