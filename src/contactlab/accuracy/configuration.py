"""Configurations of a scene: algorithm, slave, element, integrator and surfaces, each with the keys that make it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from contactlab.api import ExplicitIntegrator, Potential, SegmentContact
from contactlab.parts.registry import Registry
from contactlab.scene.scene import Scene


@dataclass(frozen=True)
class Configuration:
    """Configuration of a run; an empty string keeps the value of the scene.

    algorithm   of all contacts, a name or a table
    exchanged   numbers of the contacts whose slave and master are exchanged
    element     of all bodies, a name or a table
    integrator  its name
    steps       load steps of a static integrator; 0 leaves them
    smooth      numbers of the contacts with smooth surfaces; None leaves them
    """

    algorithm: Any
    exchanged: tuple[int, ...] = ()
    element: Any = ""
    integrator: str = ""
    steps: int = 0
    smooth: tuple[int, ...] | None = None

    def named(self, contacts: int) -> str:
        """Name for tables of a scene with so many contacts."""
        words = [self.algorithm, self.element, self.integrator, f"{self.steps} steps" if self.steps else ""]
        parts = [" ".join(filter(None, words))]
        for word, numbers in (("smooth", self.smooth), ("exchanged", self.exchanged)):
            if numbers:
                which = [f"contacts.{n}" for n in numbers] if len(numbers) < contacts else []
                parts.append(" ".join([word, ", ".join(which)]).rstrip())
        return ", ".join([*parts, "not smooth"] if self.smooth == () else parts)

    def changes(self, data: Mapping[str, Any], level: int) -> dict[str, Any]:
        """Scene keys and values that make it of a scene (its TOML data) at a mesh level."""
        found: dict[str, Any] = {"level": level}
        if self.integrator:
            found["integrator"] = self.integrator
        if self.steps:
            found["integrator.steps"] = self.steps
        if self.element:
            found |= {f"bodies.{name}.element": self.element for name in data["bodies"]}
        for number, contact in enumerate(data["contacts"]):
            found[f"contacts.{number}.algorithm"] = self.algorithm
            if number in self.exchanged:
                found[f"contacts.{number}.swap"] = not contact.get("swap", False)
            if self.smooth is not None and (number in self.smooth) != contact.get("smooth", False):
                found[f"contacts.{number}.smooth"] = number in self.smooth
        return found


def algorithms_for(scene: Scene, registry: Registry) -> list[str]:
    """Algorithms to try: those that pass the patch test first, of these the scene's own.

    Potentials only if the scene names one: their error depends on parameters that no mesh improves.
    """
    own = {contact.algorithm["use"] for contact in scene.contacts}
    kinds = {name: registry.part_class("contact", name) for name in registry.names("contact")}
    tried = [name for name, kind in kinds.items() if name in own or not issubclass(kind, Potential)]
    return sorted(tried, key=lambda name: (not kinds[name].passes_patch_test, name not in own, name))


def possible(wanted: Iterable[Configuration], scene: Scene, registry: Registry) -> list[Configuration]:
    """Return configurations with surfaces that they can have, without those that have smooth ones and cannot.

    Algorithms that integrate over segments can, on edges of two nodes; the others do without if the scene is smooth.
    """
    found = (_possible(each, scene, registry) for each in wanted)
    return [each for each in found if each is not None]


def _possible(configuration: Configuration, scene: Scene, registry: Registry) -> Configuration | None:
    own = {str(body["element"]["use"]) for body in scene.data["bodies"].values()}
    elements = {configuration.element} if configuration.element else own
    able = issubclass(registry.part_class("contact", configuration.algorithm), SegmentContact) and all(
        len(registry.part_class("element", name).edges[0]) == 2 for name in elements
    )
    if configuration.smooth:
        return configuration if able else None
    declared = any(contact.smooth for contact in scene.contacts)
    return replace(configuration, smooth=() if declared and not able else None)


def exchangeable(data: Mapping[str, Any]) -> tuple[int, ...]:
    """Numbers of the contacts whose master can be the slave: no rigid surface can."""
    rigid = data.get("rigid", {})

    def master(contact: Mapping[str, Any]) -> list[str]:
        side = contact["slave"] if contact.get("swap") else contact["master"]
        return [side] if isinstance(side, str) else list(side)

    return tuple(n for n, contact in enumerate(data["contacts"]) if not set(master(contact)) & set(rigid))


def integrators_for(scene: Scene, registry: Registry) -> list[str]:
    """Integrators that can take a scene, "" for its own, statics first; more than one if it is quasi-static."""
    own = str(scene.integrator["use"])
    kinds = {name: registry.part_class("integrator", name) for name in registry.names("integrator")}
    static = [name for name, kind in kinds.items() if not kind.inertia]
    explicit = [name for name, kind in kinds.items() if issubclass(kind, ExplicitIntegrator)]
    if own not in static and scene.data["time"].get("end") != "auto":
        return [""]
    wanted = [own, *explicit[:1]] if own in static else [*static[:1], own]
    return ["" if name == own else name for name in wanted]


def elements_for(scene: Scene, registry: Registry) -> list[str]:
    """Elements to try, "" for those of the scene first.

    Without those that declare to lack integration points, and those that have only more nodes inside than another.
    """
    own = {str(body["element"]["use"]) for body in scene.data["bodies"].values()}
    kinds = {name: registry.part_class("element", name) for name in registry.names("element")}

    def spared(kind: Any) -> bool:
        rivals = [one for one in kinds.values() if one.edges == kind.edges and len(one.nodes) < len(kind.nodes)]
        return "full integration" in kind.beyond or bool(rivals)

    return ["", *(name for name, kind in kinds.items() if not spared(kind) and {name} != own)]
