"""What one contact looks like at an instant: curve, resultant, penetration, violations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contactlab.api import Floats, Ints, State
from contactlab.kernels.contact.factored_rows import FAR
from contactlab.kernels.contact.penetration import depths, with_midpoints
from contactlab.model.contact.gap_pair import Pair
from contactlab.results.arc_length import arc_length
from contactlab.results.results import ContactCurve


@dataclass(frozen=True)
class ContactReport:
    """Curve and scalars of one contact.

    resultant          (2,) [N] sum of the nodal forces on the slave
    pressure_integral  (2,) [N] integral of pressure and shear over the deformed slave chain
    max_penetration    [mm] of either side's nodes and segment middles into the other side
    penetrating_side   "slave", "master" or ""
    cone_violation     largest of -y_n and |y_t| - bound, over the largest y_n
    complementarity    largest |y_n g| over largest y_n times segment length
    most_negative      lowest multiplier over the highest
    active, sticking   nodes with a force; of these, nodes below their friction bound
    """

    curve: ContactCurve
    resultant: Floats
    pressure_integral: Floats
    max_penetration: float
    penetrating_side: str
    cone_violation: float
    complementarity: float
    most_negative: float
    active: int
    sticking: int

    @property
    def intervals(self) -> list[list[list[float]]]:
        """End points of every stretch of pressed slave nodes, deformed; one ends where its chain ends."""
        c, found = self.curve, []
        pressed = np.flatnonzero(c.nodal_pressure > 0.0)
        apart = (np.diff(pressed) > 1) | (np.diff(c.chain[pressed]) != 0)
        for run in np.split(pressed, np.flatnonzero(apart) + 1):
            if len(run):
                found.append([[float(c.x[k]), float(c.y[k])] for k in (run[0], run[-1])])
        return found


def report_contact(pair: Pair, state: State, reference: Floats, position: Floats) -> ContactReport:
    """Evaluate `pair` at the deformed `position` (N, 2) with the state's multipliers.

    The run goes on with the near list that it had: what is looked at must not change what comes.
    """
    near = pair.near
    try:
        return _report(pair, state, reference, position)
    finally:
        pair.near = near


def _report(pair: Pair, state: State, reference: Floats, position: Floats) -> ContactReport:
    memory = state[f"memory.{pair.name}"].copy() if f"memory.{pair.name}" in state else np.zeros((0, 2))
    pair.update(position, memory)
    pair.measure(position)
    y = state["multipliers"][:, pair.first_slot : pair.first_slot + pair.slots]
    normal_force, tangential_force = y[0], (y[1] if pair.friction is not None else np.zeros_like(y[0]))
    pressure, shear = (
        _between(pair, _per_node(pair, pair.tractions(force))) for force in (normal_force, tangential_force)
    )
    resultant = normal_force @ pair.normals + tangential_force @ _tangents(pair)
    bound = _bound(pair, normal_force)
    largest = max(float(normal_force.max(initial=0.0)), 1e-300)
    gaps = np.where(pair.gaps[:, 0] < FAR, pair.gaps[:, 0], 0.0)
    states = _states(pair, normal_force, tangential_force, bound)
    depth, side = _penetration(pair)
    along = arc_length(reference[pair.slave.nodes], pair.slave.segments)
    curve = ContactCurve(
        s=along.s,
        x=pair.at.slave[:, 0].copy(),
        y=pair.at.slave[:, 1].copy(),
        pressure=pressure,
        shear=shear,
        nodal_pressure=_between(pair, _per_node(pair, _per_length(pair, normal_force))),
        gap=_between(pair, _node_gap(pair)),
        state=_states_between(pair, states),
        chain=along.chain,
    )
    return ContactReport(
        curve=curve,
        resultant=resultant,
        pressure_integral=_integral(pair, pressure, shear),
        max_penetration=depth,
        penetrating_side=side,
        cone_violation=float(
            max((-normal_force).max(initial=0.0), (np.abs(tangential_force) - bound).max(initial=0.0)) / largest
        ),
        complementarity=float(np.abs(normal_force * gaps).max(initial=0.0) / (largest * pair.size)),
        most_negative=float(pressure.min(initial=0.0) / max(pressure.max(initial=0.0), 1e-300)),
        active=int(np.count_nonzero(states)),
        sticking=int(np.count_nonzero(states == 1)),
    )


def _slots(pair: Pair, values: Floats) -> Floats:
    return values.reshape(pair.rows_per_node, -1)


def _per_node(pair: Pair, values: Floats) -> Floats:
    """Multipliers of several slots of a node add up."""
    return np.asarray(_slots(pair, values).sum(axis=0))


def _between(pair: Pair, values: Floats) -> Floats:
    """Values (m,) at nodes, with those of nodes that carry no multiplier as means of their neighbours."""
    inner, following, preceding = pair.between
    values[inner] = 0.5 * (values[following] + values[preceding])
    return values


def _states_between(pair: Pair, states: Ints) -> Ints:
    """States (m,): a node without multiplier touches where a neighbour does, and slides where one does."""
    inner, following, preceding = pair.between
    whole = states.copy()
    whole[inner] = np.maximum(states[following], states[preceding])
    return whole


def _per_length(pair: Pair, forces: Floats) -> Floats:
    return np.divide(forces, pair.cover, out=np.zeros_like(forces), where=(forces > 0.0) & (pair.cover > 0.0))


def _node_gap(pair: Pair) -> Floats:
    gaps = _slots(pair, pair.gaps[:, 0]).min(axis=0)
    return np.where(gaps < FAR, gaps, np.nan)


def _tangents(pair: Pair) -> Floats:
    normal = pair.normals
    return np.stack([normal[:, 1], -normal[:, 0]], axis=1)


def _bound(pair: Pair, normal_force: Floats) -> Floats:
    if pair.friction is None:
        return np.zeros_like(normal_force)
    law = pair.friction.bound()
    adhesion = law.adhesion * pair.cover
    if np.isfinite(law.cap):
        adhesion = np.minimum(adhesion, law.cap * normal_force)
    return np.asarray(law.coefficient * normal_force + adhesion)


def _states(pair: Pair, normal_force: Floats, tangential_force: Floats, bound: Floats) -> Ints:
    pressed = (normal_force > 0.0) | (tangential_force != 0.0)
    stick = pressed & (np.abs(tangential_force) < bound * (1.0 - 1e-9))
    per_slot = np.where(stick, 1, np.where(pressed, 2, 0)).astype(np.int32)
    return np.asarray(per_slot.reshape(pair.rows_per_node, -1).max(axis=0), np.int32)


def _integral(pair: Pair, pressure: Floats, shear: Floats) -> Floats:
    """Force on the slave: pressure against the outward normal, shear along the chain."""
    a, b = pair.slave.segments.T
    edge = pair.at.slave[b] - pair.at.slave[a]
    inward = np.stack([-edge[:, 1], edge[:, 0]], axis=1)
    mean_pressure, mean_shear = 0.5 * (pressure[a] + pressure[b]), 0.5 * (shear[a] + shear[b])
    return np.asarray(mean_pressure @ inward + mean_shear @ edge)


def _penetration(pair: Pair) -> tuple[float, str]:
    at, slave, master = pair.at, pair.slave.segments, pair.master.segments
    into_master = depths(with_midpoints(at.slave, slave), at.master, master, pair.size).max(initial=0.0)
    into_slave = depths(with_midpoints(at.master, master), at.slave, slave, pair.size).max(initial=0.0)
    if max(into_master, into_slave) == 0.0:
        return 0.0, ""
    return float(max(into_master, into_slave)), "slave" if into_master >= into_slave else "master"
