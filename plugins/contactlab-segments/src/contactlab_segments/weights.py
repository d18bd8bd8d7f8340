"""Lengths of slave surface that nodes stand for."""

from __future__ import annotations

from contactlab.api.compiled.chains import tributary_lengths
from contactlab.api.compiled.kernel import kernel


@kernel
def node_lengths(positions, surface, lengths, out):
    """Length [mm] of each slave node: half of its edges, or 1/6, 4/6 and 1/6 of a quadratic one.

    These are the integrals of the edge's own shape functions: what a constant pressure gives its nodes. `surface` is a
    `SurfaceTable`, `lengths` (s,) [mm] are those of its segments.
    """
    edges, segment_edge = surface.edges, surface.segment_edge
    if edges.shape[1] == 2:
        tributary_lengths(positions, surface.segments, surface.node_segments, out)
        return
    for i in range(out.size):
        out[i] = 0.0
    for s in range(lengths.size):
        share = lengths[s] / 6.0
        edge = segment_edge[s, 0]
        out[edges[edge, 0]] += share
        out[edges[edge, 1]] += share
        out[edges[edge, 2]] += 4.0 * share
