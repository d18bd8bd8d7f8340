"""`integrator = "auto"`: integrators in the order in which a run tries them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from contactlab.api import ExplicitIntegrator
from contactlab.scene.fields import PartSpec, part

if TYPE_CHECKING:
    from contactlab.parts.registry import Registry
    from contactlab.scene.scene import Scene

AUTO = "auto"


@dataclass(frozen=True)
class Auto:
    """`{ use = "auto", order = [...] }` as the integrator of a scene."""

    order: tuple[PartSpec, ...] = part(
        "integrator",
        says="integrators by name or as tables; the first whose run gets through is used; not written: statics, "
        "implicit dynamics, explicit steps",
    )

    def __post_init__(self) -> None:
        names = [spec["use"] for spec in self.order]
        if not names or AUTO in names:
            raise ValueError(f"order: got {names}, allowed: at least one integrator, and not auto itself")


def is_auto(scene: Scene) -> bool:
    """Return whether a scene leaves its integrator to the run."""
    return bool(scene.integrator["use"] == AUTO)


def usual_order(registry: Registry) -> list[str]:
    """Names of the integrators that are tried if a scene gives no order: statics, implicit, explicit."""
    kinds = {name: registry.part_class("integrator", name) for name in registry.names("integrator")}
    usual = [name for name, kind in kinds.items() if kind.by_default]
    return sorted(usual, key=lambda name: (kinds[name].inertia, issubclass(kinds[name], ExplicitIntegrator)))


def candidates(scene: Scene) -> tuple[Scene, ...]:
    """The scene with each integrator of its order; of one that names its integrator, the scene alone."""
    if not is_auto(scene):
        return (scene,)
    return tuple(replace(scene, integrator=spec) for spec in scene.integrator["order"])


def integrators_in(integrator: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Key and name of each integrator that a scene names."""
    if integrator["use"] != AUTO:
        yield "integrator", integrator["use"]
        return
    for number, spec in enumerate(integrator["order"]):
        yield f"integrator.order.{number}", spec["use"]
