"""Nodal forces of tractions on edges."""

from __future__ import annotations

from contactlab.api.compiled.kernel import kernel


@kernel
def edge_forces(positions, edges, share, pressure, shear, out):
    """Add the nodal forces [N] of a pressure and a shear [MPa] on `edges` (e, b) as they lie at `positions`.

    share (e, b, b) is the integral of the trace function of a node, times the derivative of another, times the
    factor by which the load varies. Pressure acts against the outward normal, shear along the edge; the body is on the
    left.
    """
    for e in range(edges.shape[0]):
        for a in range(edges.shape[1]):
            tx, ty = 0.0, 0.0
            for b in range(edges.shape[1]):
                tx += share[e, a, b] * positions[edges[e, b], 0]
                ty += share[e, a, b] * positions[edges[e, b], 1]
            # (ty, -tx) is the outward normal times the node's length
            out[edges[e, a], 0] += shear * tx - pressure * ty
            out[edges[e, a], 1] += shear * ty + pressure * tx
