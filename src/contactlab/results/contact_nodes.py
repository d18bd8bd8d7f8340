"""Pressures, shear and states of the slave nodes of a contact, from its multipliers."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats, FrictionBound, Ints
from contactlab.api.compiled.friction import STICKS
from contactlab.api.contact_steps import NO_SEGMENT
from contactlab.contact.gap_pair import GapPair
from contactlab.contact.pair import ContactPair, ContactSnapshot
from contactlab.kernels.contact.pair import FAR

ROUND = 1e-9  # of the largest force: what linear solves leave at nodes that carry none


def node_values(pair: ContactPair, seen: ContactSnapshot) -> dict[str, np.ndarray]:
    """Pressure and shear (m,) [MPa], gap (m,) [mm] and state (m,) of every slave node; see `ContactCurve`."""
    pressure, shear = (between(pair, per_node(pair, values)) for values in seen.tractions)
    lowest = by_slot(pair, seen.gaps).min(axis=0)
    gap = between(pair, np.where(lowest < FAR, lowest, np.nan))
    # a node without multiplier touches where a neighbour does, and slides where one does
    states = states_of(pair, seen, friction_bound(pair, seen))
    inner, following, preceding = pair.between
    state = states.copy()
    state[inner] = np.maximum(states[following], states[preceding])
    return {"pressure": pressure, "shear": shear, "gap": gap, "state": state}


def facing_segments(pair: ContactPair) -> Ints:
    """The master segment (m,) whose nodes have most of the weight in each node's condition; `NO_SEGMENT` without one.

    For pairs whose conditions come finished.
    """
    if not isinstance(pair, GapPair):
        return np.asarray(pair.facing())  # type: ignore[attr-defined]
    segments = np.full(len(pair.slave.nodes), NO_SEGMENT, np.int32)
    found = pair.found
    if found is None or not len(found.gap):
        return segments
    place = np.full(len(pair.of_slave), -1)
    place[pair.master.nodes] = np.arange(len(pair.master.nodes))
    weights = np.zeros((len(found.gap), len(pair.master.nodes) + 1))  # the last column takes what is no master's
    row = np.repeat(np.arange(len(found.gap)), np.diff(found.start))
    np.add.at(weights, (row, place[found.node]), np.hypot(*found.normal_weight.T))
    a, b = pair.master.segments.T
    segments[found.owner] = np.argmax(weights[:, a] + weights[:, b], axis=1)
    return np.minimum(segments, NO_SEGMENT).astype(np.int32)


def by_slot(pair: ContactPair, values: Floats) -> Floats:
    """Values (k,) of multipliers as (multipliers of a node, m)."""
    return values.reshape(pair.rows_per_node, -1)


def per_node(pair: ContactPair, values: Floats) -> Floats:
    """Add up multipliers of several slots of a node."""
    return np.asarray(by_slot(pair, values).sum(axis=0))


def between(pair: ContactPair, values: Floats) -> Floats:
    """Values (m,) at nodes; nodes without a multiplier get the mean of their neighbours."""
    inner, following, preceding = pair.between
    values[inner] = 0.5 * (values[following] + values[preceding])
    return values


def friction_bound(pair: ContactPair, seen: ContactSnapshot) -> Floats:
    """Largest tangential force (k,) [N] that the friction law allows each multiplier."""
    normal_force = seen.forces[0]
    if pair.friction is None:
        return np.zeros_like(normal_force)
    assert pair.sliding is not None
    return FrictionBound(*pair.sliding.of(slice(None))).limits(normal_force, seen.grip)[0]


def states_of(pair: ContactPair, seen: ContactSnapshot, bound: Floats) -> Ints:
    """States (m,) of the nodes that carry multipliers: 0 open, 1 stick, 2 slip; forces of round-off close none."""
    normal_force, tangential_force = seen.forces
    least = ROUND * normal_force.max(initial=0.0)
    pressed = (normal_force > least) | (np.abs(tangential_force) > least)
    below = np.minimum(STICKS * bound, bound - pair.lagged * normal_force.max(initial=0.0))
    stick = pressed & (np.abs(tangential_force) < below)
    per_slot = np.where(stick, 1, np.where(pressed, 2, 0)).astype(np.int32)
    return np.asarray(per_slot.reshape(pair.rows_per_node, -1).max(axis=0), np.int32)
