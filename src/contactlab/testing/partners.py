"""Partners of the part under check: shipped parts alone, whatever else is installed."""

from __future__ import annotations

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
    for name in partners(registry, "contact"):
        cls = registry.part_class("contact", name)
        if cls.passes_patch_test and not issubclass(cls, Potential):
            return name
    raise NotApplicable("no contact algorithm that passes the patch test is installed")


def usual_law(registry: Registry) -> str:
    """A shipped pressure law that needs no values and nothing but gaps."""
    for name in partners(registry, "enforcement"):
        cls = registry.part_class("enforcement", name)
        if (
            issubclass(cls, NormalLaw)
            and not cls.named()
            and not any(is_required(key) for key in keys_of(cls).values())
        ):
            return name
    raise NotApplicable("no pressure law without values of its own is installed")


def usual_flow(registry: Registry) -> str:
    """A shipped material that yields: one that needs a yield stress."""
    for name in partners(registry, "material"):
        keys = keys_of(registry.part_class("material", name))
        if "yield_stress" in keys and is_required(keys["yield_stress"]):
            return name
    raise NotApplicable("no material that yields is installed")


def usual_motion(registry: Registry) -> str:
    """A shipped integrator with inertia whose steps iterate."""
    for name in partners(registry, "integrator"):
        cls = registry.part_class("integrator", name)
        if cls.inertia and not issubclass(cls, ExplicitIntegrator):
            return name
    raise NotApplicable("no implicit integrator with inertia is installed")
