"""Integrals of traces and multipliers over one overlap, exact on straight segments."""

from __future__ import annotations

from contactlab.api.kernel import point, section

_POINTS = (-0.7745966692414834, 0.0, 0.7745966692414834)
_WEIGHTS = (5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0)


@point
def trace(nodes, half, xi, i):
    """Shape function i of an edge with `nodes` nodes at xi in [0, 1] of its straight segment `half`."""
    if nodes == 2:
        return 1.0 - xi if i == 0 else xi
    s = xi + half - 1.0
    if i == 0:
        return 0.5 * s * (s - 1.0)
    if i == 1:
        return 0.5 * s * (s + 1.0)
    return 1.0 - s * s


@point
def constant_basis(xi, k):
    """P0: multiplier k = 0, 1 is one on its own half of the segment."""
    inside = xi < 0.5 if k == 0 else xi >= 0.5
    return 1.0 if inside else 0.0


@section
def integrate(low, high, eta_low, eta_high, length, slave_half, master_half, linear, p, D, M, T):
    """Add the part low < xi < high of a slave segment to piece p.

    `length` [mm] of the slave segment; eta runs linearly from eta_low to eta_high. The interval must
    not contain the break xi = 1/2 of the P0 basis. Three Gauss points are exact for the products
    of a quadratic trace with a linear basis; two sets of linear functions need two.
    """
    slave_nodes, master_nodes = D.shape[1], M.shape[1]
    for g in range(3):
        t = 0.5 * (1.0 + _POINTS[g])
        xi = low + t * (high - low)
        eta = eta_low + t * (eta_high - eta_low)
        weight = _WEIGHTS[g] * (high - low) * length
        for k in range(2):
            hat = 1.0 - xi if k == 0 else xi
            psi = weight * (hat if linear else constant_basis(xi, k))
            for i in range(slave_nodes):
                D[p, i, k] += psi * trace(slave_nodes, slave_half, xi, i)
            for i in range(master_nodes):
                M[p, i, k] += psi * trace(master_nodes, master_half, eta, i)
            T[p, 0, k] += psi * (1.0 - xi)
            T[p, 1, k] += psi * xi
