"""Integrals of traces and multipliers over one overlap, exact on straight segments, and their derivatives.

`halves` says what of quadratic edges the two segments are: the half of the slave's edge, the half of the master's, and
what the hats of multipliers span (see `hat`). P0 has a break at xi = 1/2 where hats span segments: integrals are taken
on either side of it.
"""

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
def trace_derivative(nodes, half, xi, i):
    """d(trace)/d(xi)."""
    if nodes == 2:
        return -1.0 if i == 0 else 1.0
    s = xi + half - 1.0
    if i == 0:
        return s - 0.5
    if i == 1:
        return s + 0.5
    return -2.0 * s


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


@point
def gauss(slave_nodes, master_nodes, linear):
    """First Gauss point and their number: as many as the products need to be exact.

    1 for constant times linear, 2 up to quadratic times constant or linear times linear, 3 above.
    """
    points = max(slave_nodes, master_nodes) - (0 if linear else 1)
    return points * (points - 1) // 2, points


@point
def parts(halves, linear):
    """In how many parts an overlap is integrated."""
    return 1 if linear or halves[2] != 0 else 2


@point
def cut(low, high, part, count):
    """Where part 0 or 1 of `count` of an overlap begins and ends; it ends before it begins where it is empty."""
    if count == 1:
        return low, high
    return (low, min(high, 0.5)) if part == 0 else (max(low, 0.5), high)


@section
def integrate(found, length, halves, linear, p, out):
    """Add an overlap to piece p of out = D, M, T; `length` [mm] of the slave segment."""
    D, M, T = out
    slave_nodes, master_nodes = D.shape[1], M.shape[1]
    first, points = gauss(slave_nodes, master_nodes, linear)
    slope = (found.eta_high - found.eta_low) / (found.high - found.low)
    count = parts(halves, linear)
    for part in range(count):
        low, high = cut(found.low, found.high, part, count)
        if high <= low:
            continue
        eta_low, eta_high = found.eta_low + (low - found.low) * slope, found.eta_low + (high - found.low) * slope
        for g in range(first, first + points):
            t = _POINTS[g]
            xi = low + t * (high - low)
            eta = eta_low + t * (eta_high - eta_low)
            weight = _WEIGHTS[g] * (high - low) * length
            for k in range(2):
                psi = weight * (hat(halves[2], xi, k) if linear else constant_basis(halves[2], xi, k))
                for i in range(slave_nodes):
                    D[p, i, k] += psi * trace(slave_nodes, halves[0], xi, i)
                for i in range(master_nodes):
                    M[p, i, k] += psi * trace(master_nodes, halves[1], eta, i)
                T[p, 0, k] += psi * hat(halves[2], xi, 0)
                T[p, 1, k] += psi * hat(halves[2], xi, 1)


@section
def integrate_straight(found, length, linear, p, out):
    """Fill piece p for edges of two nodes: in closed form what `integrate` sums.

    Traces and multipliers are linear along the overlap; the integral of two linear functions f and g is
    f_0 (2 g_0 + g_1)/6 + f_1 (g_0 + 2 g_1)/6 of its width.
    """
    D, M, T = out
    low, high, eta_low, eta_high = found.low, found.high, found.eta_low, found.eta_high
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
            begin, end = cut(low, high, k, 2)
            w, middle = max(end - begin, 0.0) * length, 0.5 * (begin + end)
            eta = eta_low + (middle - low) * slope
            T[p, 0, k], T[p, 1, k] = w * (1.0 - middle), w * middle
            M[p, 0, k], M[p, 1, k] = w * (1.0 - eta), w * eta
    for k in range(2):
        D[p, 0, k], D[p, 1, k] = T[p, 0, k], T[p, 1, k]


@section
def integrate_changes(found, length, halves, linear, change, p, out):
    """Add to entry p of out = dD, dM, dT how `integrate` changes with the ends of an overlap.

    change = d(low), d(high), d(eta_low), d(eta_high)
    """
    dD, dM, dT = out
    dlow, dhigh, deta_low, deta_high = change
    slave_nodes, master_nodes = dD.shape[1], dM.shape[1]
    first, points = gauss(slave_nodes, master_nodes, linear)
    slope = (found.eta_high - found.eta_low) / (found.high - found.low)
    dslope = (deta_high - deta_low - slope * (dhigh - dlow)) / (found.high - found.low)
    count = parts(halves, linear)
    for part in range(count):
        low, high = cut(found.low, found.high, part, count)
        if high <= low:
            continue
        # the break between the parts stays
        dbegin, dend = dlow if low == found.low else 0.0, dhigh if high == found.high else 0.0
        for g in range(first, first + points):
            t = _POINTS[g]
            xi, dxi = low + t * (high - low), dbegin + t * (dend - dbegin)
            eta = found.eta_low + (xi - found.low) * slope
            deta = deta_low + (dxi - dlow) * slope + (xi - found.low) * dslope
            weight, dweight = _WEIGHTS[g] * (high - low) * length, _WEIGHTS[g] * (dend - dbegin) * length
            for k in range(2):
                basis = hat(halves[2], xi, k) if linear else constant_basis(halves[2], xi, k)
                dbasis = hat_derivative(halves[2], k) * dxi if linear else 0.0
                psi, dpsi = weight * basis, dweight * basis + weight * dbasis
                for i in range(slave_nodes):
                    along = trace_derivative(slave_nodes, halves[0], xi, i) * dxi
                    dD[p, i, k] += dpsi * trace(slave_nodes, halves[0], xi, i) + psi * along
                for i in range(master_nodes):
                    along = trace_derivative(master_nodes, halves[1], eta, i) * deta
                    dM[p, i, k] += dpsi * trace(master_nodes, halves[1], eta, i) + psi * along
                for i in range(2):
                    dT[p, i, k] += dpsi * hat(halves[2], xi, i) + psi * hat_derivative(halves[2], i) * dxi
