"""Cost of each effect of a scene, by trials of the scene with and without it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from contactlab.errors import RequestError, SimulationFailure, one_line
from contactlab.explanation.estimate import Estimate, estimate
from contactlab.explanation.kept import Tried
from contactlab.model.build import build
from contactlab.scene.fields import is_required, keys_of
from contactlab.scene.scene import Scene
from contactlab.studies.removable import Variant, variants
from contactlab.testing.assertions import NotApplicable
from contactlab.testing.examples import example_spec


@dataclass(frozen=True)
class EffectPrice:
    """Cost of an effect: the run with it less the run without it.

    declared    False: the scene lacks the effect and would cost this more with it
    cpu_s, least_s, most_s  CPU time of the steps [s]
    memory_mib  of the process [MiB]
    steps, iterations  that the effect adds
    reason      why nothing is known: the scene without it is refused, or its trial failed
    refused     the first of these
    """

    effect: str
    declared: bool
    cpu_s: float = math.nan
    least_s: float = math.nan
    most_s: float = math.nan
    memory_mib: float = math.nan
    steps: float = math.nan
    iterations: float = math.nan
    reason: str = ""
    refused: bool = False


def effect_costs(scene: Scene, whole: Estimate, tried: Tried) -> Iterator[EffectPrice]:
    """Each effect of which `tried` has a trial: those that can be taken out, then what installed parts would bring."""
    for variant in (*variants(scene), *lacking(scene)):
        found = _cost(variant, scene, whole, tried)
        if found is not None:
            yield found


def _cost(variant: Variant, scene: Scene, whole: Estimate, tried: Tried) -> EffectPrice | None:
    try:
        changed = scene.with_(variant.changes)
        trial = tried(changed)
        if trial is None:
            return None
        other = estimate(changed, build(changed, changed.registry), trial)
    except SimulationFailure as failure:
        return EffectPrice(variant.effect, variant.declared, reason=failure.reason)
    except RequestError as error:
        return EffectPrice(variant.effect, variant.declared, reason=one_line(error), refused=True)
    if other.reason or whole.reason:
        return EffectPrice(variant.effect, variant.declared, reason=f"its trial ended {other.reason or whole.reason}")
    rich, poor = (whole, other) if variant.declared else (other, whole)
    return EffectPrice(
        variant.effect, variant.declared, rich.cpu_s - poor.cpu_s, rich.least_s - poor.most_s,
        rich.most_s - poor.least_s, rich.memory_mib - poor.memory_mib, rich.steps - poor.steps,
        rich.iterations - poor.iterations,
    )  # fmt: skip


def lacking(scene: Scene) -> Iterator[Variant]:
    """A variant for each, with usual values: the cost hardly depends on them."""
    if scene.contacts and not any(contact.friction for contact in scene.contacts):
        for name in scene.registry.names("friction"):
            try:
                law = example_spec(scene.registry, "friction", name)
            except NotApplicable:
                continue
            changes = {f"contacts.{number}.friction": law for number in range(len(scene.contacts))}
            yield Variant(f"friction ({name})", False, changes)
    yield from _effects(scene)
    if scene.record.recorders == ():
        data = {key: value for key, value in scene.data.get("record", {}).items() if key != "recorders"}
        yield Variant("recording", False, {"record": data})


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
