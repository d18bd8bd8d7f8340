"""Parts to check by default: fields without a default get a usual value by their name, or one by their type."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from contactlab.parts.registry import Registry
from contactlab.scene.fields import hints_of, is_required, keys_of
from contactlab.testing.assertions import NotApplicable

USUAL: dict[str, Any] = {
    "young": 7000.0,
    "poisson": 0.3,
    "density": 2.7e-9,
    "mu": 0.2,
    "stress": 200.0,
    "x": (-1.0, 2.0),
    "y": (0.5, 1.5),
    "cells": (3, 2),
    "radius": 1.0,
    "half_width": 0.8,
    "top": 0.6,
    "radii": (1.0, 2.0),
    "corners": ((0.0, 0.0), (2.0, 0.0), (2.2, 1.0), (-0.2, 1.1)),
    "strength": 348.0,
    "prestrain": 0.02,
    "exponent": 0.03,
    "yield_stress": 350.0,
    "hardening": 500.0,
    "acceleration": (0.0, -9810.0),
    "between": ("upper", "lower"),
    "force": 10.0,
    "on": "upper",
    "stiffness": (100.0, 200.0),
    "rate": 1000.0,
    "speed": 1000.0,
    "quantities": ("time", "energy", "force.upper.x"),
    "body": "upper",
    "period": 1.5,
    "coefficients": (1.0, 0.5, -0.2),
    "clearance": 0.01,
    "gaps": (-0.02, 0.0, 0.01),
    "pressures": (900.0, 100.0, 0.0),
    "width": 1.2,
    "left": 0.6,
    "right": 0.9,
    "content": "eNqrVirIz8wrKVayio420DPQAeJYnWhDOMsIzgLJGsJlDeGyIFasjlJyak4OxBQdQx0THWOQOh0jHVMd"
    "E5BscSrIimqlkvwCoBpjoAJToGhOaloJRItxbGxtLQDG/SSQ",
}
"""Values for fields without a default, in mm N s t."""

BY_TYPE: dict[Any, Any] = {
    float: 1.0, int: 2, bool: True,
    tuple[float, float]: (1.0, 0.5), tuple[float, ...]: (1.0, 0.5), tuple[int, int]: (2, 2),
}  # fmt: skip
"""Values for fields with other names."""


def example(registry: Registry, kind: str, name: str) -> Any:
    """The part of this kind and name with usual values. Raises NotApplicable naming a field without one."""
    return registry.make(kind, example_spec(registry, kind, name))


def example_spec(registry: Registry, kind: str, name: str, given: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Write an example of a part as a scene names it; fields that are `given` need no usual value."""
    given = given or {}
    needed = _needed(registry.part_class(kind, name), given)
    unknown = [field for field in needed if field not in USUAL]
    if unknown:
        raise NotApplicable(f"no usual value is known for {', '.join(unknown)}{_give(unknown)}")
    return {"use": name, **{field: USUAL[field] for field in needed}, **given}


def guesses(cls: type, given: Mapping[str, Any]) -> dict[str, Any]:
    """Values by their types for numbers of a part that have no default, are not `given`, and have no usual value."""
    kinds = {field: hints_of(cls)[field] for field in _needed(cls, given) if field not in USUAL}
    found = {field: BY_TYPE[kind] for field, kind in kinds.items() if kind in BY_TYPE}
    # each a little smaller than the last: of equal ones the difference is nothing
    for place, field in enumerate(name for name in found if isinstance(found[name], float)):
        found[field] *= 0.9**place
    return found


def refused(names: Iterable[str], because: str) -> NotApplicable:
    """Return the reason if a part accepts no guess."""
    return NotApplicable(
        f"no usual value is known for {', '.join(names)}, and the part refuses guesses: {because}{_give(names)}"
    )


def _needed(cls: type, given: Mapping[str, Any]) -> list[str]:
    fields = keys_of(cls)
    return [field for field in fields if is_required(fields[field]) and field not in given]


def _give(names: Iterable[str]) -> str:
    return "; give " + " ".join(f"--set {name}=..." for name in names)
