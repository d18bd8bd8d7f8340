"""`integrator = "auto"`: integrators in the order in which a run tries them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from contactlab.scene.fields import PartSpec, part

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


def is_auto(integrator: PartSpec) -> bool:
    """Return whether the integrator of a scene is left to the run."""
    return bool(integrator["use"] == AUTO)


def integrators_in(integrator: PartSpec) -> Iterator[tuple[str, str]]:
    """Key and name of each integrator that a scene names."""
    if not is_auto(integrator):
        yield "integrator", integrator["use"]
        return
    for number, spec in enumerate(integrator["order"]):
        yield f"integrator.order.{number}", spec["use"]
