"""Contacts: from plans to pairs, and the system of all pairs for their enforcement and the integrator."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, cast

import numpy as np

from contactlab.api import (
    ContactAlgorithm,
    ContactMethod,
    Enforcement,
    Floats,
    FrictionLaw,
    GapAlgorithm,
    Ints,
    NormalLaw,
    Potential,
    State,
    Surface,
)
from contactlab.api.arrays import Flags
from contactlab.contact.corner_pair import CornerPair, CornerPoints
from contactlab.contact.cornered_pair import CorneredPair
from contactlab.contact.explicit_system import ContactSystem
from contactlab.contact.gap_pair import GapPair
from contactlab.contact.operator_pair import OperatorPair
from contactlab.contact.pair import ContactPair, start_distances
from contactlab.contact.start_gaps import ZeroStart
from contactlab.errors import SceneError, Where
from contactlab.model.bodies.body import Body, BodyForces
from contactlab.model.contact.checks import refuse_held_slave
from contactlab.model.contact.initial_gap import facet_overlap, ramped_overlap, refuse_overlap


@dataclass(frozen=True)
class ContactPlan:
    """A contact before any array exists. `name` is "contacts.0"; `label` its name in the scene.

    sides  slave and master as they act, in words
    start  treatment of an overlap before the run, as in the scene
    explicit  True for an explicit integrator
    smooth  True if gaps are measured between curves through the nodes
    opened [mm] opening of surfaces that touched, for a potential that needs room
    exchanged  slave and master of the pass with exchanged sides, of two half passes; () of one pass
    second  True for this pass, and for a pass of points at corners
    corners  (c,) corner nodes of the master, of a mortar that holds them
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
        """Return the pair at work. `immobile` (N,) marks nodes that cannot move; `behind` is for potentials."""
        sides, fixed = (self.slave, self.master), immobile[self.slave.nodes]
        pair = contact_pair(
            self.name, self.algorithm, sides, positions, first_slot, self.friction, fixed, behind,
            corners=self.corners is not None, smooth=self.smooth,
        )  # fmt: skip
        pair.half, pair.second = bool(self.exchanged), self.second
        return pair


def contact_pair(
    name: str,
    algorithm: ContactMethod,
    sides: tuple[Surface, Surface],
    reference: Floats,
    first_slot: int,
    friction: FrictionLaw | None,
    fixed: Flags,
    behind: tuple[Floats, Floats] | None = None,
    *,
    corners: bool = False,
    smooth: bool = False,
) -> ContactPair:
    """Return a pair of slave and master at work; `fixed` (m,) marks slave nodes that cannot move.

    corners  True for a mortar that is to hold corners of the master; smooth: True for gaps between smooth surfaces
    Potentials get the material `behind` each node (N,): a modulus [MPa], and modulus over cell depth [MPa/mm].
    """
    if isinstance(algorithm, Potential):
        from contactlab.contact.potential_pair import PotentialPair

        ones = np.ones(len(reference))
        return PotentialPair(name, algorithm, sides, reference, first_slot, friction, behind or (ones, ones))
    if isinstance(algorithm, CornerPoints):
        return CornerPair(name, algorithm, *sides, reference, first_slot, friction)
    if isinstance(algorithm, GapAlgorithm):
        return GapPair(name, algorithm, *sides, reference, first_slot, friction)
    assert isinstance(algorithm, ContactAlgorithm)
    if algorithm.points_press:
        from contactlab.contact.points_pair import PointsPair

        return PointsPair(name, algorithm, *sides, reference, first_slot, friction, fixed)
    if smooth:
        from contactlab.contact.smooth_pair import SmoothPair

        return SmoothPair(name, algorithm, *sides, reference, first_slot, friction, fixed)
    kind = CorneredPair if corners else OperatorPair
    return kind(name, algorithm, *sides, reference, first_slot, friction, fixed)


def all_passes(plans: tuple[ContactPlan, ...]) -> tuple[ContactPlan, ...]:
    """Return the contacts, then points at corners of their masters, and second passes of two half passes.

    Ends of an open chain are corners, too: most masters have points, idle until a corner is pressed.
    """
    second = [
        replace(
            p, name=f"{p.name}.exchanged", slave=p.exchanged[0], master=p.exchanged[1], sides=p.sides[::-1], second=True
        )
        for p in plans
        if p.exchanged
    ]
    return (*plans, *(_points(plan) for plan in plans if plan.corners is not None), *second)


