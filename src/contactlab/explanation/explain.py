"""Effects that a scene uses and does not use, read from the model that `build` makes of it.

Data that only a separate process can measure (kernels, imported modules, seconds) come from a trial run.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from contactlab.explanation.effect_table import Effect, effects_of
from contactlab.explanation.estimate import Estimate, estimate
from contactlab.explanation.trial_run import KernelCalls, PartCost, TrialRun
from contactlab.model.build import build
from contactlab.model.held_arrays import HeldArray, held_arrays
from contactlab.model.model import Model
from contactlab.parts.provenance import part_specs
from contactlab.parts.registry import Registry
from contactlab.run.attempts import Attempts
from contactlab.run.prepare import schedule_of
from contactlab.scene.scene import Scene
from contactlab.views import view


class UsedPart(NamedTuple):
    """A part in use: the scene's key, its name, and the distribution it comes from."""

    key: str
    part: str
    package: str


class Call(NamedTuple):
    """Calls of parts, and how often they are made: in every step, or in every iteration of an implicit one."""

    call: str
    times: int
    per: str


class Imported(NamedTuple):
    """A package, what of it is imported, and the plugin that it belongs to; none where it is a library."""

    package: str
    modules: str
    plugin: str


@dataclass(frozen=True)
class Overview:
    """Single numbers: sizes (`array_bytes` in bytes), steps, and seconds. NaN without a trial.

    `stable_step` [s] is the stable step of the run, `bodies_step` of its bodies without effects.
    """

    name: str
    nodes: int
    cells: int
    quadrature_points: int
    contact_multipliers: int
    stable_step: float
    bodies_step: float
    step: float
    steps_follow: str
    estimated_steps: int
    history: str
    contact_forces: str
    integrator: str
    seconds_to_first_step: float
    seconds_per_step: float
    wall_seconds_per_step: float
    estimated_seconds: float
    array_bytes: int


@dataclass(frozen=True)
class Explanation:
    """Sections in the order they are printed. `costs` are per step, in s; `price` is for the whole run.

    `missing`: what the trial run missed in the scene, as far as it came.
    """

    scene: Overview
    effects: list[Effect]
    missing: list[str]
    parts: list[UsedPart]
    calls: list[Call]
    costs: list[PartCost]
    kernels: list[KernelCalls]
    arrays: list[HeldArray]
    modules: list[Imported]
    price: Estimate | None

    def __repr__(self) -> str:
        return str(view("notebook.texts.explanation_text")(self))


def explain(
    scene: Scene, registry: Registry, trial: TrialRun | None = None, attempts: Attempts | None = None
) -> Explanation:
    """Build the model of `scene`, with the integrator that its run begins with, and read off what it holds and calls.

    attempts  the order of integrators that it is of, with those that refuse the scene (see `first_that_fits`)

    Without a trial run there are no kernels and no seconds, modules are the packages of the scene's
    parts, and arrays are those before the first step.
    """
    model = build(scene, registry)
    schedule = schedule_of(model, scene)
    steps = schedule.estimated_steps()
    bound = model.bound_integrator().advance
    arrays = held_arrays(model, integrator=bound)
    # until the first step is done, and of each further one
    seconds = (
        (math.nan, math.nan) if trial is None else (trial.import_s + trial.build_s + trial.first_step_s, trial.step_s)
    )
    if trial is not None:
        arrays = list(trial.arrays)
    overview = Overview(
        name=scene.name,
        nodes=len(model.reference),
        cells=sum(len(body.cells) for body in model.bodies),
        quadrature_points=sum(len(body.cells) * body.points for body in model.bodies),
        contact_multipliers=model.state["multipliers"].shape[1] if "multipliers" in model.state else 0,
        stable_step=model.step_within(1.0) if model.explicit else math.nan,
        bodies_step=model.stable_step() if model.explicit else math.nan,
        step=schedule.dt,
        steps_follow=schedule.parameter,
        estimated_steps=steps,
        history=_history(model, steps if schedule.skips else 0),
        contact_forces=_contact_forces(model),
        integrator=_order(scene, attempts) if attempts is not None else "",
        seconds_to_first_step=seconds[0],
        seconds_per_step=seconds[1],
        wall_seconds_per_step=trial.wall_step_s if trial is not None else math.nan,
        estimated_seconds=seconds[0] + (steps - 1) * seconds[1],
        array_bytes=sum(array.bytes for array in arrays),
    )
    origins = {package: str(origin) for package, origin in registry.packages().items()}
    inside: dict[str, list[str]] = {}
    for name in trial.modules if trial is not None else packages_of(scene, registry):
        package, _, module = name.partition(".")
        inside.setdefault(package, []).extend([module] if module else [])
    modules = [Imported(package, ", ".join(modules), origins.get(package, "")) for package, modules in inside.items()]
    return Explanation(
        scene=overview,
        effects=effects_of(scene, registry, model),
        missing=list(trial.begin.missing) if trial is not None and trial.begin is not None else [],
        parts=used_parts(scene, registry),
        calls=list(calls_of(model)),
        costs=list(trial.costs) if trial is not None else [],
        kernels=list(trial.kernels) if trial is not None else [],
        arrays=arrays,
        modules=modules,
        price=estimate(scene, model, trial) if trial is not None else None,
    )


