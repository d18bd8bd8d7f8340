"""Public names of the contract, one a line; run as a program it adds the new ones to the stored list."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Iterator
from pathlib import Path

import contactlab.api

STORED = Path(__file__).with_name("public_names.txt")
# kernels, colours, and what stands behind formulas: listed by module, not by member
SKIPPED = ("contactlab.api.compiled", "contactlab.api.drawing", "contactlab.api.formulas", "contactlab.api.mathematics")


def public_names() -> list[str]:
    """Modules of `contactlab.api`, their functions and classes with members, and what `contactlab.testing` offers."""
    found = {f"contactlab.api.{name}" for name in contactlab.api.__all__}
    for module in modules():
        found.add(module)
        if not module.startswith(SKIPPED):
            found |= set(_members(module))
    testing = importlib.import_module("contactlab.testing")
    found |= {f"contactlab.testing.{name}" for name in testing.__all__}
    found |= {f"contactlab.testing.{kind}.CHECKS" for kind in contactlab.api.KINDS}
    return sorted(found)


def modules() -> Iterator[str]:
    for info in pkgutil.walk_packages(contactlab.api.__path__, "contactlab.api."):
        if not info.name.rpartition(".")[2].startswith("_"):
            yield info.name


def _members(module: str) -> Iterator[str]:
    for name, value in vars(importlib.import_module(module)).items():
        if name.startswith("_") or getattr(value, "__module__", "") != module:
            continue
        yield f"{module}.{name}"
        if inspect.isclass(value):
            own = {*vars(value), *getattr(value, "__annotations__", {})}
            yield from (f"{module}.{name}.{member}" for member in own if not member.startswith("_"))


if __name__ == "__main__":
    stored = set(STORED.read_text().split()) if STORED.exists() else set()
    STORED.write_text("\n".join(sorted(stored | set(public_names()))) + "\n")
