"""What a scene calls for and what it does not, read off the model that `build` makes of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from contactlab.model.arrays import HeldArray, held_arrays
from contactlab.model.build import build
from contactlab.model.model import Model

NANOSECONDS_PER_POINT = 12.0  # of a Q1 update on one core of 2025, to turn counts into an order of magnitude


class Effect(NamedTuple):
    """An effect of mechanics, whether the scene calls for it, and by which key."""

    effect: str
    called_for: bool
    by: str


class UsedPart(NamedTuple):
    """A part in use: the scene's key, its name, and the distribution it comes from."""

    key: str
    part: str
    package: str


class Call(NamedTuple):
    """Calls made in every step."""

    call: str
    per_step: int


@dataclass(frozen=True)
class Explanation:
    """Sections in the order they are printed. Sizes in bytes, times in s."""

    name: str
    nodes: int
    cells: int
    quadrature_points: int
    contact_multipliers: int
    stable_step: float
    step: float
    estimated_steps: int
    estimated_seconds: float
    array_bytes: int
    effects: list[Effect]
    parts: list[UsedPart]
    calls_per_step: list[Call]
    arrays: list[HeldArray]
    modules: list[str]


def explain(scene: Any, registry: Any) -> Explanation:
    """Build the model of `scene` and read off what it holds and calls; nothing is run."""
    from contactlab.schedule import Schedule

    model = build(scene, registry)
    schedule = Schedule(model, scene)
    duration = model.pace.end if model.pace.end is not None else model.pace.ramp + model.pace.period
    steps = max(1, round(duration / schedule.dt))
    points = sum(len(body.cells) * body.points for body in model.bodies)
    arrays = held_arrays(model)
    return Explanation(
        name=scene.name,
        nodes=len(model.reference),
        cells=sum(len(body.cells) for body in model.bodies),
        quadrature_points=points,
        contact_multipliers=model.state["multipliers"].shape[1] if "multipliers" in model.state else 0,
        stable_step=model.stable_step() if model.integrator.explicit else float("nan"),
        step=schedule.dt,
        estimated_steps=steps,
        estimated_seconds=steps * points * NANOSECONDS_PER_POINT * 1e-9 * (1.5 if model.contact else 1.0),
        array_bytes=sum(array.bytes for array in arrays),
        effects=effects_of(scene, model),
        parts=used_parts(scene, registry),
        calls_per_step=calls_per_step(model),
        arrays=arrays,
        modules=modules_of(scene, registry),
    )


def effects_of(scene: Any, model: Model) -> list[Effect]:
    """Every effect the project knows, called for or not."""
    laws = {name: body.material.kinematics for name, body in zip(scene.bodies, model.bodies, strict=True)}
    finite = [f"bodies.{name}.material" for name, kinematics in laws.items() if kinematics != "small"]
    history = [f"bodies.{b.name}.material" for b in model.bodies if b.material.history_size]
    contacts = [f"contacts.{i}" for i in range(len(scene.contacts))]
    friction = [f"contacts.{i}.friction" for i, c in enumerate(scene.contacts) if c.friction is not None]
    moving = [f"bodies.{name}.velocity" for name, body in scene.bodies.items() if any(body.velocity)]
    rows = {
        "inertia": ["integrator"] if model.integrator.inertia else [],
        "initial velocity": moving,
        "contact": contacts,
        "friction": friction,
        "finite strain": finite,
        "material history": history,
        "damping": ["time.damping" if scene.time.damping else "time.end"] if model.damping else [],
        "loads and effects": [f"{len(model.loads)} calls"] if model.loads else [],
        "recording": _recorders(scene),
    }
    return [Effect(name, bool(keys), ", ".join(keys) or "not declared") for name, keys in rows.items()]


def _recorders(scene: Any) -> list[str]:
    if scene.record.recorders is None:
        return ["the usual ones, in runs with a folder"]
    return [f"record.recorders.{i}" for i in range(len(scene.record.recorders))]


def used_parts(scene: Any, registry: Any) -> list[UsedPart]:
    """The scene's parts, and what its integrator adds where the scene names nothing."""
    from contactlab.provenance import part_specs

    return [UsedPart(key, name, str(registry.offer(kind, name).origin)) for key, kind, name in part_specs(scene)]


def calls_per_step(model: Model) -> list[Call]:
    """Block calls of the bodies and calls of contact and loads."""
    blocks = sum(len(forces.blocks) for forces in model.forces)
    rate = sum(len(forces.blocks) for forces in model.forces if forces.body.material.kinematics == "rate")
    pairs = len(model.contact.pairs) if model.contact is not None else 0
    rows = {
        "element gradient": blocks,
        "increment to midpoint": rate,
        "material stress": blocks,
        "element force": blocks,
        "node update (predict, correct)": 2 if model.integrator.inertia else 0,
        "contact pieces, coupling, rows": pairs,
        "contact solve": 1 if pairs else 0,
        "loads and effects": len(model.loads),
    }
    return [Call(name, count) for name, count in rows.items() if count]


def modules_of(scene: Any, registry: Any) -> list[str]:
    """Import packages of the plugins that the scene brings in, beside the core."""
    from contactlab.provenance import part_specs

    targets = {registry.offer(kind, name).part.target for _, kind, name in part_specs(scene)}
    return sorted({target.partition(":")[0].partition(".")[0] for target in targets} | {"numba", "numpy"})
