"""Values that nobody thought of: what the schema of scenes allows, what it almost allows, and what no file can hold."""

from __future__ import annotations

import datetime
import math
import random
import string
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from contactlab.parts.registry import default_registry
from contactlab.scene.schema import scene_schema

SCHEMA = scene_schema(default_registry())
NAMES = ("disc", "block", "steel", "soft", "disc.arc", "block.top", "block.bottom", "disc.top", "floor", "x", "nodes")
NUMBERS = (
    0, -1, 1, 2, 3, 2**31, -(2**63), 2**64, 10**18, 10**400, 0.0, -0.0, 5e-324, 1e-300, 1e-9, 0.5, 1.0 - 1e-16, 1e9,
    1e155,
    1.7e308, -1.7e308, math.nan, math.inf, -math.inf, True, False,
)  # fmt: skip
TEXTS = (
    "", " ", "\t", "a\nb", "\x00", "\x1b[2J\x1b]0;title\x07", "\x7f", "\u202e", "\u2028", "\ud800", "é" * 140,
    "x" * 5000,
    "../../x", "/dev/zero", "/dev/stdin", "/proc/self/mem", ".", "~", "C:\\x", "none", "auto", "true", "1e5", "nan",
    "{}",
    "%s%n", "[bold]x[/bold]", "'\"", "a.b.c", "contacts.0", "0", "-1", "*", "file://x", "http://localhost:1/x",
)  # fmt: skip
OBJECTS = (
    None, b"", b"\xff", (), (1, 2), set(), object(), print, range(3), 1j, datetime.date(2026, 1, 1), Path("x"),
    Path("/dev/zero"),
    np.float64(1.0), np.array(1.0), np.array([1.0, 2.0]), np.array(["a"]), np.zeros((0, 2)), {1: 2}, {"": 1},
    {"a": {"b": []}},
)  # fmt: skip
"""What a program can hand over, and no file."""


def strange(chance: random.Random, outside: bool = False) -> Any:
    """Anything; `outside`: of what a program alone can hand over as well."""
    kinds = ["number", "number", "text", "text", "letters", "list", "table", "deep", "part"] + ["object"] * 3 * outside
    kind = chance.choice(kinds)
    if kind == "number":
        return chance.choice(NUMBERS) if chance.random() < 0.7 else wide_number(chance)
    if kind == "text":
        return chance.choice(TEXTS)
    if kind == "letters":
        return "".join(chance.choices(string.printable + "äß€\u200b", k=chance.randrange(1, 12)))
    if kind == "list":
        return [_single(chance) for _ in range(chance.choice((0, 1, 2, 3, 40)))]
    if kind == "table":
        return {chance.choice((*NAMES, "use", "to", "")): _single(chance) for _ in range(chance.randrange(3))}
    if kind == "part":
        return {"use": chance.choice((*TEXTS, *NAMES, "mortar-p1", "q2", "coulomb"))}
    if kind == "object":
        return chance.choice(OBJECTS)
    nested: Any = 0
    for _ in range(chance.choice((3, 60, 900))):
        nested = [nested]
    return nested


def _single(chance: random.Random) -> Any:
    return chance.choice(NUMBERS if chance.random() < 0.7 else TEXTS)


def wide_number(chance: random.Random) -> float:
    """A number of any size and sign."""
    return chance.choice((-1.0, 1.0)) * 10.0 ** chance.uniform(-320.0, 308.0)


def places(data: Any, place: str = "") -> Iterator[str]:
    """All dotted keys of a scene."""
    items = data.items() if isinstance(data, Mapping) else enumerate(data) if isinstance(data, list | tuple) else ()
    for name, value in items:
        inner = f"{place}.{name}" if place else str(name)
        yield inner
        yield from places(value, inner)


def entry(data: Mapping[str, Any], chance: random.Random) -> tuple[str, Any]:
    """A key that the schema has, whether this scene has it or not, and a value, right as often as wrong."""
    schema, place = SCHEMA, ""
    while True:
        inner = chance.choice(_inner(schema, _at(data, place)) or [("", None)])
        if inner[1] is None:
            break
        place, schema = f"{place}.{inner[0]}" if place else inner[0], inner[1]
        if chance.random() < 0.3:
            break
    if chance.random() < 0.4:
        return place, strange(chance)
    return place, value(schema, chance)


