"""Scene and registry in, model out: the one place where plugin components meet, and where they are checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from contactlab.api import WORK, Effect, ExplicitIntegrator, Floats, Integrator, Ints, NormalLaw, RunWarning, State
from contactlab.errors import SceneError
from contactlab.model.bodies.body import NO_JOINTS, Body, BodyForces, Joints, RigidSurface, positions_of
from contactlab.model.bodies.build_bodies import build_bodies, masses_of
from contactlab.model.bodies.thread_blocks import in_order
from contactlab.model.history import history_of
from contactlab.model.loading.effect_rates import effect_rates
from contactlab.model.loading.held_bodies import check_supported
from contactlab.model.loading.load_profile import of_nodes
from contactlab.model.loading.node_profiles import tell_unresolved
from contactlab.model.loading.ramps import RampTime
from contactlab.model.loading.supports import plan_supports
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
        return _built(scene, registry)


def _built(scene: Scene, registry: Registry) -> Model:
    check_sizes(scene, registry)
    integrator = registry.make("integrator", scene.integrator, scene.where("integrator"))
    model_class = _model_class(integrator)
    bodies = build_bodies(scene, registry)
    check_meshed_size(scene, registry, bodies)
    rigid = _rigid_surfaces(scene, bodies)
    plans, bodies = _contact_plans(scene, registry, bodies, rigid, integrator)
    if scene.loads and any(isinstance(p.enforcement, NormalLaw) and "traction" in p.enforcement.needs for p in plans):
        from contactlab.model.contact.traction_behind import refuse_loads

        refuse_loads(plans, scene, bodies)
    reference = positions_of(bodies, rigid)
    mass = masses_of(bodies, rigid) if integrator.inertia else np.zeros(0)
    told: list[RunWarning] = []
    supports = plan_supports(scene, bodies, rigid, reference, told)
    check_supported(scene, bodies, supports, integrator)
    made = tuple(
        registry.make("effect", spec, scene.where(f"effects.{number}")) for number, spec in enumerate(scene.effects)
    )
    enforcements = {plan.name: plan.enforcement for plan in plans}
    history = history_of(scene, bodies, enforcements, made, integrator)
    timing = find_timing(
        scene, bodies, reference, mass, supports, integrator, history, lambda: _joints(plans, reference)
    )
    prescribed = supports.bind(timing.ramps)
    if scene.contacts:
        from contactlab.model.loading.approach import check_approach

        check_approach(scene, bodies, rigid, reference, prescribed, timing.last)
    contact_shapes = _contact_shapes(plans, len(reference), integrator)
    state = State(_shapes(len(reference), bodies, integrator, contact_shapes, made, timing))
    position = reference.copy()
    increment = np.zeros_like(reference) if any(b.material.kinematics == "rate" for b in bodies) else None
    # the work of all bodies, distributed to the threads one body after the other
    arrays = (reference, position, increment, state, model_class.explicit)
    bound: list[BodyForces] = []
    for body in bodies:
        bound.append(_bind(body, scene.threads, sum(len(before.blocks) for before in bound), *arrays))
    forces = tuple(bound)
    _initial_velocity(scene, bodies, reference, mass, state, told)
    driven = any(supports.moving) or bool(scene.loads or scene.effects)
    contact = _contact(
        plans, bodies=bodies, forces=forces, reference=reference, position=position, state=state, mass=mass,
        held=prescribed.dof, ramp=timing.ramp, driven=driven,
    )  # fmt: skip
    split = None
    if scene.record.contact_work and contact is not None:
        from contactlab.contact.work_split import split_work

        split = split_work(contact, integrator, state, reference, scene.where("record.contact_work"))
    effects = _effects(made, scene, registry, bodies, rigid, reference, state, told, timing.ramps)
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
        split=split,
        state=state,
        integrator=integrator,
        bodies=bodies,
        forces=forces,
        timing=timing,
        history=history,
        updates=in_order(calls, colours, [thread for body in forces for thread in body.block_threads], scene.threads),
        loading=Loading(supports.sets, (*loads, *effects), effects),
        increment=increment,
    )
    model.warnings.add(*timing.told, *told)
    _needs(model, scene)
    model.start.mirror = _mirror(scene, bodies, reference)
    model.internal_force(0.0)
    if model.explicit and effects:
        size, times = float(np.ptp(reference, axis=0).max()), (0.0, timing.last)
        rates = effect_rates(effects, state, mass, size, model.stable_step(), times)
        model.loading = replace(model.loading, rates=rates)
    if model.explicit and any(plan.start.overlap == "ramp" for plan in plans):
        from contactlab.model.contact.initial_gap import check_ramp_steps

        check_ramp_steps(plans, timing.ramp, scene.time.step or model.step_within(scene.time.fraction))
    return model


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
    if any(map(by_energy, plans)):
        from contactlab.model.contact.potential_start import opened

        return opened(bodies, rigid, plans)
    return plans, bodies


def _contact_shapes(plans: tuple[Any, ...], *of: Any) -> Mapping[str, tuple[int, ...]]:
    if not plans:
        return {}
    from contactlab.model.contact.plan import contact_shapes

    return contact_shapes(plans, *of)


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


def _effects(
    made: tuple[Effect, ...],
    scene: Scene,
    registry: Registry,
    bodies: tuple[Body, ...],
    rigid: tuple[RigidSurface, ...],
    reference: Floats,
    state: State,
    told: list[RunWarning],
    ramps: RampTime,
) -> Any:
    if not made:
        return ()
    from contactlab.model.loading.effects import build_effects

    mass = partial(masses_of, bodies, rigid)
    return build_effects(made, scene, registry, bodies, reference, mass, state, told, ramps)


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


def _shapes(
    nodes: int,
    bodies: tuple[Body, ...],
    integrator: Integrator,
    contact: Mapping[str, tuple[int, ...]],
    effects: tuple[Effect, ...],
    timing: Timing,
) -> Mapping[str, tuple[int, ...]]:
    shapes: dict[str, tuple[int, ...]] = {"clock": (3,), "displacement": (nodes, 2)}
    if integrator.inertia:
        shapes["velocity"] = (nodes, 2)
    if timing.relaxation and timing.damping:
        shapes["drift"] = (nodes, 2)
    shapes |= {"internal_force": (nodes, 2), "reaction": (nodes, 2), "work": (len(WORK),)}
    shapes |= contact
    shapes |= {f"history.{body.name}": body.history_shape() for body in bodies if body.material.history_size}
    shapes |= {f"effects.{i}": (len(effect.memory), nodes) for i, effect in enumerate(effects) if effect.memory}
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
