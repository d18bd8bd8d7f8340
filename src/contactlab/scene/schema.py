"""A JSON schema of scenes, made from the declarations that the program itself reads by: for editors of TOML."""

from __future__ import annotations

import dataclasses
import types
import typing
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

from contactlab.parts.description import described_fields
from contactlab.parts.registry import Registry
from contactlab.scene.auto import AUTO, Auto
from contactlab.scene.fields import NAME, PartSpec, as_data, hints_of, is_required, keys_of
from contactlab.scene.scene import Scene

Schema = dict[str, Any]
KINDS = (
    "element", "material", "mesh", "contact", "friction", "enforcement", "integrator", "function", "effect", "recorder",
)  # fmt: skip
"""Kinds of parts that a scene can name."""

_SCALARS: dict[Any, Schema] = {
    int: {"type": "integer"},
    float: {"type": "number"},
    str: {"type": "string"},
    bool: {"type": "boolean"},
    Path: {"type": "string"},
    Any: {},
}
_BOUNDS = {"above": "exclusiveMinimum", "least": "minimum", "most": "maximum"}


def scene_schema(registry: Registry) -> Schema:
    """The schema (draft 7, which editors of TOML know) of every scene that the parts of `registry` make possible."""
    definitions: dict[str, Schema] = {}
    for kind in KINDS:
        definitions[kind] = _kind(kind, registry, definitions)
    top = _table(Scene, definitions)
    return {"$schema": "http://json-schema.org/draft-07/schema#", "title": "contactlab scene", **top,
            "definitions": definitions}  # fmt: skip


def _kind(kind: str, registry: Registry, definitions: dict[str, Schema]) -> Schema:
    """A part of this kind: its bare name if no field is required, or a table with `use`."""
    names = registry.names(kind)
    tables = []
    for name in names:
        definitions[f"{kind}-{name}"] = _part(kind, name, registry, definitions)
        tables.append(_reference(f"{kind}-{name}"))
    named: Schema = {"anyOf": [{"enum": names}, *tables]}
    if kind != "integrator":
        return named
    return {"anyOf": [{"enum": [*names, AUTO]}, *tables, _auto(named)]}


def _auto(named: Schema) -> Schema:
    """A table of integrators in an order; none of these is such a table."""
    table = _table(Auto, {})
    order = {**table["properties"]["order"], "items": named}
    return {**table, "properties": {"use": {"const": AUTO}, "order": order}, "required": ["use"]}


def _part(kind: str, name: str, registry: Registry, definitions: dict[str, Schema]) -> Schema:
    cls, part = registry.part_class(kind, name), registry.offer(kind, name).part
    meanings = {f.name: f"{f.meaning} [{f.unit}]" if f.unit else f.meaning for f in described_fields(cls)}
    table = _table(cls, definitions, meanings)
    table["properties"] = {"use": {"const": name, "description": part.summary}, **table["properties"]}
    return {**table, "required": ["use", *table.get("required", [])], "description": part.summary}


def _table(cls: type[Any], definitions: dict[str, Schema], meanings: Mapping[str, str] | None = None) -> Schema:
    """The keys of a dataclass. `meanings` of those whose declaration has none."""
    hints, keys = hints_of(cls), keys_of(cls)
    properties = {}
    for name, field in keys.items():
        says = field.metadata.get("says") or (meanings or {}).get(name, "")
        properties[name] = {**_value(hints[name], field.metadata, definitions), **_about(field, says)}
    required = [name for name, field in keys.items() if is_required(field)]
    return {
        "type": "object",
        "properties": properties,
        "additionalProperties": False,
        **({"required": required} if required else {}),
    }


def _about(field: dataclasses.Field[Any], says: str) -> Schema:
    unit = field.metadata.get("unit", "")
    found: Schema = {"description": f"{says} [{unit}]" if unit else says} if says else {}
    default = field.default
    if isinstance(default, bool | int | float | str) and default == default and abs(_size(default)) != float("inf"):
        found["default"] = default
    elif isinstance(default, tuple) and default:
        found["default"] = list(default)
    elif dataclasses.is_dataclass(default) and not isinstance(default, type):
        found["default"] = as_data(default)
    return found


def _size(value: bool | float | str) -> float:
    return 0.0 if isinstance(value, str) else float(value)


def _value(hint: Any, limits: Mapping[str, Any], definitions: dict[str, Schema]) -> Schema:
    if "part" in limits and hint in (PartSpec, PartSpec | None):
        named = _reference(limits["part"])
        return {"anyOf": [named, {"const": "none"}]} if hint == PartSpec | None else {"allOf": [named]}
    origin, inner = get_origin(hint), get_args(hint)
    if origin in (typing.Union, types.UnionType):
        options = [_value(option, limits, definitions) for option in inner if option is not type(None)]
        return options[0] if len(options) == 1 else {"anyOf": options}
    if origin is Literal:
        return {"enum": list(inner)}
    if origin in (tuple, list):
        if origin is list or inner[-1] is Ellipsis:
            return {"type": "array", "items": _value(inner[0], limits, definitions)}
        items = [_value(item, limits, definitions) for item in inner]
        return {"type": "array", "items": items, "minItems": len(items), "maxItems": len(items)}
    if origin is not None or hint in (dict, Mapping):
        # under names that the author of a scene chooses
        entry = _value(inner[1], limits, definitions) if inner else {}
        return {"type": "object", "patternProperties": {f"^{NAME.pattern}$": entry}, "additionalProperties": False}
    if dataclasses.is_dataclass(hint) and isinstance(hint, type):
        if hint.__name__ not in definitions:
            definitions[hint.__name__] = _table(hint, definitions)
        return {"allOf": [_reference(hint.__name__)]}
    bounds = {_BOUNDS[name]: limits[name] for name in _BOUNDS if limits.get(name) is not None}
    return {**_SCALARS[hint], **(bounds if hint in (int, float) else {})}


def _reference(name: str) -> Schema:
    return {"$ref": f"#/definitions/{name}"}
