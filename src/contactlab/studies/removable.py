"""Effects that can be taken out of a scene, or added to it, one at a time: one entry each."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

from contactlab.errors import RequestError
from contactlab.scene.auto import integrators_in, is_auto
from contactlab.scene.fields import keys_of
from contactlab.scene.scene import Scene


class Variant(NamedTuple):
    """A scene with one effect less or more.

    effect    its name
    declared  True: the scene has it and the variant does not; False: the other way round
    changes   scene keys and values
    """

    effect: str
    declared: bool
    changes: Mapping[str, Any]

    @property
    def label(self) -> str:
        """The variant in words, such as "without friction" or "with quadratic shape functions"."""
        return f"{'without' if self.declared else 'with'} {self.effect}"


def variants(scene: Scene) -> list[Variant]:
    """All variants of a scene, by the entries of `TABLE` and then by what its parts say of themselves."""
    found = [Variant(name, True, changes) for name, entry in TABLE.items() if (changes := entry(scene))]
    return found + list(_of_effects(scene)) + list(_of_parts(scene))


# --- effects that a scene declares by its own keys ---------------------------------------------------


def _friction(scene: Scene) -> dict[str, Any]:
    return {f"contacts.{i}.friction": None for i, contact in enumerate(scene.contacts) if contact.friction}


def _contact(scene: Scene) -> dict[str, Any]:
    return {"contacts": [], "rigid": {}} if scene.contacts else {}


def _damping(scene: Scene) -> dict[str, Any]:
    found = scene.time.damping is None and scene.time.end == "auto"
    inertia = any(scene.registry.part_class("integrator", name).inertia for _, name in integrators_in(scene.integrator))
    return {"time.damping": 0.0} if inertia and (found or scene.time.damping) else {}


def _following(scene: Scene) -> dict[str, Any]:
    following = [i for i, load in enumerate(scene.loads) if load.follower and (load.pressure or load.shear)]
    return {f"loads.{i}.follower": False for i in following}


def _recording(scene: Scene) -> dict[str, Any]:
    return {"record.recorders": []} if scene.record.recorders != () else {}


TABLE: dict[str, Callable[[Scene], dict[str, Any]]] = {
    "friction": _friction,
    "contact": _contact,
    "damping": _damping,
    "loads that follow": _following,
    "recording": _recording,
}
"""Name of an effect, and the changes that take it out; empty if a scene does not have it."""


# --- effects that are parts, and effects that parts have ---------------------------------------------


def _of_effects(scene: Scene) -> Iterator[Variant]:
    data = scene.data.get("effects", [])
    for name in dict.fromkeys(spec["use"] for spec in scene.effects):
        yield Variant(name, True, {"effects": [spec for spec in data if spec["use"] != name]})


def _of_parts(scene: Scene) -> Iterator[Variant]:
    """Yield a variant for each effect that parts of the scene declare, or declare as left out."""
    places = [("integrator", "integrator", scene.integrator)] if not is_auto(scene.integrator) else []
    places += [("material", f"materials.{name}", spec) for name, spec in scene.materials.items()]
    places += [("element", f"bodies.{name}.element", body.element) for name, body in scene.bodies.items()]
    less: dict[str, dict[str, Any]] = {}
    more: dict[str, dict[str, Any]] = {}
    for kind, key, spec in places:
        own = scene.registry.part_class(kind, spec["use"])
        for changes, relatives in ((less, getattr(own, "without", {})), (more, getattr(own, "beyond", {}))):
            for effect, name in relatives.items():
                other = _like(scene, kind, spec, name)
                if other is not None:
                    changes.setdefault(effect, {})[key] = other
    yield from (Variant(effect, True, changes) for effect, changes in less.items())
    yield from (Variant(effect, False, changes) for effect, changes in more.items() if effect not in less)


def _like(scene: Scene, kind: str, spec: Mapping[str, Any], name: str) -> dict[str, Any] | None:
    """The part `name` with the constants that both have; None if it is not installed or needs others."""
    try:
        fields = keys_of(scene.registry.part_class(kind, name))
        made = {"use": name} | {field: value for field, value in spec.items() if field in fields}
        scene.registry.written_out(kind, made)
    except RequestError:
        return None
    return made