def _history(model: Model, at_once: int) -> str:
    """Keys by which the end depends on the loading path, and how the run follows the path.

    at_once  load steps that go directly to the end, or from turn to turn of the loading; 0: the path is followed
    """
    if at_once:
        steps = "one load step" if at_once == 1 else f"{at_once} load steps, from turn to turn"
        return f"{model.history}, so {steps}"
    if model.timing.follows:
        return str(model.history)
    return f"{model.history} (key time.history)"


def _contact_forces(model: Model) -> str:
    """Along what contact forces act in explicit runs."""
    from contactlab.contact.explicit_system import ContactSystem

    contact = model.contact
    if not isinstance(contact, ContactSystem):
        return ""
    return "consistent" if contact.consistent else "frozen"


def _order(scene: Scene, attempts: Attempts) -> str:
    """The integrator that a run begins with, those that follow if it fails, and those that refuse the scene."""
    use, refused = str(scene.integrator["use"]), [attempt.brief for attempt in attempts.tried]
    later = [str(spec["use"]) for spec in attempts.order[len(refused) + 1 :]]
    then = f", then {', '.join(later)} if it fails" if later else ""
    return "; ".join([f"auto: {use}{then}", *refused])


def used_parts(scene: Scene, registry: Registry) -> list[UsedPart]:
    """The scene's parts, and what its integrator adds where the scene names nothing."""
    specs = list(part_specs(scene))
    own = registry.part_class("integrator", scene.integrator["use"]).default_enforcement
    for number, contact in enumerate(scene.contacts):
        if contact.enforcement is None:
            specs.append((f"contacts.{number}.enforcement, the integrator's own", "enforcement", own))
    return [UsedPart(key, name, str(registry.offer(kind, name).origin)) for key, kind, name in specs]


def calls_of(model: Model) -> Iterator[Call]:
    """Calls that a step makes into parts, as the model has bound them."""
    per = "step" if model.explicit else "iteration"
    counts = _body_calls(model) | (
        {} if model.contact is None else {**model.contact.calls_per_step(), "contact enforcement": 1}
    )
    yield from (Call(name, count, per) for name, count in counts.items() if count)
    if model.loading.loads:
        yield Call("loads and effects", len(model.loading.loads), "step")
    yield Call("integrator", 1, "step")


def _body_calls(model: Model) -> dict[str, int]:
    blocks = sum(len(forces.blocks) for forces in model.forces)
    rate = sum(len(forces.blocks) for forces in model.forces if forces.body.material.kinematics == "rate")
    stabilised = sum(len(forces.blocks) for forces in model.forces if forces.kernels.stabilise is not None)
    return {
        "element gradient": blocks,
        "increment to midpoint": rate,
        "material stress": blocks,
        "element force": blocks,
        "element stabilisation": stabilised,
    }


def packages_of(scene: Scene, registry: Registry) -> list[str]:
    """Import packages of the plugins that the scene uses, in addition to the core."""
    targets = {registry.offer(kind, name).part.target for _, kind, name in part_specs(scene)}
    return sorted({target.partition(":")[0].partition(".")[0] for target in targets} | {"numba", "numpy"})
