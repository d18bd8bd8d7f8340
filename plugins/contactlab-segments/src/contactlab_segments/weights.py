"""Lengths of slave surface that nodes stand for."""

from __future__ import annotations

from contactlab.api.compiled.chains import tributary_lengths
from contactlab.api.compiled.kernel import kernel


@kernel
def node_lengths(positions, segments, node_segments, edges, segment_edge, lengths, out):
    """Length [mm] of each slave node: half of its edges, or 1/6, 4/6 and 1/6 of a quadratic one.

    These are the integrals of the edge's own shape functions: what a constant pressure gives its nodes. `lengths`
    (s,) [mm] are those of the segments.
    """
    if edges.shape[1] == 2:
        tributary_lengths(positions, segments, node_segments, out)
        return
    for i in range(out.size):
        out[i] = 0.0
    for s in range(segments.shape[0]):
        share = lengths[s] / 6.0
        edge = segment_edge[s, 0]
        out[edges[edge, 0]] += share
        out[edges[edge, 1]] += share
        out[edges[edge, 2]] += 4.0 * share
