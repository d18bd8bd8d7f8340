"""Effects that a scene lacks and that installed parts would bring: friction, nodal forces, recording.

Those that a part names as `beyond` itself are among the variants of the breakdown already.
"""

from __future__ import annotations

from collections.abc import Iterator

from contactlab.scene.fields import is_required, keys_of
from contactlab.scene.scene import Scene
from contactlab.studies.removable import Variant
from contactlab.testing.assertions import NotApplicable
from contactlab.testing.examples import example_spec


def lacking(scene: Scene) -> Iterator[Variant]:
    """A variant for each, with usual values: the cost hardly depends on them."""
    if scene.contacts and not any(contact.friction for contact in scene.contacts):
        yield from _friction(scene)
    yield from _effects(scene)
    if scene.record.recorders == ():
        data = {key: value for key, value in scene.data.get("record", {}).items() if key != "recorders"}
        yield Variant("recording", False, {"record": data})


def _friction(scene: Scene) -> Iterator[Variant]:
    for name in scene.registry.names("friction"):
        try:
            law = example_spec(scene.registry, "friction", name)
        except NotApplicable:
            continue
        changes = {f"contacts.{number}.friction": law for number in range(len(scene.contacts))}
        yield Variant(f"friction ({name})", False, changes)


def _effects(scene: Scene) -> Iterator[Variant]:
    bodies = list(scene.bodies)
    places = {"on": bodies[0], "between": bodies[:2]}
    there = {spec["use"] for spec in scene.effects}
    for name in scene.registry.names("effect"):
        fields = keys_of(scene.registry.part_class("effect", name))
        given = {field: places[field] for field in places if field in fields and is_required(fields[field])}
        if name in there or ("between" in fields and len(bodies) < 2):
            continue
        try:
            spec = example_spec(scene.registry, "effect", name, given)
        except NotApplicable:
            continue
        yield Variant(name, False, {"effects": [*scene.data.get("effects", []), spec]})
