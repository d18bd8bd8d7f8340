"""Nodal forces of tractions on edges."""

from __future__ import annotations

from contactlab.api.compiled.kernel import kernel


@kernel
def edge_forces(positions, edges, shape, slope, weights, pressure, shear, out):
    """Add the nodal forces [N] of a uniform pressure and shear [MPa] on `edges` (e, b) as they lie at `positions`.

    shape, slope (g, b) trace functions and their derivatives by s at the points with `weights` (g,). Pressure
    acts against the outward normal, shear along the edge; the body is on the left.
    """
    for e in range(edges.shape[0]):
        for g in range(weights.size):
            tx, ty = 0.0, 0.0
            for a in range(edges.shape[1]):
                tx += slope[g, a] * positions[edges[e, a], 0]
                ty += slope[g, a] * positions[edges[e, a], 1]
            # (ty, -tx) is the outward normal times the length of the edge per unit of s
            fx = weights[g] * (shear * tx - pressure * ty)
            fy = weights[g] * (shear * ty + pressure * tx)
            for a in range(edges.shape[1]):
                out[edges[e, a], 0] += shape[g, a] * fx
                out[edges[e, a], 1] += shape[g, a] * fy
