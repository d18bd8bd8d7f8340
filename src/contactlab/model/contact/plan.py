"""Contacts: which parts and surfaces they join, what they need of each other, and their state."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from contactlab.api import (
    ContactMethod,
    Enforcement,
    ExplicitEnforcement,
    Floats,
    FrictionLaw,
    Integrator,
    Ints,
    NormalLaw,
    Potential,
    SegmentContact,
    State,
    Surface,
)
from contactlab.api.arrays import Flags
from contactlab.contact.contact_pairs import contact_pair
from contactlab.contact.corner_pair import CornerPair, CornerPoints
from contactlab.contact.corners import Corners, corners_of
from contactlab.contact.explicit_system import ContactSystem
from contactlab.contact.operator_pair import OperatorPair
from contactlab.contact.pair import ContactPair, start_distances
from contactlab.contact.sliding import rows_of
from contactlab.contact.start_gaps import ZeroStart
from contactlab.errors import PartError, SceneError, below
from contactlab.meshing.mesh import split_at_corners, surface_from_edges
from contactlab.model.bodies.body import Body, BodyForces, positions_of
from contactlab.model.contact.checks import JoinedStretches, check_facing, check_solid_side, refuse_held_slave
from contactlab.model.contact.initial_gap import facet_overlap, ramped_overlap, refuse_overlap
from contactlab.model.loading.edge_sets import edge_set

if TYPE_CHECKING:
    from contactlab.contact.implicit_system import ImplicitContactSystem
    from contactlab.errors import Where
    from contactlab.model.loading.rigid import RigidSurface
    from contactlab.parts.registry import Registry
    from contactlab.scene.scene import Scene


@dataclass(frozen=True)
class ContactPlan:
    """One contact before any array exists. `name` is "contacts.0"; `label` what the scene calls it.

    sides  slave and master as they act, in words
    start  what is done about an overlap before the run, as in the scene
    explicit  whether it is for an explicit integrator
    smooth  whether gaps are those between curves through the nodes
    opened [mm] by how much surfaces that touched were opened, for a potential that needs room
    exchanged  slave and master of the pass in which the sides are exchanged, of two half passes; () of one pass
    second  whether this is that pass, or one of points at corners
    corners  (c,) nodes of the master that are corners, of a mortar that is held at them
    """

    name: str
    label: str
    algorithm: ContactMethod
    slave: Surface
    master: Surface
    friction: FrictionLaw | None
    enforcement: Enforcement
    sides: tuple[str, str]
    start: Any
    where: Where
    explicit: bool
    smooth: bool

    opened: float = 0.0
    exchanged: tuple[Surface, ...] = ()
    second: bool = False
    corners: Ints | None = None

    @property
    def slots(self) -> int:
        """Number of multipliers that the contact can have."""
        return self.algorithm.rows_per_node * len(self.slave.nodes)

    def pair(self, positions: Floats, first_slot: int, immobile: Flags, behind: Any = None) -> ContactPair:
        """The pair at work. `immobile` (N,) marks nodes that cannot move; `behind` is for potentials."""
        sides, fixed = (self.slave, self.master), immobile[self.slave.nodes]
        pair = contact_pair(self.name, self.algorithm, sides, positions, first_slot, self.friction, fixed, behind)
        pair.half, pair.second = bool(self.exchanged), self.second
        if self.smooth:
            from contactlab.model.contact.smooth import make_smooth

            make_smooth(pair, positions)
        return pair


def all_passes(plans: tuple[ContactPlan, ...]) -> tuple[ContactPlan, ...]:
    """The contacts, after them points at corners of their masters, and the second ones of two half passes."""
    second = [
        replace(
            p, name=f"{p.name}.exchanged", slave=p.exchanged[0], master=p.exchanged[1], sides=p.sides[::-1], second=True
        )
        for p in plans
        if p.exchanged
    ]
    return (*plans, *(_points(plan) for plan in plans if plan.corners is not None), *second)


def _points(plan: ContactPlan) -> ContactPlan:
    """The pass of points at corners of the master."""
    return replace(
        plan, name=f"{plan.name}.corners", algorithm=CornerPoints(), slave=plan.master, master=plan.slave,
        sides=plan.sides[::-1], second=True,
    )  # fmt: skip


def by_energy(plan: ContactPlan) -> bool:
    """Whether the forces of a contact come from a potential."""
    return isinstance(plan.algorithm, Potential)


def plan_contacts(
    scene: Scene, registry: Registry, bodies: tuple[Body, ...], rigid: tuple[RigidSurface, ...], integrator: Integrator
) -> tuple[ContactPlan, ...]:
    """Every contact of the scene with its parts made and checked."""
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
            f"the integrator cannot work with this enforcement: it needs one of kind {integrator.needs.__name__}",
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
        from contactlab.model.contact.half_passes import refuse_half_passes

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
    """Corners of the master, for mortars with multipliers."""
    if not isinstance(algorithm, SegmentContact) or isinstance(enforcement, NormalLaw):
        return None
    found = corners_of(master, positions)
    return found if len(found) else None


def _surface(
    names: tuple[str, ...], bodies: tuple[Body, ...], rigid: tuple[RigidSurface, ...], where: Where
) -> Surface:
    """One surface of all the edge sets and rigid surfaces named; several make a surface of several chains."""
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


def contact_shapes(plans: tuple[ContactPlan, ...], nodes: int) -> Mapping[str, tuple[int, ...]]:
    """State fields of the contacts; nothing tangential without friction."""
    if not plans:
        return {}
    rows, plans = 2 if any(plan.friction is not None for plan in plans) else 1, all_passes(plans)
    shapes: dict[str, tuple[int, ...]] = {"multipliers": (rows, sum(plan.slots for plan in plans))}
    shapes |= {"multipliers_before": shapes["multipliers"][1:], "contact_force": (nodes, 2)}
    if plans[0].explicit and isinstance(plans[0].enforcement, NormalLaw):
        shapes["contact_slope"] = (len(plans),)
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


def build_contact(
    plans: tuple[ContactPlan, ...],
    bodies: tuple[Body, ...],
    reference: Floats,
    fixed_dof: Ints,
    state: State,
    mass: Floats,
    ramp_time: float,
    driven: bool,
    forces: tuple[BodyForces, ...],
    position: Floats,
) -> Any:
    """The contact system that the enforcement works with, None where the scene declares no contact.

    driven    whether supports, loads or effects put energy in
    forces    the work of the bodies, and position (N, 2) [mm] where they are, both of the run
    """
    if not plans:
        return None
    _one_enforcement(plans)
    plans = all_passes(plans)
    held = np.zeros(2 * len(reference), np.bool_)
    held[fixed_dof] = True
    immobile = np.asarray(held.reshape(-1, 2).all(axis=1))
    enforcement: Any = plans[0].enforcement
    if any(map(by_energy, plans)):
        from contactlab.model.contact.potential_start import begin_open, what_lies_behind
    explicit = plans[0].explicit
    # steps that iterate look for a state at their end, explicit ones go on from where they are
    time = state["clock"] if explicit else np.zeros(1)
    pairs: list[ContactPair] = []
    first = 0
    for plan in plans:
        if isinstance(plan.algorithm, CornerPoints):
            held_at = next(pair for pair in pairs if plan.name == f"{pair.name}.corners")
            pairs.append(_points_beside(held_at, plan, reference, first, immobile))
            first += plan.slots
            continue
        if not plan.second:
            refuse_held_slave(plan.slave, immobile, plan.sides[0], plan.where)
        behind = what_lies_behind(plan, bodies, reference) if by_energy(plan) else None
        pair = plan.pair(reference, first, immobile, behind)
        if by_energy(plan):
            begin_open(plan, pair, reference)
        if plan.start.overlap == "ramp":
            pair.start_gaps = ramped_overlap(pair, time, plan.start.duration or ramp_time, reference)
        elif plan.start.gap == "zero":
            pair.start_gaps = ZeroStart(start_distances(pair, reference))
        refuse_overlap(plan, pair, bodies, reference)
        if pair.start_gaps is None and "velocity" in state and not pair.by_energy:
            # statics go to the end, where the overlap counts; what moves freely keeps its energy, and the overlap
            pair.start_gaps = facet_overlap(pair, time, ramp_time if driven else math.inf, reference)
        pairs.append(pair)
        first += plan.slots
    if isinstance(enforcement, NormalLaw):
        return _pressure_system(
            plans, tuple(pairs), enforcement, bodies, forces, reference, position, mass, state, time
        )
    consistent = follows_gaps(enforcement, motion="velocity" in state, smooth=any(plan.smooth for plan in plans))
    if not explicit:
        from contactlab.contact.implicit_system import ImplicitContactSystem

        return ImplicitContactSystem(tuple(pairs), enforcement, state, time, consistent)
    if not consistent:
        return ContactSystem(tuple(pairs), enforcement, state)
    from contactlab.contact.consistent_system import ConsistentContactSystem

    return ConsistentContactSystem(tuple(pairs), enforcement, state)


def _points_beside(
    pair: ContactPair, plan: ContactPlan, reference: Floats, first_slot: int, immobile: Flags
) -> ContactPair:
    """The pair of points at corners of the master of a pair, which is held at them."""
    assert isinstance(pair, OperatorPair)
    assert plan.corners is not None
    pair.points = points = cast("CornerPair", plan.pair(reference, first_slot, immobile))
    pair.corners = points.corners = Corners(pair, plan.corners)
    return points


def _pressure_system(
    plans: tuple[ContactPlan, ...],
    pairs: tuple[ContactPair, ...],
    law: NormalLaw,
    bodies: tuple[Body, ...],
    forces: tuple[BodyForces, ...],
    reference: Floats,
    position: Floats,
    mass: Floats,
    state: State,
    time: Floats,
) -> Any:
    """The contact system of a normal law."""
    from contactlab.contact.pressure_response import PressureStore
    from contactlab.model.contact.cells_behind import in_series, length_over_mass, stiffness_behind

    if "traction" in law.needs:
        return _traction_system(plans, pairs, law, bodies, forces, reference, position, state, time)
    stiffness = []
    for pair in pairs:
        slave, master = (stiffness_behind(side, bodies, reference) for side in (pair.slave, pair.master))
        # what overlaps alike in both half passes is pressed alike
        own = np.full(len(slave), 1.0 / (1.0 / slave).mean()) if pair.half else slave
        stiffness.append(np.tile(in_series(own, master), pair.rows_per_node))
    half = any(pair.half for pair in pairs)
    memory = None
    if law.named():
        from contactlab.contact.pressure_memory import PressureMemory

        memory = PressureMemory(law, pairs, state, reference)
    store = PressureStore(law, pairs, np.concatenate(stiffness), reference, memory)
    if plans[0].explicit:
        densities = [sum(length_over_mass(side, reference, mass) for side in (p.slave, p.master)) for p in pairs]
        if half:
            from contactlab.model.contact.half_passes import HalfPassContactSystem

            return HalfPassContactSystem(pairs, store, state, densities)
        from contactlab.model.contact.pressure_system import PressureContactSystem

        return PressureContactSystem(pairs, store, state, densities)
    system: ImplicitContactSystem
    if half:
        from contactlab.contact.half_passes import HalfPassResponse, HalfPassSystem

        system = HalfPassSystem(pairs, HalfPassResponse(law, store.stiffness, pairs), state, time, follows_gaps=False)
    else:
        from contactlab.contact.implicit_system import ImplicitContactSystem
        from contactlab.contact.pressure_response import PressureResponse

        response = PressureResponse(law, store.stiffness, memory)
        system = ImplicitContactSystem(pairs, response, state, time, follows_gaps=False)
        system.remembers = response if memory is not None else None
    system.store = store
    return system


def _traction_system(
    plans: tuple[ContactPlan, ...],
    pairs: tuple[ContactPair, ...],
    law: NormalLaw,
    bodies: tuple[Body, ...],
    forces: tuple[BodyForces, ...],
    reference: Floats,
    position: Floats,
    state: State,
    time: Floats,
) -> Any:
    """The contact system of a normal law that follows the stress of the slave's cells."""
    from contactlab.contact.traction_system import TractionContactSystem, TractionResponse
    from contactlab.model.contact.cells_behind import stiffness_behind
    from contactlab.model.contact.traction_behind import TractionBehind, refuse_slave

    for plan in plans:
        refuse_slave(plan, bodies)
    stiffness = [np.tile(stiffness_behind(p.slave, bodies, reference), p.rows_per_node) for p in pairs]
    behind = TractionBehind(pairs, forces, position, sum(len(one) for one in stiffness))
    response, linearised = TractionResponse(law, np.concatenate(stiffness), behind), cast("Any", pairs)
    return TractionContactSystem(linearised, response, state, time, follows_gaps=False)


def follows_gaps(enforcement: Enforcement, *, motion: bool, smooth: bool) -> bool:
    """Whether contact forces act along the derivatives of the gaps: what the key `forces` means in a run.

    "conjugate" and "published" are older names. "auto" is "consistent" in steps in time, which these forces let keep
    energy, unless gaps are those of `smooth` surfaces.
    """
    return enforcement.forces in ("consistent", "conjugate") or (enforcement.forces == "auto" and motion and not smooth)


def _one_enforcement(plans: tuple[ContactPlan, ...]) -> None:
    enforcements = {plan.enforcement for plan in plans}
    if len(enforcements) > 1:
        raise SceneError(
            "all contacts of a scene share one enforcement",
            where=plans[-1].where,
            got=", ".join(sorted(map(str, enforcements))),
            allowed="the same one for every contact",
        )