def _points(plan: ContactPlan) -> ContactPlan:
    """Return the pass of points at corners of the master."""
    return replace(
        plan, name=f"{plan.name}.corners", algorithm=CornerPoints(), slave=plan.master, master=plan.slave,
        sides=plan.sides[::-1], second=True,
    )  # fmt: skip


def by_energy(plan: ContactPlan) -> bool:
    """Return whether the forces of a contact come from a potential."""
    return isinstance(plan.algorithm, Potential)


@dataclass(frozen=True)
class Around:
    """The bodies that contacts join: their forces, and positions (N, 2) [mm] at the start and in the run.

    mass    (N,) of the nodes
    held    prescribed degrees of freedom
    ramp    [s] duration of pushing initial overlaps out
    driven  True if supports, loads or effects add energy
    """

    bodies: tuple[Body, ...]
    forces: tuple[BodyForces, ...]
    reference: Floats
    position: Floats
    state: State
    mass: Floats
    held: Ints
    ramp: float
    driven: bool

    @cached_property
    def immobile(self) -> Flags:
        """Nodes (N,) that cannot move at all."""
        held = np.zeros(2 * len(self.reference), np.bool_)
        held[self.held] = True
        return np.asarray(held.reshape(-1, 2).all(axis=1))


def build_contact(plans: tuple[ContactPlan, ...], around: Around) -> Any:
    """Return the contact system for the enforcement."""
    _one_enforcement(plans)
    plans, state = all_passes(plans), around.state
    enforcement: Any = plans[0].enforcement
    explicit = plans[0].explicit
    # iterative steps find a state at their end, explicit steps start from the present state
    time = state["clock"] if explicit else np.zeros(1)
    pairs: list[ContactPair] = []
    for plan in plans:
        pairs.append(_pair(plan, pairs, around, time))
    if isinstance(enforcement, NormalLaw):
        return _pressure_system(plans, tuple(pairs), enforcement, around, time)
    consistent = consistent_forces(enforcement, motion="velocity" in state, smooth=any(plan.smooth for plan in plans))
    if any(pair.by_energy for pair in pairs):
        from contactlab.contact.potential_system import PotentialSystem

        return PotentialSystem(tuple(pairs), enforcement, state, time, consistent)
    if not explicit:
        from contactlab.contact.implicit_system import ImplicitContactSystem

        return ImplicitContactSystem(tuple(pairs), enforcement, state, time, consistent)
    if not consistent:
        return ContactSystem(tuple(pairs), enforcement, state)
    from contactlab.contact.consistent_system import ConsistentContactSystem

    return ConsistentContactSystem(tuple(pairs), enforcement, state)


def _pair(plan: ContactPlan, before: list[ContactPair], around: Around, time: Floats) -> ContactPair:
    """Return the pair of a plan after the pairs `before`, with its uncounted initial gaps."""
    reference, immobile, first = around.reference, around.immobile, sum(pair.slots for pair in before)
    if isinstance(plan.algorithm, CornerPoints):
        held_at = next(pair for pair in before if plan.name == f"{pair.name}.corners")
        points = plan.pair(reference, first, immobile)
        assert isinstance(held_at, CorneredPair)
        assert isinstance(points, CornerPair)
        assert plan.corners is not None
        held_at.hold(plan.corners, points)
        return points
    if not plan.second:
        refuse_held_slave(plan.slave, immobile, plan.sides[0], plan.where)
    if by_energy(plan):
        from contactlab.model.contact.potential_start import begin_open, what_lies_behind

        pair = plan.pair(reference, first, immobile, what_lies_behind(plan, around.bodies, reference))
        begin_open(plan, pair, reference, around.state)
    else:
        pair = plan.pair(reference, first, immobile)
    if plan.start.overlap == "ramp":
        pair.start_gaps = ramped_overlap(pair, time, plan.start.duration or around.ramp, reference)
    elif plan.start.gap == "zero":
        pair.start_gaps = ZeroStart(start_distances(pair, reference))
    refuse_overlap(plan, pair, around.bodies, reference)
    if pair.start_gaps is None and "velocity" in around.state and not pair.by_energy:
        # statics go to the end, with the overlap counted; free motion keeps its energy, and the overlap
        pair.start_gaps = facet_overlap(pair, time, around.ramp if around.driven else math.inf, reference)
    return pair


