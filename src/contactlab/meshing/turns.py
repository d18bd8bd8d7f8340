"""Turns of a surface from segment to segment, and which of them belong to a curve that facets follow."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats, Surface

ALIKE = 1.0 / 3.0  # of a turn: the next one of a curve is at least so large, and to the same side
NEAR = 4  # segments to the next turn: of straight sides that were divided by a level or into two halves


def turns(surface: Surface, reference: Floats) -> Floats:
    """Angle (m,) [rad] from the segment before each node to the segment after it; 0 at ends."""
    begin, end = (reference[surface.nodes[surface.segments[:, k]]] for k in range(2))
    along = end - begin
    into, out = surface.node_segments.T
    inner = np.flatnonzero((into >= 0) & (out >= 0))
    a, b = along[into[inner]], along[out[inner]]
    angle = np.zeros(len(surface.nodes))
    angle[inner] = np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], np.einsum("ni,ni->n", a, b))
    return angle


def facet_lengths(surface: Surface, reference: Floats) -> Floats:
    """Length (m,) [mm] of the longer facet next to each node of a curve; NaN if no similar turn is near."""
    begin, end = (reference[surface.nodes[surface.segments[:, k]]] for k in range(2))
    length, angle = np.hypot(*(end - begin).T), turns(surface, reference)
    found: Floats = np.full((2, len(angle)), np.nan)
    if not angle.any():
        return np.full(len(angle), np.nan)
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