def _at(data: Any, place: str) -> Any:
    for name in place.split(".") if place else ():
        if isinstance(data, Mapping):
            data = data.get(name)
        elif isinstance(data, list | tuple) and name.isdigit() and int(name) < len(data):
            data = data[int(name)]
        else:
            return None
    return data


def _inner(schema: Mapping[str, Any], present: Any) -> list[tuple[str, Any]]:
    """Keys inside, by the schema, and of a part by the one that is there."""
    schema = _resolved(schema)
    found: list[tuple[str, Any]] = []
    for option in schema.get("anyOf", (schema,)):
        shape = _resolved(option)
        used = shape.get("properties", {}).get("use", {}).get("const")
        if used is not None and isinstance(present, Mapping) and used != present.get("use"):
            continue
        found += [(name, inner) for name, inner in shape.get("properties", {}).items() if name != "use"]
        for inner in shape.get("patternProperties", {}).values():
            found += [(str(name), inner) for name in (present if isinstance(present, Mapping) else ("x",))]
        if shape.get("type") == "array" and isinstance(present, list | tuple):
            items = shape["items"] if isinstance(shape["items"], list) else [shape["items"]] * len(present)
            found += [(str(number), inner) for number, inner in enumerate(items)]
    return found


def _resolved(schema: Mapping[str, Any]) -> Mapping[str, Any]:
    while True:
        if "$ref" in schema:
            schema = SCHEMA["definitions"][schema["$ref"].rpartition("/")[2]]
        elif "allOf" in schema:
            schema = schema["allOf"][0]
        else:
            return schema


def value(schema: Mapping[str, Any], chance: random.Random, depth: int = 0) -> Any:
    """A value that the schema allows, as far as a schema can tell."""
    if chance.random() < 0.04:
        return strange(chance)
    schema = _resolved(schema)
    if "anyOf" in schema:
        return value(chance.choice(schema["anyOf"]), chance, depth)
    if "enum" in schema:
        return chance.choice(schema["enum"])
    if "const" in schema:
        return schema["const"]
    kind = schema.get("type")
    if kind == "object":
        return _table(schema, chance, depth)
    if kind == "array":
        items = schema["items"]
        if isinstance(items, list):
            return [value(item, chance, depth + 1) for item in items]
        return [value(items, chance, depth + 1) for _ in range(chance.choice((0, 1, 1, 2, 3)) if depth < 4 else 0)]
    if kind in ("number", "integer"):
        return _number(schema, chance)
    if kind == "boolean":
        return chance.random() < 0.5
    return chance.choice(NAMES) if chance.random() < 0.8 else chance.choice(TEXTS)


def _table(schema: Mapping[str, Any], chance: random.Random, depth: int) -> dict[str, Any]:
    inside, needed = schema.get("properties", {}), schema.get("required", ())
    chosen = [n for n in inside if n in needed or (depth < 4 and chance.random() < 1.5 / (1 + len(inside)))]
    made = {name: value(inside[name], chance, depth + 1) for name in chosen}
    for inner in schema.get("patternProperties", {}).values():
        made |= {name: value(inner, chance, depth + 1) for name in chance.sample(NAMES[:4], chance.choice((0, 1, 2)))}
    return made


def _number(schema: Mapping[str, Any], chance: random.Random) -> float:
    low = schema.get("minimum", schema.get("exclusiveMinimum"))
    high = schema.get("maximum")
    if chance.random() < 0.15:
        ends = [end for end in (low, high) if end is not None] or [0]
        return chance.choice(ends) + chance.choice((0, 0, 1, -1))
    if schema.get("type") == "integer":
        return (low or 0) + chance.choice((0, 1, 2, 3, 5, 17, 400))
    if low is not None and high is not None:
        return chance.uniform(low, high)
    size = 10.0 ** chance.uniform(-9.0, 6.0)
    return (low or 0.0) + size if low is not None else chance.choice((-size, size))
