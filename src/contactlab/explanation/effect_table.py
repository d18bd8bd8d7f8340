"""Every effect that the project knows, called for by a scene or not."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

from contactlab.missing_effects.locking import PLASTIC
from contactlab.model.model import Model

if TYPE_CHECKING:
    from contactlab.parts.registry import Registry
    from contactlab.scene.scene import Scene


class Effect(NamedTuple):
    """An effect of mechanics, whether the scene calls for it, and by which key."""

    effect: str
    called_for: bool
    by: str


Keys = Callable[[Any, Model], list[str]]
"""The keys of a scene that call for an effect, empty where none does."""


def _inertia(scene: Scene, model: Model) -> list[str]:
    return ["integrator"] if model.integrator.inertia else []


def _several_bodies(scene: Scene, model: Model) -> list[str]:
    return [f"bodies.{name}" for name in scene.bodies] if len(scene.bodies) > 1 else []


def _moving(scene: Scene, model: Model) -> list[str]:
    moving = {f"bodies.{name}.velocity": any(body.velocity) for name, body in scene.bodies.items()}
    moving |= {f"bodies.{name}.spin": bool(body.spin) for name, body in scene.bodies.items()}
    return [key for key, moves in moving.items() if moves]


def _contact(scene: Scene, model: Model) -> list[str]:
    return [f"contacts.{i}" for i in range(len(scene.contacts))]


def _friction(scene: Scene, model: Model) -> list[str]:
    return [f"contacts.{i}.friction" for i, contact in enumerate(scene.contacts) if contact.friction is not None]


def _rigid(scene: Scene, model: Model) -> list[str]:
    return [f"rigid.{name}" for name in scene.rigid]


def _finite(scene: Scene, model: Model) -> list[str]:
    return [f"bodies.{b.name}.material" for b in model.bodies if b.material.kinematics != "small"]


def _history(scene: Scene, model: Model) -> list[str]:
    return [f"bodies.{b.name}.material" for b in model.bodies if b.material.history_size]


def _plasticity(scene: Scene, model: Model) -> list[str]:
    return [f"bodies.{b.name}.material" for b in model.bodies if PLASTIC in b.material.history_names]


def _quadratic(scene: Scene, model: Model) -> list[str]:
    return [f"bodies.{b.name}.element" for b in model.bodies if b.element.degree > 1]


def _hourglass(scene: Scene, model: Model) -> list[str]:
    return [f"bodies.{f.body.name}.element" for f in model.forces if f.kernels.stabilise is not None]


def _damping(scene: Scene, model: Model) -> list[str]:
    return ["time.damping" if scene.time.damping else "time.end"] if model.damping else []


def _loads(scene: Scene, model: Model) -> list[str]:
    return [f"loads.{i}" for i in range(len(scene.loads))]


def _recording(scene: Scene, model: Model) -> list[str]:
    if scene.record.recorders is None:
        return ["the usual ones, in runs with a folder"]
    return [f"record.recorders.{i}" for i in range(len(scene.record.recorders))]


ROWS: dict[str, Keys] = {
    "inertia": _inertia,
    "several bodies": _several_bodies,
    "initial velocity": _moving,
    "contact": _contact,
    "friction": _friction,
    "rigid surfaces": _rigid,
    "finite strain": _finite,
    "material history": _history,
    "plasticity": _plasticity,
    "quadratic shape functions": _quadratic,
    "hourglass control": _hourglass,
    "damping": _damping,
    "loads": _loads,
    "recording": _recording,
}


def effects_of(scene: Scene, registry: Registry, model: Model) -> list[Effect]:
    """A row for each effect, and for each installed part of that kind."""
    keys = {name: found(scene, model) for name, found in ROWS.items()}
    for name in registry.names("effect"):
        keys[name] = [f"effects.{i}" for i, spec in enumerate(scene.effects) if spec["use"] == name]
    return [Effect(name, bool(by), ", ".join(by) or "not declared") for name, by in keys.items()]
