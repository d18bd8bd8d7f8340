"""Nodal forces of tractions on edges."""

from __future__ import annotations

from contactlab.api.compiled.kernel import kernel


@kernel
def edge_forces(positions, edges, shape, derivative, weights, pressure, shear, out):
    """Add the nodal forces [N] of a pressure and a shear [MPa] on `edges` (e, b) as they lie at `positions`.

    shape, derivative (g, b) trace functions and their derivatives by s; `weights` (e, g) of the points, times the
    factor by which the load varies along the edges. Pressure acts against the outward normal, shear along the edge;
    the body is on the left.
    """
    for e in range(edges.shape[0]):
        for g in range(weights.shape[1]):
            tx, ty = 0.0, 0.0
            for a in range(edges.shape[1]):
                tx += derivative[g, a] * positions[edges[e, a], 0]
                ty += derivative[g, a] * positions[edges[e, a], 1]
            # (ty, -tx) is the outward normal times the length of the edge per unit of s
            fx = weights[e, g] * (shear * tx - pressure * ty)
            fy = weights[e, g] * (shear * ty + pressure * tx)
            for a in range(edges.shape[1]):
                out[edges[e, a], 0] += shape[g, a] * fx
                out[edges[e, a], 1] += shape[g, a] * fy
