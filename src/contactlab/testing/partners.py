"""Partners of the part under check: shipped parts alone, whatever else is installed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from contactlab.api import ExplicitIntegrator, NormalLaw, Potential
from contactlab.parts.loading import CORE
from contactlab.parts.registry import Registry, known_packages
from contactlab.scene.fields import is_required, keys_of
from contactlab.testing.assertions import NotApplicable


def partners(registry: Registry, kind: str) -> list[str]:
    """Names of the installed parts of one kind that packages of this repository bring, in alphabetical order."""
    ours = {CORE, *known_packages()}
    return [n for n in registry.names(kind) if registry.offer(kind, n).origin.distribution in ours]


def usual_algorithm(registry: Registry) -> str:
    """A shipped contact algorithm that passes the patch test and sets conditions, so that all integrators take it."""
    what = "contact algorithm that passes the patch test"
    return _first(registry, "contact", lambda cls: cls.passes_patch_test and not issubclass(cls, Potential), what)


def usual_law(registry: Registry) -> str:
    """A shipped pressure law that needs no values and nothing but gaps."""

    def fits(cls: type[Any]) -> bool:
        return issubclass(cls, NormalLaw) and not cls.named() and not any(map(is_required, keys_of(cls).values()))

    return _first(registry, "enforcement", fits, "pressure law without values of its own")


def usual_flow(registry: Registry) -> str:
    """A shipped material that yields: one that needs a yield stress."""

    def fits(cls: type[Any]) -> bool:
        keys = keys_of(cls)
        return "yield_stress" in keys and is_required(keys["yield_stress"])

    return _first(registry, "material", fits, "material that yields")


def usual_motion(registry: Registry) -> str:
    """A shipped integrator with inertia whose steps iterate."""
    what = "implicit integrator with inertia"
    return _first(registry, "integrator", lambda cls: cls.inertia and not issubclass(cls, ExplicitIntegrator), what)


def _first(registry: Registry, kind: str, fits: Callable[[type[Any]], bool], what: str) -> str:
    """The first of the partners that fits. Raises NotApplicable, saying `what` is not there."""
    found = next((name for name in partners(registry, kind) if fits(registry.part_class(kind, name))), None)
    if found is None:
        raise NotApplicable(f"no {what} is installed")
    return found
