"""Slave nodes that supports hold along the surface together with the master beneath them, as on a plane of symmetry.

They cannot slide on each other whatever friction does: to stick is one condition too many, and its force is one that
nothing determines. Friction passes nothing there; what holds the nodes is up to the supports.
"""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats
from contactlab.api.arrays import Flags
from contactlab.contact.pair import ContactPair

HELD = 0.1  # flexibility along the surface over that of the node: chains end with the normal of half a facet's turn
SAME = 1e-3  # segment lengths along the surface: meshes of both sides begin at one cut, but for round-off and strains
STILL = 1e-9  # segment lengths: supports that move both sides together


def held_together(pair: ContactPair, flexibility: Floats, start: Floats) -> Flags:
    """Which multipliers (k,) of a pair belong to such nodes, at the pair's positions.

    flexibility  (N, 2) [mm/N] of single nodes, 0 where they are held
    start        (N, 2) [mm] positions at the start of the step: what supports move against each other slides
    """
    out = np.zeros(pair.slots, np.bool_)
    slave, master = pair.slave.nodes, pair.master.nodes
    partly = np.flatnonzero((flexibility[slave] == 0.0).any(axis=1))
    others = np.flatnonzero((flexibility[master] == 0.0).any(axis=1))
    if not len(partly) or not len(others):
        return out
    slots = (partly + len(slave) * np.arange(pair.rows_per_node)[:, None]).ravel()
    node = np.tile(partly, pair.rows_per_node)
    normal, length = pair.normals[slots], pair.full[slots]
    tangent = np.stack([normal[:, 1], -normal[:, 0]], axis=1)
    across = pair.at.slave[node][:, None] - pair.at.master[others]
    nearest = others[(across**2).sum(axis=2).argmin(axis=1)]
    apart = pair.at.slave[node] - pair.at.master[nearest]
    before = start[slave[node]] - start[master[nearest]]
    together = np.abs((apart * tangent).sum(axis=1)) < SAME * length
    still = np.abs(((apart - before) * tangent).sum(axis=1)) < STILL * length
    held = _held(flexibility[slave[node]], tangent) & _held(flexibility[master[nearest]], tangent)
    out[slots] = together & still & held
    return out


def _held(flexibility: Floats, tangent: Floats) -> Flags:
    along = (flexibility * tangent**2).sum(axis=1)
    return np.asarray(along <= HELD * flexibility.max(axis=1))
