"""From the contacts of a scene to plans: their plugin components and surfaces, and their needs of each other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from contactlab.api import (
    ContactMethod,
    Enforcement,
    ExplicitEnforcement,
    Floats,
    Integrator,
    Ints,
    NormalLaw,
    Potential,
    SegmentContact,
    Surface,
)
from contactlab.contact.corners import corners_of
from contactlab.contact.sliding import rows_of
from contactlab.errors import PartError, SceneError, Where, below
from contactlab.meshing.mesh import split_at_corners, surface_from_edges
from contactlab.model.bodies.body import Body, RigidSurface, positions_of
from contactlab.model.contact.checks import check_facing, check_solid_side, refuse_half_passes
from contactlab.model.contact.systems import ContactPlan, all_passes, by_energy
from contactlab.model.loading.edge_sets import edge_set
from contactlab.parts.registry import Registry
from contactlab.scene.scene import Scene


def plan_contacts(
    scene: Scene, registry: Registry, bodies: tuple[Body, ...], rigid: tuple[RigidSurface, ...], integrator: Integrator
) -> tuple[ContactPlan, ...]:
    """Return every contact of the scene with its plugin components made and checked."""
    positions = positions_of(bodies, rigid)
    plans: list[ContactPlan] = []
    joined = JoinedStretches()
    chains = {surface.name: surface_from_edges(surface.edges) for surface in rigid}
    stiff = {name: positions[chain.nodes[chain.segments]] for name, chain in chains.items()}
    for number, spec in enumerate(scene.contacts):
        where = scene.where(f"contacts.{number}")
        plan = _plan(f"contacts.{number}", spec, where, registry, bodies, rigid, integrator, positions)
        check_solid_side(plan.slave, stiff, spec.targets[1], positions, plan.sides[0], where)
        check_facing(plan.slave, plan.master, positions, plan.sides, where)
        joined.add(plan, where)
        plans.append(plan)
    return tuple(plans)


class JoinedStretches:
    """Stretches of two surfaces joined by contacts: two contacts of the same stretches would press twice."""

    def __init__(self) -> None:
        self.known: list[tuple[ContactPlan, set[tuple[int, int]]]] = []
        self.by_slave: dict[tuple[int, int], list[int]] = {}

    def add(self, plan: ContactPlan, where: Where) -> None:
        """Add a contact. Raises SceneError if another contact joins the same stretches."""
        slave, master = _segments_of(plan.slave), _segments_of(plan.master)
        for own, opposite in ((slave, master), (master, slave)):
            for number in sorted({number for segment in own for number in self.by_slave.get(segment, ())}):
                other, others = self.known[number]
                if opposite & others:
                    raise SceneError(
                        f"{other.name} joins parts of these surfaces already, which would be counted twice",
                        where=where,
                        got=f"{plan.sides[0]} and {plan.sides[1]} next to {other.sides[0]} and {other.sides[1]}",
                        allowed="every stretch of a surface in one contact with the same other surface",
                        hint="take one of the contacts out, or name edge sets that share no edge ([bodies.NAME.sets])",
                    )
        for segment in slave:
            self.by_slave.setdefault(segment, []).append(len(self.known))
        self.known.append((plan, master))


def _segments_of(surface: Surface) -> set[tuple[int, int]]:
    return {(int(a), int(b)) for a, b in surface.nodes[surface.segments]}


def _plan(
    name: str,
    spec: Any,
    where: Where,
    registry: Registry,
    bodies: tuple[Body, ...],
    rigid: tuple[RigidSurface, ...],
    integrator: Integrator,
    positions: Floats,
) -> ContactPlan:
    slave_key, master_key = ("master", "slave") if spec.swap else ("slave", "master")
    slave, master = spec.targets
    enforcement_spec = spec.enforcement or integrator.enforcement()
    enforcement = registry.make("enforcement", enforcement_spec, below(where, "enforcement"))
    if not isinstance(enforcement, (integrator.needs, NormalLaw)):
        raise PartError(
            f"the integrator cannot work with this enforcement, needed: kind {integrator.needs.__name__}",
            where=below(where, "enforcement"),
            got=enforcement_spec,
            allowed=f'"{integrator.default_enforcement}" (what is used when nothing is written)',
        )
    if isinstance(enforcement, NormalLaw) and "traction" in enforcement.needs:
        from contactlab.model.contact.traction_behind import refuse_integrator

        refuse_integrator(integrator, enforcement_spec, where)
    algorithm = registry.make("contact", spec.algorithm, below(where, "algorithm"))
    friction = registry.make("friction", spec.friction, below(where, "friction")) if spec.friction else None
    if isinstance(enforcement, NormalLaw) and "slip_rate" in enforcement.needs and friction is None:
        raise PartError(
            "this enforcement follows the slip, which is measured in contacts with friction",
            where=below(where, "friction"), got="none", allowed="a friction law, with a coefficient of 0 if need be",
        )  # fmt: skip
    explicit = issubclass(integrator.needs, ExplicitEnforcement)
    if algorithm.explicit_only and not explicit:
        raise PartError(
            "this contact algorithm says that it is for explicit integrators alone (explicit_only)",
            where=below(where, "algorithm"),
            got=spec.algorithm,
            allowed="with an implicit integrator: algorithms that do not say so",
        )
    if isinstance(algorithm, Potential):
        from contactlab.model.contact.potential_start import refuse_potential

        refuse_potential(algorithm, spec, integrator, friction, where)
    whole = (
        _surface(slave, bodies, rigid, below(where, slave_key)),
        _surface(master, bodies, rigid, below(where, master_key)),
    )
    sides = split_at_corners(whole[0], positions, spec.corner), whole[1]
    exchanged: tuple[Surface, ...] = ()
    half_pass = algorithm.half_pass()
    if half_pass is not None:
        stiff = ", ".join(name for name in (*slave, *master) if name in {surface.name for surface in rigid})
        refuse_half_passes(spec, enforcement, friction, stiff, where)
        algorithm, exchanged = half_pass, (split_at_corners(whole[1], positions, spec.corner), whole[0])
    if spec.smooth:
        from contactlab.model.contact.smooth import refuse_smooth

        refuse_smooth(algorithm, spec, sides, enforcement, where)
    return ContactPlan(
        name,
        spec.name or name,
        algorithm,
        *sides,
        friction,
        enforcement,
        spec.sides,
        spec.start,
        where,
        explicit,
        spec.smooth,
        exchanged=exchanged,
        corners=_corners(algorithm, enforcement, sides[1], positions) if not spec.smooth else None,
    )


def _corners(algorithm: ContactMethod, enforcement: Enforcement, master: Surface, positions: Floats) -> Ints | None:
    """Return corners of the master, for mortars with multipliers."""
    if not isinstance(algorithm, SegmentContact) or isinstance(enforcement, NormalLaw):
        return None
    found = corners_of(master, positions)
    return found if len(found) else None


def _surface(
    names: tuple[str, ...], bodies: tuple[Body, ...], rigid: tuple[RigidSurface, ...], where: Where
) -> Surface:
    """Return one surface of all the edge sets and rigid surfaces named; several make a surface of several chains."""
    stiff = {surface.name: surface.edges for surface in rigid}
    edges = [stiff[name] if name in stiff else edge_set(bodies, name, where)[1] for name in names]
    if len({some.shape[1] for some in edges}) > 1:
        raise SceneError(
            "these edge sets have different numbers of nodes per edge",
            where=where,
            got=", ".join(f"{name}: {some.shape[1]}" for name, some in zip(names, edges, strict=True)),
            allowed="elements of one order along a contact surface",
            hint="write a contact for each of them",
        )
    try:
        return surface_from_edges(np.concatenate(edges))
    except ValueError as problem:
        raise SceneError(
            f"not a contact surface: {problem}",
            where=where,
            got=", ".join(names),
            allowed="edges that follow each other, in chains that do not meet",
        ) from problem


def contact_shapes(plans: tuple[ContactPlan, ...], nodes: int, integrator: Integrator) -> Mapping[str, tuple[int, ...]]:
    """Return state fields of the contacts; nothing tangential without friction."""
    rows, plans = 2 if any(plan.friction is not None for plan in plans) else 1, all_passes(plans)
    shapes: dict[str, tuple[int, ...]] = {"multipliers": (rows, sum(plan.slots for plan in plans))}
    shapes |= {"multipliers_before": shapes["multipliers"][1:], "contact_force": (nodes, 2)}
    if not integrator.inertia:
        shapes |= {"release": shapes["multipliers"][1:], "release_pace": (2,)}
    if plans[0].explicit and isinstance(plans[0].enforcement, NormalLaw):
        shapes["contact_slope"] = (3, len(plans))
    law = plans[0].enforcement
    if isinstance(law, NormalLaw) and "traction" not in law.needs and law.named():
        from contactlab.contact.pressure_memory import kept_by

        shapes["pressure_law"] = (len(kept_by(law)), shapes["multipliers"][1])
    for plan in plans:
        if plan.algorithm.memory_size:
            shapes[f"memory.{plan.name}"] = (plan.algorithm.memory_size, len(plan.slave.nodes))
        if by_energy(plan) and plan.friction is not None:
            shapes[f"friction.{plan.name}"] = (len(plan.slave.nodes) + len(plan.master.nodes), 2)
        elif plan.friction is not None and plan.friction.varies:
            shapes[f"friction.{plan.name}"] = (rows_of(plan.friction), plan.slots)
    return shapes
