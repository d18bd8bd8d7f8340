"""Which cells a matrix has."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from contactlab.api import Case, Setup
from contactlab.cases.run_case import is_potential
from contactlab.errors import RequestError, did_you_mean
from contactlab.parts.registry import Registry

PACKAGES = {"case": "contactlab-cases", "contact": "contactlab-mortar"}
"""What brings parts of a kind."""


@dataclass(frozen=True)
class Cell:
    """One question put to one setup. `variant` are the fields of the case that differ from its defaults."""

    name: str
    variant: Mapping[str, Any]
    setup: Setup

    def case(self, registry: Registry) -> Case:
        """The case with the fields of the variant. Raises PartError."""
        found: Case = registry.make("case", {"use": self.name, **self.variant})
        return found

    @property
    def choices(self) -> dict[str, str]:
        """What tells cells apart, as the columns of the table."""
        setup = self.setup
        variant = ", ".join(f"{name}={value:g}" if isinstance(value, float) else f"{name}={value}"
                            for name, value in self.variant.items())  # fmt: skip
        return {
            "case": self.name,
            "variant": variant + (f"{', ' if variant else ''}level={setup.level}" if setup.level > 1 else ""),
            "contact": str(setup.algorithm),
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
    """What a matrix is asked for: names of cases and contact algorithms (all without any), and how much."""

    cases: Sequence[str] = ()
    contacts: Sequence[str] = ()
    full: bool = False
    levels: Sequence[int] = field(default=(1,))


def plan(request: Request, registry: Registry) -> list[Cell]:
    """The cells in the order of the table. Raises RequestError for a name that is not installed.

    Potentials take many times the iterations of others: they are in the full form, or asked for by name.
    """
    names = _known("case", request.cases, registry)
    contacts = _known("contact", request.contacts, registry)
    if not request.contacts and not request.full:
        contacts = [name for name in contacts if not is_potential(name, registry)] or contacts
    return [cell for name in names for cell in _cells(name, contacts, request, registry)]


def _known(kind: str, wanted: Sequence[str], registry: Registry) -> list[str]:
    names = registry.names(kind)
    if not names:
        hint = f"pip install {PACKAGES[kind]}"
        raise RequestError(f"no {kind} is installed at all", where="contactlab matrix", hint=hint)
    for name in wanted:
        if name not in names:
            raise RequestError(
                f"no {kind} of this name is installed", where=f"contactlab matrix, {kind}", got=name,
                allowed=", ".join(names), hint=registry.missing_from(name) or did_you_mean(name, names),
            )  # fmt: skip
    return list(dict.fromkeys(wanted)) or names


def _cells(name: str, contacts: Sequence[str], request: Request, registry: Registry) -> Iterator[Cell]:
    case: Case = registry.make("case", name)
    first = slice(None) if request.full else slice(1)
    sides = (False, True) if request.full else (False,)
    for variant in _variants(case, request.full):
        for level, integrator, element in itertools.product(
            request.levels, case.integrators[first], case.elements[first]
        ):
            for contact, swap in itertools.product(contacts, sides):
                yield Cell(name, variant, Setup(contact, swap, element, integrator, level))


def _variants(case: Case, full: bool) -> Iterator[dict[str, Any]]:
    """The defaults first; in the full matrix every combination of the axes."""
    yield {}
    if not full:
        return
    for values in itertools.product(*case.axes.values()):
        changed = {n: v for n, v in zip(case.axes, values, strict=True) if v != getattr(case, n)}
        if changed:
            yield changed
