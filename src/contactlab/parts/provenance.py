"""Provenance of a run: its parts, versions and machine."""

from __future__ import annotations

import platform
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from contactlab.parts.machine import blas_kernels, processor
from contactlab.parts.registry import Registry
from contactlab.scene.auto import integrators_in
from contactlab.scene.scene import Scene

LIBRARIES = ("contactlab", "numpy", "scipy", "numba")


def part_specs(scene: Scene) -> Iterator[tuple[str, str, str]]:
    """Key, kind and name of every part that the scene uses."""
    for key, name in integrators_in(scene.integrator):
        yield key, "integrator", name
    for name, spec in scene.materials.items():
        yield f"materials.{name}", "material", spec["use"]
    for name, body in scene.bodies.items():
        yield f"bodies.{name}.element", "element", body.element["use"]
        yield f"bodies.{name}.mesh", "mesh", body.mesh["use"]
    for number, contact in enumerate(scene.contacts):
        for key, kind in (("algorithm", "contact"), ("friction", "friction"), ("enforcement", "enforcement")):
            spec = getattr(contact, key)
            if spec is not None:
                yield f"contacts.{number}.{key}", kind, spec["use"]
    for number, spec in enumerate(scene.effects):
        yield f"effects.{number}", "effect", spec["use"]
    for place, function in _functions(scene):
        yield place, "function", function["use"]
    for number, spec in enumerate(scene.record.recorders or ()):
        yield f"record.recorders.{number}", "recorder", spec["use"]


def _functions(scene: Scene) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Place in the scene and table of every function: of profiles, and of values in time."""
    data = scene.data
    for table in ("bodies", "rigid", "supports", "loads", "effects"):
        yield from _functions_in(data.get(table, ()), table)


def _functions_in(value: Any, place: str) -> Iterator[tuple[str, Mapping[str, Any]]]:
    for name, item in value.items() if isinstance(value, Mapping) else enumerate(value):
        at = f"{place}.{name}"
        if name == "function":
            yield at, item
        elif isinstance(item, Mapping | list):
            yield from _functions_in(item, at)


def parts_of(scene: Scene, registry: Registry) -> dict[str, str]:
    """Return the part and its distribution by key of the scene."""
    return {key: f"{name} ({registry.offer(kind, name).origin})" for key, kind, name in part_specs(scene)}


def versions(scene: Scene, registry: Registry) -> dict[str, str]:
    """Versions of Python, of the libraries below, and of every distribution that gave a part; processor and BLAS."""
    found = {"python": platform.python_version(), "processor": processor(), "BLAS": blas_kernels()}
    origins = {registry.offer(kind, name).origin.distribution for _, kind, name in part_specs(scene)}
    return found | {name: _version(name) for name in (*LIBRARIES, *sorted(origins))}


@cache
def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
