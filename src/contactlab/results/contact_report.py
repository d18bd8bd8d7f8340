"""Report of one contact at an instant: curve, resultant, penetration, violations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from contactlab.api import Floats, Ints, State
from contactlab.contact.pair import ContactPair, ContactSnapshot, turned
from contactlab.kernels.contact.pair import FAR
from contactlab.kernels.contact.penetration import depths, with_midpoints
from contactlab.results.contact_nodes import between, by_slot, friction_bound, node_values, per_node, states_of
from contactlab.results.results import ContactCurve

VERTEX = 0.2  # sine of a turn of the slave
BALANCED = 0.1  # of the sum of nodal forces: a resultant below it says how they balance, not how large they are


@dataclass(frozen=True)
class ContactReport:
    """Curve and scalars of one contact.

    resultant          (2,) [N] sum of normal and tangential forces on the slave, along its normals
    pressure_integral  (2,) [N] integral of pressure and shear over the deformed slave chain
    covered_integral   (2,) [N] the same where each node counts with the share of its length that is covered
    max_penetration    [mm] of either side's nodes and segment middles into the other side
    penetrating_side   "slave", "master" or ""
    cone_violation     largest of -y_n and |y_t| - bound, over the largest y_n
    complementarity    largest |y_n g| over largest y_n times segment length
    kept_work          [mJ] sum of y_n times overlaps: what opening pressed conditions would take
    most_negative      lowest multiplier over the highest
    active, sticking   nodes with a force; of these, nodes below their friction bound
    largest            [N] largest y_n
    pressing           [N] sum of the y_n that press
    """

    curve: ContactCurve
    resultant: Floats
    pressure_integral: Floats
    covered_integral: Floats
    max_penetration: float
    penetrating_side: str
    cone_violation: float
    complementarity: float
    kept_work: float
    most_negative: float
    active: int
    sticking: int
    largest: float = 0.0
    pressing: float = 0.0

    def force_error(self, integral: Floats) -> float:
        """Relative difference of an integral of tractions (2,) [N] from the nodal forces; 0 without forces.

        Around a shaft forces balance: the scale is then a tenth of their sum.
        """
        force = max(float(np.hypot(*self.resultant)), BALANCED * self.pressing)
        return float(np.hypot(*(self.resultant - integral))) / force if force > 0.0 else 0.0

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


def report_contact(pair: ContactPair, state: State, reference: Floats, position: Floats) -> ContactReport:
    """The `pair` at the accepted step that ends at the deformed `position` (N, 2), with the state's multipliers."""
    seen = pair.snapshot(state, position)
    normal_force, tangential_force = seen.forces
    values = node_values(pair, seen)
    pressure, shear = values["pressure"], values["shear"]
    bound = friction_bound(pair, seen)
    largest = max(float(normal_force.max(initial=0.0)), 1e-300)
    gaps = np.where(seen.gaps < FAR, seen.gaps, 0.0)
    states = states_of(pair, seen, bound)
    depth, side = _penetration(pair, seen)
    along = arc_length(reference[pair.slave.nodes], pair.slave.segments)
    forces = seen.forces[0]
    pressed = (forces > 0.0) & (seen.cover > 0.0)
    per_length = np.asarray(np.divide(forces, seen.cover, out=np.zeros_like(forces), where=pressed))
    curve = ContactCurve(
        s=along.s,
        x=seen.at.slave[:, 0].copy(),
        y=seen.at.slave[:, 1].copy(),
        pressure=pressure,
        shear=shear,
        nodal_pressure=between(pair, per_node(pair, per_length)),
        gap=values["gap"],
        state=values["state"],
        chain=along.chain,
        memory={name: _remembered(pair, values) for name, values in pair.memory.items()},
    )
    return ContactReport(
        curve=curve,
        resultant=seen.resultant,
        pressure_integral=_integral(pair, seen, pressure, shear),
        covered_integral=_integral(pair, seen, pressure, shear, _covered(pair, seen)),
        max_penetration=depth,
        penetrating_side=side,
        largest=largest,
        pressing=float(np.maximum(normal_force, 0.0).sum()),
        cone_violation=float(
            max((-normal_force).max(initial=0.0), (np.abs(tangential_force) - bound).max(initial=0.0)) / largest
        ),
        complementarity=float(np.abs(normal_force * gaps).max(initial=0.0) / (largest * pair.size)),
        kept_work=float(normal_force @ np.maximum(0.0, pair.opened - seen.gaps)),
        most_negative=float(pressure.min(initial=0.0) / max(pressure.max(initial=0.0), 1e-300)),
        active=int(np.count_nonzero(states)),
        sticking=int(np.count_nonzero(states == 1)),
    )


def _remembered(pair: ContactPair, values: Floats) -> Floats:
    """Memory (m,) of the slave nodes: of several multipliers of a node the value of largest magnitude."""
    slots = by_slot(pair, values)
    return between(pair, np.take_along_axis(slots, np.abs(slots).argmax(axis=0)[None], axis=0)[0])


