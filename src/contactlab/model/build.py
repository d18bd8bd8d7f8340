"""Scene and registry in, model out: the one place where plugin components meet, and where they are checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from contactlab.api import WORK, Effect, ExplicitIntegrator, Floats, Integrator, Ints, NormalLaw, RunWarning, State
from contactlab.errors import SceneError
from contactlab.model.bodies.body import NO_JOINTS, Body, BodyForces, Joints, RigidSurface, positions_of
from contactlab.model.bodies.build_bodies import build_bodies, masses_of
from contactlab.model.bodies.thread_blocks import in_order
from contactlab.model.history import History, history_of
from contactlab.model.loading.effect_rates import effect_rates
from contactlab.model.loading.held_bodies import check_supported
from contactlab.model.loading.load_profile import of_nodes
from contactlab.model.loading.node_profiles import tell_unresolved
from contactlab.model.loading.supports import SupportPlan, plan_supports
from contactlab.model.model import ExplicitModel, Loading, Model
from contactlab.model.momentum import mirrored_nodes
from contactlab.model.sizes import check_meshed_size, check_sizes
from contactlab.model.timing import Timing, find_timing
from contactlab.parts.error_origin import part_errors
from contactlab.parts.registry import Registry
from contactlab.scene.keys import Body as SceneBody
from contactlab.scene.scene import Scene


def build(scene: Scene, registry: Registry) -> Model:
    """Build the model of a scene, with every `auto` resolved.

    Raises SceneError or PartError, with file and key, for anything that does not fit together.
    """
    with part_errors(registry):
        return _bound(scene, registry, _planned(scene, registry))


@dataclass(frozen=True)
class _Plan:
    """Meshes, parts and times of a scene, before any array that changes in a run.

    contacts   their plans
    reference  (N, 2) [mm] of all nodes
    mass       (N,) [t], empty in statics
    told       warnings so far
    """

    integrator: Integrator
    bodies: tuple[Body, ...]
    rigid: tuple[RigidSurface, ...]
    contacts: tuple[Any, ...]
    reference: Floats
    mass: Floats
    supports: SupportPlan
    effects: tuple[Effect, ...]
    history: History
    timing: Timing
    told: list[RunWarning]


def _planned(scene: Scene, registry: Registry) -> _Plan:
    check_sizes(scene, registry)
    integrator = registry.make("integrator", scene.integrator, scene.where("integrator"))
    bodies = build_bodies(scene, registry)
    check_meshed_size(scene, registry, bodies)
    rigid = _rigid_surfaces(scene, bodies)
    contacts, bodies = _contact_plans(scene, registry, bodies, rigid, integrator)
    reference = positions_of(bodies, rigid)
    mass = masses_of(bodies, rigid) if integrator.inertia else np.zeros(0)
    told: list[RunWarning] = []
    supports = plan_supports(scene, bodies, rigid, reference, told)
    check_supported(scene, bodies, supports, integrator)
    effects = tuple(
        registry.make("effect", spec, scene.where(f"effects.{number}")) for number, spec in enumerate(scene.effects)
    )
    enforcements = {plan.name: plan.enforcement for plan in contacts}
    history = history_of(scene, bodies, enforcements, effects, integrator)
    timing = find_timing(
        scene, bodies, reference, mass, supports, integrator, history, lambda: _joints(contacts, reference)
    )
    return _Plan(integrator, bodies, rigid, contacts, reference, mass, supports, effects, history, timing, told)


def _bound(scene: Scene, registry: Registry, plan: _Plan) -> Model:
    """Make the arrays of a run, bind everything to them, and compute the forces of the start."""
    integrator, bodies, reference, mass, timing, told = (
        plan.integrator, plan.bodies, plan.reference, plan.mass, plan.timing, plan.told
    )  # fmt: skip
    model_class = _model_class(integrator)
    prescribed = plan.supports.bind(timing.ramps)
    if scene.contacts:
        from contactlab.model.loading.approach import check_approach

        check_approach(scene, bodies, plan.rigid, reference, prescribed, timing.last)
    state = State(_shapes(plan))
    position = reference.copy()
    increment = np.zeros_like(reference) if any(b.material.kinematics == "rate" for b in bodies) else None
    # the work of all bodies, distributed to the threads one body after the other
    arrays = (reference, position, increment, state, model_class.explicit)
    forces: tuple[BodyForces, ...] = ()
    for body in bodies:
        forces += (_bind(body, scene.threads, sum(len(before.blocks) for before in forces), *arrays),)
    _initial_velocity(scene, bodies, reference, mass, state, told)
    contact = _contact(
        plan.contacts, bodies=bodies, forces=forces, reference=reference, position=position, state=state, mass=mass,
        held=prescribed.dof, ramp=timing.ramp,
        driven=any(plan.supports.moving) or bool(scene.loads or scene.effects),
    )  # fmt: skip
    effects = _effects(plan, scene, registry, state)
    loads = _loads(scene, bodies, reference, position, timing.ramps, told)
    # the block calls of all bodies in order of execution
    calls = [call for body in forces for call in body.calls]
    colours = [colour for body in forces for colour in body.colours]
    model = model_class(
        reference=reference,
        position=position,
        mass=mass,
        prescribed=prescribed,
        contact=contact,
        split=_work_split(scene, integrator, contact, state, reference),
        state=state,
        integrator=integrator,
        bodies=bodies,
        forces=forces,
        timing=timing,
        history=plan.history,
        updates=in_order(calls, colours, [thread for body in forces for thread in body.block_threads], scene.threads),
        loading=Loading(plan.supports.sets, (*loads, *effects), effects),
        increment=increment,
        mirror=_mirror(scene, bodies, reference),
    )
    model.warnings.add(*timing.told, *told)
    _needs(model, scene)
    model.internal_force(0.0)
    model.make_constraints()
    if model.explicit:
        _limit_steps(model, scene, plan)
    return model


def _limit_steps(model: Model, scene: Scene, plan: _Plan) -> None:
    """Find what limits explicit steps beside the bodies: effects, and overlaps that are pushed out."""
    if model.loading.effects:
        size, times = float(np.ptp(plan.reference, axis=0).max()), (0.0, plan.timing.last)
        rates = effect_rates(model.loading.effects, model.state, plan.mass, size, model.stable_step(), times)
        model.loading = replace(model.loading, rates=rates)
    if any(contact.start.overlap == "ramp" for contact in plan.contacts):
        from contactlab.model.contact.initial_gap import check_ramp_steps

        step = scene.time.step or model.step_within(scene.time.fraction)
        check_ramp_steps(plan.contacts, plan.timing.ramp, step)


# --- optional parts of a scene are imported where they are declared ------------------------------


def _mirror(scene: Scene, bodies: tuple[Body, ...], reference: Floats) -> Ints | None:
    if scene.symmetry is None:
        return None
    return mirrored_nodes(reference, [slice(body.first, body.first + body.count) for body in bodies])


def _rigid_surfaces(scene: Scene, bodies: tuple[Body, ...]) -> tuple[RigidSurface, ...]:
    if not scene.rigid:
        return ()
    from contactlab.model.loading.rigid import build_rigid

    return build_rigid(scene, bodies)


def _contact_plans(
    scene: Scene, registry: Registry, bodies: tuple[Body, ...], rigid: tuple[RigidSurface, ...], integrator: Integrator
) -> tuple[tuple[Any, ...], tuple[Body, ...]]:
    """Return the contacts, and the bodies with slave nodes moved if a contact requires it."""
    if not scene.contacts:
        return (), bodies
    from contactlab.model.contact.initial_gap import adjusted_bodies
    from contactlab.model.contact.plan import plan_contacts
    from contactlab.model.contact.systems import by_energy

    plans = plan_contacts(scene, registry, bodies, rigid, integrator)
    bodies = adjusted_bodies(bodies, rigid, plans)
    if scene.loads and any(isinstance(p.enforcement, NormalLaw) and "traction" in p.enforcement.needs for p in plans):
        from contactlab.model.contact.traction_behind import refuse_loads

        refuse_loads(plans, scene, bodies)
    if any(map(by_energy, plans)):
        from contactlab.model.contact.potential_start import opened

        return opened(bodies, rigid, plans)
    return plans, bodies


def _joints(plans: tuple[Any, ...], reference: Floats) -> Joints:
    """Return the joints of bodies that touch from the start, so that they vibrate together."""
    if not plans:
        return NO_JOINTS
    from contactlab.model.contact.touching import touching

    return touching(plans, reference)


def _contact(plans: tuple[Any, ...], **around: Any) -> Any:
    if not plans:
        return None
    from contactlab.model.contact.systems import Around, build_contact

    return build_contact(plans, Around(**around))


def _loads(scene: Scene, *arguments: Any) -> Any:
    if not scene.loads:
        return ()
    from contactlab.model.loading.loads import build_loads

    return build_loads(scene, *arguments)


def _work_split(scene: Scene, integrator: Integrator, contact: Any, state: State, reference: Floats) -> Any:
    if not scene.record.contact_work or contact is None:
        return None
    from contactlab.contact.work_split import split_work

    return split_work(contact, integrator, state, reference, scene.where("record.contact_work"))


def _effects(plan: _Plan, scene: Scene, registry: Registry, state: State) -> Any:
    if not plan.effects:
        return ()
    from contactlab.model.loading.effects import build_effects

    bodies, ramps = plan.bodies, plan.timing.ramps
    mass = partial(masses_of, bodies, plan.rigid)
    return build_effects(plan.effects, scene, registry, bodies, plan.reference, mass, state, plan.told, ramps)


def _needs(model: Model, scene: Scene) -> None:
    """Fill the numbers that laws need by name from here on."""
    pairs: Any = () if model.contact is None else model.contact.pairs
    needing = [f for f in model.forces if f.body.material.needs]
    passes = [(number, one) for number, pair in enumerate(pairs) for one in (pair, pair.points) if one is not None]
    sliding = [(number, one) for number, one in passes if one.sliding is not None and one.sliding.varies]
    store: Any = getattr(model.contact, "store", None)
    pressing = None if store is None else store.memory
    if not needing and not sliding and pressing is None:
        return
    from contactlab.model.loading.scene_fields import SceneFields

    fields = SceneFields(scene, model.timing.ramps)
    model.needs = tuple(fields.filling(forces, model.reference) for forces in needing)
    for number, pair in sliding:
        points = np.tile(model.reference[pair.slave.nodes], (pair.rows_per_node, 1))
        fields.give(pair.sliding, points, f"contacts.{number}.friction")
        if "traction" in pair.sliding.law.needs and not pair.at_corners:
            from contactlab.model.contact.traction_behind import TractionBehind

            behind = TractionBehind((pair,), model.forces, model.position, pair.own.stop)
            pair.sliding.tractions = partial(behind.values, pair.own)
    if pressing is not None:
        fields.give(pressing, pressing.points, "contacts.0.enforcement")
        store.begin()


# --- state --------------------------------------------------------------------------------------


def _shapes(plan: _Plan) -> Mapping[str, tuple[int, ...]]:
    nodes, integrator, timing = len(plan.reference), plan.integrator, plan.timing
    shapes: dict[str, tuple[int, ...]] = {"clock": (3,), "displacement": (nodes, 2)}
    if integrator.inertia:
        shapes["velocity"] = (nodes, 2)
    if timing.relaxation and timing.damping:
        shapes["drift"] = (nodes, 2)
    shapes |= {"internal_force": (nodes, 2), "reaction": (nodes, 2), "work": (len(WORK),)}
    if plan.contacts:
        from contactlab.model.contact.plan import contact_shapes

        shapes |= contact_shapes(plan.contacts, nodes, integrator)
    shapes |= {f"history.{body.name}": body.history_shape() for body in plan.bodies if body.material.history_size}
    shapes |= {f"effects.{i}": (len(effect.memory), nodes) for i, effect in enumerate(plan.effects) if effect.memory}
    if integrator.control() is not None:
        shapes["step_error"] = (2,)
    return shapes | dict(integrator.memory(nodes))


def _model_class(integrator: Integrator) -> type[Model]:
    if isinstance(integrator, ExplicitIntegrator):
        return ExplicitModel
    from contactlab.model.implicit_model import ImplicitModel

    return ImplicitModel


def _bind(
    body: Body,
    threads: int,
    first_thread: int,
    reference: Floats,
    position: Floats,
    increment: Floats | None,
    state: State,
    explicit: bool,
) -> BodyForces:
    geometry, field = {
        "small": (reference, state["displacement"]),
        "finite": (position, reference),
        "rate": (position, increment),
    }[body.material.kinematics]
    assert field is not None
    name = f"history.{body.name}"
    history = state[name] if name in state else np.zeros(0)
    shape = (reference, state["displacement"])
    trial = None if explicit else np.zeros_like(history)
    force = state["internal_force"]
    return BodyForces(body, geometry, field, force, history, trial, shape, threads, first_thread)


def _initial_velocity(
    scene: Scene, bodies: tuple[Body, ...], reference: Floats, mass: Floats, state: State, told: list[RunWarning]
) -> None:
    for body, spec in zip(bodies, scene.bodies.values(), strict=True):
        if "velocity" not in state:
            _refuse_motion(scene, body.name, spec)
            continue
        own = slice(body.first, body.first + body.count)
        state["velocity"][own] = spec.velocity
        if spec.profile is not None:
            where, nodes = scene.where(f"bodies.{body.name}.profile"), np.arange(own.start, own.stop, dtype=np.int32)
            profile = of_nodes(spec.profile, scene.registry, where)
            at = profile.at(reference)
            tell_unresolved(profile, (body,), nodes, at, where, told)
            state["velocity"][own] *= profile.values(at[own])[:, None]
        if spec.spin:
            arm = reference[own] - mass[own] @ reference[own] / mass[own].sum()
            state["velocity"][own] += spec.spin * np.stack([-arm[:, 1], arm[:, 0]], axis=1)


def _refuse_motion(scene: Scene, name: str, spec: SceneBody) -> None:
    """Raise SceneError for a body with an initial motion in statics."""
    for key in ("velocity", "spin"):
        if np.any(getattr(spec, key)):
            raise SceneError(
                "nothing moves by itself in statics: equilibrium knows no initial motion",
                where=scene.where(f"bodies.{name}.{key}"), got=getattr(spec, key), allowed="0, or not written",
                hint=f"take {key} out, or use an integrator with inertia (central-difference, implicit-dynamics)",
            )  # fmt: skip
