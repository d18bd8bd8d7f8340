"""Every effect that the project knows, called for by a scene or not."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from contactlab.missing_effects.locking import PLASTIC
from contactlab.model.model import Model
from contactlab.parts.registry import Registry
from contactlab.scene.scene import Scene


class Effect(NamedTuple):
    """An effect of mechanics, whether the scene calls for it, and by which key."""

    effect: str
    called_for: bool
    by: str


Keys = Callable[[Any, Model], list[str]]
"""The keys of a scene that call for an effect, empty where none does."""


def _moving(scene: Scene, model: Model) -> list[str]:
    moving = {f"bodies.{name}.velocity": any(body.velocity) for name, body in scene.bodies.items()}
    moving |= {f"bodies.{name}.spin": bool(body.spin) for name, body in scene.bodies.items()}
    return [key for key, moves in moving.items() if moves]


def _recording(scene: Scene, model: Model) -> list[str]:
    if scene.record.recorders is None:
        return ["the usual ones, in runs with a folder"]
    return [f"record.recorders.{i}" for i in range(len(scene.record.recorders))]


def _where(part: str, has: Callable[[Any], object]) -> Keys:
    """The keys of a part of those bodies that have something."""
    return lambda scene, model: [f"bodies.{body.name}.{part}" for body in model.bodies if has(body)]


ROWS: dict[str, Keys] = {
    "inertia": lambda scene, model: ["integrator"] if model.integrator.inertia else [],
    "several bodies": lambda scene, model: [f"bodies.{name}" for name in scene.bodies if len(scene.bodies) > 1],
    "initial velocity": _moving,
    "contact": lambda scene, model: [f"contacts.{i}" for i in range(len(scene.contacts))],
    "friction": lambda scene, model: [
        f"contacts.{i}.friction" for i, c in enumerate(scene.contacts) if c.friction is not None
    ],
    "rigid surfaces": lambda scene, model: [f"rigid.{name}" for name in scene.rigid],
    "finite strain": _where("material", lambda body: body.material.kinematics != "small"),
    "material history": _where("material", lambda body: body.material.history_size),
    "plasticity": _where("material", lambda body: PLASTIC in body.material.history_names),
    "quadratic shape functions": _where("element", lambda body: body.element.degree > 1),
    "hourglass control": lambda scene, model: [
        f"bodies.{f.body.name}.element" for f in model.forces if f.kernels.stabilise is not None
    ],
    "damping": lambda scene, model: [] if not model.damping else ["time.damping" if scene.time.damping else "time.end"],
    "loads": lambda scene, model: [f"loads.{i}" for i in range(len(scene.loads))],
    "fields": lambda scene, model: [f"fields.{name}" for name in scene.fields],
    "recording": _recording,
}


def effects_of(scene: Scene, registry: Registry, model: Model) -> list[Effect]:
    """A row for each effect, and for each installed part of that kind."""
    keys = {name: found(scene, model) for name, found in ROWS.items()}
    for name in registry.names("effect"):
        keys[name] = [f"effects.{i}" for i, spec in enumerate(scene.effects) if spec["use"] == name]
    return [Effect(name, bool(by), ", ".join(by) or "not declared") for name, by in keys.items()]
