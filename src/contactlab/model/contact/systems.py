"""Contacts at work: the pairs of all plans, in the system for their enforcement and the integrator."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from contactlab.api import Enforcement, Floats, Ints, NormalLaw, State
from contactlab.api.arrays import Flags
from contactlab.contact.corner_pair import CornerPair, CornerPoints
from contactlab.contact.corners import Corners
from contactlab.contact.explicit_system import ContactSystem
from contactlab.contact.operator_pair import OperatorPair
from contactlab.contact.pair import ContactPair, start_distances
from contactlab.contact.start_gaps import ZeroStart
from contactlab.errors import SceneError
from contactlab.model.bodies.body import Body, BodyForces
from contactlab.model.contact.checks import refuse_held_slave
from contactlab.model.contact.initial_gap import facet_overlap, ramped_overlap, refuse_overlap
from contactlab.model.contact.plan import ContactPlan, all_passes, by_energy

if TYPE_CHECKING:
    from contactlab.contact.implicit_system import ImplicitContactSystem


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
    consistent = follows_gaps(enforcement, motion="velocity" in state, smooth=any(plan.smooth for plan in plans))
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
        assert isinstance(held_at, OperatorPair)
        assert plan.corners is not None
        held_at.points = points = cast("CornerPair", plan.pair(reference, first, immobile))
        held_at.corners = points.corners = Corners(held_at, plan.corners)
        return points
    if not plan.second:
        refuse_held_slave(plan.slave, immobile, plan.sides[0], plan.where)
    if by_energy(plan):
        from contactlab.model.contact.potential_start import begin_open, what_lies_behind

        pair = plan.pair(reference, first, immobile, what_lies_behind(plan, around.bodies, reference))
        begin_open(plan, pair, reference)
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
        mass = around.mass
        densities = [sum(length_over_mass(side, reference, mass) for side in (p.slave, p.master)) for p in pairs]
        if half:
            from contactlab.contact.half_passes import HalfPassContactSystem

            return HalfPassContactSystem(pairs, store, state, densities)
        from contactlab.contact.pressure_system import PressureContactSystem

        return PressureContactSystem(pairs, store, state, densities)
    system: ImplicitContactSystem
    if half:
        from contactlab.contact.half_passes import HalfPassResponse, HalfPassSystem

        system = HalfPassSystem(pairs, HalfPassResponse(law, store.stiffness, pairs), state, time, follows_gaps=False)
    else:
        from contactlab.contact.implicit_system import ImplicitContactSystem
        from contactlab.contact.pressure_response import MeanPressureResponse, PressureResponse

        moves = "velocity" in state and not any(plan.smooth for plan in plans)
        response = (
            MeanPressureResponse(law, store.stiffness, store.start, memory)
            if moves
            else PressureResponse(law, store.stiffness, memory)
        )
        system = ImplicitContactSystem(pairs, response, state, time, follows_gaps=False)
        store.follows_steps = moves
    system.store = store
    return system


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
    return TractionContactSystem(linearised, response, around.state, time, follows_gaps=False)


def follows_gaps(enforcement: Enforcement, *, motion: bool, smooth: bool) -> bool:
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
