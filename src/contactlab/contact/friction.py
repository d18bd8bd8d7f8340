"""Friction of contact pairs: laws whose bounds vary, and multipliers that supports hold without friction."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from contactlab.api import Floats, Ints, State, Surface
from contactlab.api.arrays import Flags
from contactlab.contact.pair import ContactPair
from contactlab.contact.sliding import VaryingSliding
from contactlab.meshing.turns import turns

HELD = 0.1  # flexibility along the surface over nodal flexibility: chains end with the normal of half a facet's turn
SAME = 1e-3  # segment lengths along the surface: both meshes begin at the same cut, up to round-off and strain
STILL = 1e-9  # segment lengths: supports that move both sides together


def varying(pairs: Sequence[ContactPair], state: State) -> list[tuple[ContactPair, VaryingSliding]]:
    """Return the pairs whose laws vary, bound to the state."""
    found = [(pair, pair.sliding) for pair in pairs if isinstance(pair.sliding, VaryingSliding)]
    for pair, sliding in found:
        pair.memory.update(sliding.bind(state[f"friction.{pair.name}"]))
    return found


def taking_tractions(
    varying: Sequence[tuple[ContactPair, VaryingSliding]],
) -> tuple[Callable[[float, float], None], ...]:
    """Return functions, called with the end and the length [s] of each accepted step, that keep tractions of laws."""
    return tuple(sliding.take_traction for _, sliding in varying if "traction" in sliding.law.needs)


def held_together(pair: ContactPair, flexibility: Floats, start: Floats) -> Flags:
    """Return multipliers (k,) of slave nodes held by supports together with the master beneath, as in symmetry.

    They cannot slide on each other whatever friction does: a stick constraint would be redundant, and its force
    undetermined. Friction passes nothing there; the supports hold the nodes. Curves end with the tangent of a facet,
    which leans from the plane of symmetry's normal: motion along it counts only as far as supports resist it, since
    approaching curves do not slide there.

    flexibility  (N, 2) [mm/N] of single nodes, 0 if they are held
    start        (N, 2) [mm] positions at the start of the step: nodes that supports move relative to each other slide
    """
    out = np.zeros(pair.slots, np.bool_)
    slave, master = pair.slave.nodes, pair.master.nodes
    partly = np.flatnonzero((flexibility[slave] == 0.0).any(axis=1))
    others = np.flatnonzero((flexibility[master] == 0.0).any(axis=1))
    if not len(partly) or not len(others):
        return out
    slots = (partly + len(slave) * np.arange(pair.rows_per_node)[:, None]).ravel()
    node = np.tile(partly, pair.rows_per_node).astype(np.int32)
    normal, length = pair.normals[slots], pair.full[slots]
    tangent = np.stack([normal[:, 1], -normal[:, 0]], axis=1)
    across = pair.at.slave[node][:, None] - pair.at.master[others]
    nearest = np.asarray(others[(across**2).sum(axis=2).argmin(axis=1)], np.int32)
    apart = pair.at.slave[node] - pair.at.master[nearest]
    before = start[slave[node]] - start[master[nearest]]
    axes = (flexibility[slave[node]] == 0.0) & (flexibility[master[nearest]] == 0.0)
    turn = np.maximum(_turns_at(pair.slave, start, node), _turns_at(pair.master, start, nearest))
    leans = np.where(axes, 0.0, np.abs(tangent)).max(axis=1) <= np.sin(turn)
    along = np.where(axes | ~leans[:, None], tangent, 0.0)
    together = np.abs((apart * along).sum(axis=1)) < SAME * length
    still = np.abs(((apart - before) * along).sum(axis=1)) < STILL * length
    held = [
        (own * tangent**2).sum(axis=1) <= HELD * own.max(axis=1)
        for own in (flexibility[slave[node]], flexibility[master[nearest]])
    ]
    out[slots] = together & still & held[0] & held[1]
    return out


def _turns_at(side: Surface, positions: Floats, nodes: Ints) -> Floats:
    """Angle (n,) [rad] by which a side turns next to its ends; 0 of nodes (n,) within it."""
    inward = side.node_segments[nodes]
    beside = side.segments[inward.max(axis=1), np.argmax(inward >= 0, axis=1)]
    return np.where((inward < 0).any(axis=1), np.abs(turns(side, positions)[beside]), 0.0)