def _covered(pair: ContactPair, seen: ContactSnapshot) -> Floats:
    """Share (m,) of each node's length that its multiplier covers; of nodes without one it is not asked for."""
    if np.size(pair.slave.nodes[pair.between[0]]):  # a multiplier's length covers whole edges
        cover, full = (by_slot(pair, length).max(axis=0) for length in (seen.cover, pair.full))
        return np.asarray(np.divide(cover, full, out=np.zeros_like(cover), where=full > 0.0))
    lengths = np.zeros(len(pair.slave.nodes))
    a, b = pair.slave.segments.T
    half = 0.5 * pair.slave.lengths(seen.at.slave)
    np.add.at(lengths, a, half)
    np.add.at(lengths, b, half)
    return np.asarray(by_slot(pair, seen.cover).max(axis=0) / lengths)


def _integral(
    pair: ContactPair, seen: ContactSnapshot, pressure: Floats, shear: Floats, share: Floats | None = None
) -> Floats:
    """Force on the slave: pressure against the outward normal, shear along the chain.

    With the covered `share` of nodes, tractions at pressed ends and vertices act along the contact's force there, and
    so do tractions of adjacent nodes without force: their multipliers belong to the vertex.
    """
    if share is None and pair.at_points and pair.slave.edges.shape[1] == 3:
        return _simpson(seen.at.slave[pair.slave.edges], pressure[pair.slave.edges], shear[pair.slave.edges])
    a, b = pair.slave.segments.T
    edge = seen.at.slave[b] - seen.at.slave[a]
    inward = np.repeat(np.stack([-edge[:, 1], edge[:, 0]], axis=1)[:, None], 2, axis=1)
    if share is not None:
        pressure, shear = (between(pair, share * part) for part in (pressure, shear))
        force = np.stack([by_slot(pair, seen.forces[0] * part).sum(axis=0) for part in seen.normals.T], axis=1)
        size = np.hypot(*force.T)
        bears = (by_slot(pair, seen.forces[0]).max(axis=0) > 0.0) & (size > 0.0)
        pressed, free = np.flatnonzero(bears), np.flatnonzero(~bears & (pressure != 0.0))
        owner = np.arange(len(share))
        if len(pressed) and len(free):
            apart = np.abs(seen.at.slave[free, None] - seen.at.slave[pressed]).sum(axis=2)
            owner[free] = pressed[apart.argmin(axis=1)]
        # where the slave ends or turns by more than VERTEX
        before, after = pair.slave.node_segments.T
        along = edge / np.hypot(*edge.T)[:, None]
        turn = along[before, 0] * along[after, 1] - along[before, 1] * along[after, 0]
        vertices = np.asarray((before < 0) | (after < 0) | (np.abs(turn) > VERTEX))
        vertex = (vertices & bears)[owner][pair.slave.segments]
        lengths = np.broadcast_to(np.hypot(*edge.T)[:, None], vertex.shape)
        direction = (force / np.where(bears, size, 1.0)[:, None])[owner]
        inward[vertex] = lengths[vertex][:, None] * direction[pair.slave.segments[vertex]]
    total = np.einsum("sk,skd->d", pressure[pair.slave.segments], inward)
    return np.asarray(0.5 * (total + turned(np.einsum("sk,skd->d", shear[pair.slave.segments], inward)[None])[0]))


def _simpson(x: Floats, pressure: Floats, shear: Floats) -> Floats:
    """Integral (2,) [N] of tractions (e, 3) along quadratic edges with nodes x (e, 3, 2): start, end, middle."""
    slope = np.array([[-1.5, -0.5, 2.0], [0.5, 1.5, -2.0], [-0.5, 0.5, 0.0]])
    weighted = np.array([1.0, 1.0, 4.0])[:, None] / 3.0 * np.einsum("kj,ejd->ekd", slope, x)
    inward = np.stack([-weighted[..., 1], weighted[..., 0]], axis=-1)
    total, along = (np.einsum("ek,ekd->d", values, inward) for values in (pressure, shear))
    return np.asarray(total + turned(along[None])[0])


def _penetration(pair: ContactPair, seen: ContactSnapshot) -> tuple[float, str]:
    at, slave, master = seen.at, pair.slave.segments, pair.master.segments
    into_master = depths(with_midpoints(at.slave, slave), at.master, master, pair.size).max(initial=0.0)
    into_slave = depths(with_midpoints(at.master, master), at.slave, slave, pair.size).max(initial=0.0)
    if max(into_master, into_slave) == 0.0:
        return 0.0, ""
    return float(max(into_master, into_slave)), "slave" if into_master >= into_slave else "master"


class ArcLength(NamedTuple):
    """Arc length s (m,) [mm] of each node of a surface, and the number of its chain (m,), from 0."""

    s: Floats
    chain: Ints


def arc_length(positions: Floats, segments: Ints) -> ArcLength:
    """Arc length along the `segments` (s, 2) between `positions` (m, 2) [mm].

    Each chain continues where the previous chain ends, so that s never falls from chain to chain. Chains that begin at
    a free end come first, closed chains after them, each in the order of the nodes that they begin with.
    """
    following = {int(a): int(b) for a, b in segments}
    free = sorted(following.keys() - following.values())
    s, chain = np.zeros(len(positions)), np.full(len(positions), -1, np.int32)
    length, count = 0.0, 0
    for start in [*free, *sorted(following)]:
        if chain[start] >= 0:
            continue
        node, s[start], chain[start] = start, length, count
        while (after := following.get(node)) is not None:
            length = s[node] + np.hypot(*(positions[after] - positions[node]))
            if chain[after] >= 0:
                break  # a closed chain ends where it began
            node, s[after], chain[after] = after, length, count
        count += 1
    return ArcLength(s, chain)
