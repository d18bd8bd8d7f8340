"""Plan of the cells of a matrix."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from contactlab.api import Case, Setup
from contactlab.cases.methods import method_name, method_of, methods
from contactlab.errors import RequestError, did_you_mean
from contactlab.parts.registry import Registry

PACKAGES = {"case": "contactlab-cases", "contact": "contactlab-mortar"}
"""Packages that bring parts of a kind."""


@dataclass(frozen=True)
class Cell:
    """Case with a setup. `variant` are the fields of the case that differ from its defaults."""

    name: str
    variant: Mapping[str, Any]
    setup: Setup

    def case(self, registry: Registry) -> Case:
        """The case with the fields of the variant. Raises PartError."""
        found: Case = registry.make("case", {"use": self.name, **self.variant})
        return found

    @property
    def choices(self) -> dict[str, str]:
        """Identify the cell by the columns of the table."""
        setup = self.setup
        variant = ", ".join(f"{name}={value:g}" if isinstance(value, float) else f"{name}={value}"
                            for name, value in self.variant.items())  # fmt: skip
        return {
            "case": self.name,
            "variant": variant + (f"{', ' if variant else ''}level={setup.level}" if setup.level > 1 else ""),
            "contact": method_name(setup.algorithm, setup.enforcement),
            "slave": "exchanged" if setup.swap else "declared",
            "element": str(setup.element),
            "integrator": str(setup.integrator),
        }

    @property
    def label(self) -> str:
        """All choices of the cell in one line."""
        return ", ".join(text for text in self.choices.values() if text)


@dataclass(frozen=True)
class Request:
    """Request of a matrix: names of cases and contact methods (all without any), and how much."""

    cases: Sequence[str] = ()
    contacts: Sequence[str] = ()
    full: bool = False
    levels: Sequence[int] = field(default=(1,))


def plan(request: Request, registry: Registry) -> list[Cell]:
    """The cells in the order of the table. Raises RequestError for a name that is not installed."""
    for kind, package in PACKAGES.items():
        if not registry.names(kind):
            raise RequestError(f"no {kind} is installed", where="contactlab matrix", hint=f"pip install {package}")
    cases = registry.names("case")
    for name in request.cases:
        if name not in cases:
            raise RequestError(
                "no case of this name is installed", where="contactlab matrix, case", got=name,
                allowed=", ".join(cases), hint=registry.missing_from(name) or did_you_mean(name, cases),
            )  # fmt: skip
    asked = dict.fromkeys(request.contacts) or methods(registry, variants=request.full)
    contacts = [method_of(name, registry, "contactlab matrix") for name in asked]
    return [
        cell for name in dict.fromkeys(request.cases) or cases for cell in _cells(name, contacts, request, registry)
    ]


def _cells(name: str, contacts: Sequence[tuple[Any, Any]], request: Request, registry: Registry) -> Iterator[Cell]:
    case: Case = registry.make("case", name)
    first = slice(None) if request.full else slice(1)
    sides = (False, True) if request.full else (False,)
    for variant in _variants(case, request.full):
        for level, integrator, element in itertools.product(
            request.levels, case.integrators[first], case.elements[first]
        ):
            for (algorithm, enforcement), swap in itertools.product(contacts, sides):
                yield Cell(name, variant, Setup(algorithm, swap, element, integrator, level, enforcement))


def _variants(case: Case, full: bool) -> Iterator[dict[str, Any]]:
    """The defaults first; in the full matrix every combination of the axes."""
    yield {}
    if not full:
        return
    for values in itertools.product(*case.axes.values()):
        changed = {n: v for n, v in zip(case.axes, values, strict=True) if v != getattr(case, n)}
        if changed:
            yield changed
