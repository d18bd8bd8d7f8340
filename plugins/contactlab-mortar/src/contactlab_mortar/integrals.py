"""Integrals of traces and multipliers over one overlap, exact on straight segments."""

from __future__ import annotations

from contactlab.api.compiled.kernel import point, section

# Gauss rules with 1, 2 and 3 points on [0, 1], one after another
_POINTS = (0.5, 0.21132486540518713, 0.7886751345948129, 0.1127016653792583, 0.5, 0.8872983346207417)
_WEIGHTS = (1.0, 0.5, 0.5, 5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0)


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
def hat(halves, xi, k):
    """Linear hat of end k of what a multiplier's hat spans: the segment, or the edge whose half the segment is.

    Of an edge, 0 is the end that this half touches; `halves` is 0 for segments, 1 and 2 for the two halves.
    """
    if halves == 0:
        return 1.0 - xi if k == 0 else xi
    away = 0.5 * xi if halves == 1 else 0.5 * (1.0 - xi)
    return 1.0 - away if k == 0 else away


@point
def hat_derivative(halves, k):
    """d(hat)/d(xi)."""
    slope = 1.0 if halves == 0 else (0.5 if halves == 1 else -0.5)
    return -slope if k == 0 else slope


@point
def constant_basis(halves, xi, k):
    """P0: multiplier k = 0, 1 is one on its own half of what its hat spans."""
    if halves != 0:
        return 1.0 if k == 0 else 0.0
    inside = xi < 0.5 if k == 0 else xi >= 0.5
    return 1.0 if inside else 0.0


@section
def integrate(low, high, eta_low, eta_high, length, slave_half, master_half, halves, linear, p, D, M, T):
    """Add the part low < xi < high of a slave segment to piece p.

    `length` [mm] of the slave segment; eta runs linearly from eta_low to eta_high. The interval must
    not contain the break xi = 1/2 of the P0 basis. As many Gauss points as the products need to be
    exact: 1 for constant times linear, 2 up to quadratic times constant or linear times linear, 3 above.
    """
    slave_nodes, master_nodes = D.shape[1], M.shape[1]
    points = max(slave_nodes, master_nodes) - (0 if linear else 1)
    first = points * (points - 1) // 2
    for g in range(first, first + points):
        t = _POINTS[g]
        xi = low + t * (high - low)
        eta = eta_low + t * (eta_high - eta_low)
        weight = _WEIGHTS[g] * (high - low) * length
        for k in range(2):
            psi = weight * (hat(halves, xi, k) if linear else constant_basis(halves, xi, k))
            for i in range(slave_nodes):
                D[p, i, k] += psi * trace(slave_nodes, slave_half, xi, i)
            for i in range(master_nodes):
                M[p, i, k] += psi * trace(master_nodes, master_half, eta, i)
            T[p, 0, k] += psi * hat(halves, xi, 0)
            T[p, 1, k] += psi * hat(halves, xi, 1)


@section
def integrate_straight(low, high, eta_low, eta_high, length, linear, p, D, M, T):
    """Fill piece p for edges of two nodes: in closed form what `integrate` sums, break of the P0 basis included.

    Traces and multipliers are linear along the overlap; the integral of two linear functions f and g is
    f_0 (2 g_0 + g_1)/6 + f_1 (g_0 + 2 g_1)/6 of its width.
    """
    if linear:
        w = (high - low) * length / 6.0
        begin, end = 1.0 - low, 1.0 - high
        a, b = w * (2.0 * begin + end), w * (begin + 2.0 * end)
        c, d = w * (2.0 * low + high), w * (low + 2.0 * high)
        T[p, 0, 0], T[p, 1, 1] = a * begin + b * end, c * low + d * high
        T[p, 1, 0], T[p, 0, 1] = a * low + b * high, a * low + b * high
        M[p, 0, 0], M[p, 0, 1] = a * (1.0 - eta_low) + b * (1.0 - eta_high), c * (1.0 - eta_low) + d * (1.0 - eta_high)
        M[p, 1, 0], M[p, 1, 1] = a * eta_low + b * eta_high, c * eta_low + d * eta_high
    else:
        slope = (eta_high - eta_low) / (high - low)
        for k in range(2):
            begin, end = (low, min(high, 0.5)) if k == 0 else (max(low, 0.5), high)
            w, middle = max(end - begin, 0.0) * length, 0.5 * (begin + end)
            eta = eta_low + (middle - low) * slope
            T[p, 0, k], T[p, 1, k] = w * (1.0 - middle), w * middle
            M[p, 0, k], M[p, 1, k] = w * (1.0 - eta), w * eta
    for k in range(2):
        D[p, 0, k], D[p, 1, k] = T[p, 0, k], T[p, 1, k]
