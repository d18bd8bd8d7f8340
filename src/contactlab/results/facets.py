"""Turns of a contact surface: facets of a curve, which finer cells follow, and kinks, which belong to the shape."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from contactlab.api import Floats, Surface
from contactlab.api.arrays import Flags

if TYPE_CHECKING:
    from contactlab.contact.pair import ContactPair

CORNER = 0.6
"""Angle [rad] between segments above which a node is a corner, and no part of a curve."""

KINK = 1e-3, 0.3  # rad: smaller turns are those of rounded coordinates, larger ones falsify pressures along one normal
ALIKE = 1.0 / 3.0  # of a turn: the next one of a curve is at least so large, and to the same side
NEAR = 4  # segments to the next turn: of straight sides that were divided by a level or into two halves


def facet_depths(surface: Surface, reference: Floats) -> Floats:
    """Distance (m,) [mm] of a smooth curve from its facets at each node that turns: length times angle over 8.

    A node belongs to a curve if the surface turns by a like angle at a node near by; the facet is what lies between.
    """
    angle, length = np.abs(_turns(surface, reference)), _facets(surface, reference)
    return np.asarray(np.where((angle < CORNER) & np.isfinite(length), angle * np.nan_to_num(length) / 8.0, 0.0))


def kinks(surface: Surface, reference: Floats) -> Flags:
    """Nodes (m,) at which the surface turns and no curve does: the apex of a wedge, where pressures have a cusp."""
    angle = np.abs(_turns(surface, reference))
    return np.asarray((angle > KINK[0]) & (angle < KINK[1]) & ~np.isfinite(_facets(surface, reference)))


def cusps(pair: ContactPair, reference: Floats) -> Flags:
    """Slave nodes (m,) where exact pressures may have a cusp: kinks of the slave, or nearest to kinks of the master."""
    found = kinks(pair.slave, reference)
    for point in pair.at.master[kinks(pair.master, reference)]:
        if np.isfinite(point).all():
            found[np.hypot(*(pair.at.slave - point).T).argmin()] = True
    return found


def _turns(surface: Surface, reference: Floats) -> Floats:
    """Angle (m,) [rad] from the segment before each node to the one behind it; 0 at ends."""
    begin, end = (reference[surface.nodes[surface.segments[:, k]]] for k in range(2))
    along = end - begin
    into, out = surface.node_segments.T
    inner = np.flatnonzero((into >= 0) & (out >= 0))
    a, b = along[into[inner]], along[out[inner]]
    angle = np.zeros(len(surface.nodes))
    angle[inner] = np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], np.einsum("ni,ni->n", a, b))
    return angle


def _facets(surface: Surface, reference: Floats) -> Floats:
    """Length (m,) [mm] of the longer facet beside each node of a curve; nan where no like turn is near."""
    begin, end = (reference[surface.nodes[surface.segments[:, k]]] for k in range(2))
    length, angle = np.hypot(*(end - begin).T), _turns(surface, reference)
    found = np.full((2, len(angle)), np.nan)
    for side in range(2):
        at, way = np.arange(len(angle)), np.zeros(len(angle))
        for _ in range(NEAR):
            segment = surface.node_segments[at, side]
            there = segment >= 0
            way = way + np.where(there, length[segment], np.nan)
            at = np.where(there, surface.segments[segment, side], at)
            like = (angle[at] * np.sign(angle) >= ALIKE * np.abs(angle)) & (angle != 0.0)
            found[side] = np.where(np.isnan(found[side]) & like, way, found[side])
    return np.asarray(np.fmax(*found))