def _pressure_system(
    plans: tuple[ContactPlan, ...], pairs: tuple[ContactPair, ...], law: NormalLaw, around: Around, time: Floats
) -> Any:
    """Return the contact system of a normal law."""
    from contactlab.contact.pressure_response import PressureStore
    from contactlab.model.contact.cells_behind import in_series, length_over_mass, stiffness_behind

    if "traction" in law.needs:
        return _traction_system(plans, pairs, law, around, time)
    bodies, reference, state = around.bodies, around.reference, around.state
    stiffness = []
    for pair in pairs:
        slave, master = (stiffness_behind(side, bodies, reference) for side in (pair.slave, pair.master))
        # equal overlaps in both half passes get equal pressures
        own = np.full(len(slave), 1.0 / (1.0 / slave).mean()) if pair.half else slave
        stiffness.append(np.tile(in_series(own, master), pair.rows_per_node))
    half = any(pair.half for pair in pairs)
    memory = None
    if law.named():
        from contactlab.contact.pressure_memory import PressureMemory

        memory = PressureMemory(law, pairs, state, reference)
    store = PressureStore(law, pairs, np.concatenate(stiffness), reference, memory)
    if plans[0].explicit:
        densities = np.array([length_over_mass(p.slave, p.master, reference, around.mass) for p in pairs])
        if half:
            from contactlab.contact.half_passes import HalfPassContactSystem

            return HalfPassContactSystem(pairs, store, state, densities)
        from contactlab.contact.pressure_system import PressureContactSystem

        return PressureContactSystem(pairs, store, state, densities)
    if half:
        from contactlab.contact.half_passes import HalfPassResponse, HalfPassSystem

        return HalfPassSystem(pairs, HalfPassResponse(law, store.stiffness, pairs), store, state, time)
    from contactlab.contact.implicit_pressure import ImplicitPressureSystem
    from contactlab.contact.pressure_response import MeanPressureResponse, PressureResponse

    store.follows_steps = "velocity" in state and not any(plan.smooth for plan in plans)
    response = (
        MeanPressureResponse(law, store.stiffness, store.start, memory)
        if store.follows_steps
        else PressureResponse(law, store.stiffness, memory)
    )
    return ImplicitPressureSystem(pairs, response, store, state, time)


def _traction_system(
    plans: tuple[ContactPlan, ...], pairs: tuple[ContactPair, ...], law: NormalLaw, around: Around, time: Floats
) -> Any:
    """Return the contact system of a normal law that follows the stress of the slave's cells."""
    from contactlab.contact.traction_system import TractionContactSystem, TractionResponse
    from contactlab.model.contact.cells_behind import stiffness_behind
    from contactlab.model.contact.traction_behind import TractionBehind, refuse_slave

    for plan in plans:
        refuse_slave(plan, around.bodies)
    stiffness = [np.tile(stiffness_behind(p.slave, around.bodies, around.reference), p.rows_per_node) for p in pairs]
    behind = TractionBehind(pairs, around.forces, around.position, sum(len(one) for one in stiffness))
    response, linearised = TractionResponse(law, np.concatenate(stiffness), behind), cast("Any", pairs)
    return TractionContactSystem(linearised, response, around.state, time, consistent=False)


def consistent_forces(enforcement: Enforcement, *, motion: bool, smooth: bool) -> bool:
    """Return whether contact forces act along the derivatives of the gaps: the meaning of the key `forces` in a run.

    "conjugate" and "published" are older names. "auto" is "consistent" in dynamic steps, in which these forces keep
    energy, unless gaps belong to `smooth` surfaces.
    """
    return enforcement.forces in ("consistent", "conjugate") or (enforcement.forces == "auto" and motion and not smooth)


def _one_enforcement(plans: tuple[ContactPlan, ...]) -> None:
    enforcements = {plan.enforcement for plan in plans}
    if len(enforcements) > 1:
        raise SceneError(
            "all contacts of a scene share one enforcement",
            where=plans[-1].where,
            got=", ".join(sorted(map(str, enforcements))),
            allowed="the same enforcement for every contact",
        )
