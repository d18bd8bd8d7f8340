"""What one would write by hand for the other elements: one scalar loop over cells with the neo-Hookean law.

As in `fused_loops.py`: x deformed, u undeformed positions, everything of a cell in local variables.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
from fused_loops import add, fused, gradient, inlined, neo_hookean_stress

_G = 0.5773502691896258
_XI, _ETA = (-_G, _G, _G, -_G), (-_G, -_G, _G, _G)


@inlined
def _modes(a, b, c, d):
    """Coefficients of xi, eta and xi eta of four nodal values, times 4."""
    return b + c - a - d, c + d - a - b, a + c - b - d


@fused
def q1_reduced(x, u, displacement, cells, force, lame, shear, modulus):
    """One point, and elastic hourglass forces on the undeformed cell (Flanagan & Belytschko 1981)."""
    for n in range(cells.shape[0]):
        i, j, k, m = cells[n, 0], cells[n, 1], cells[n, 2], cells[n, 3]
        xx, xy, yx, yy, a, b, c, d = gradient(x, u, i, j, k, m, 0.0, 0.0)
        s_xx, s_yy, s_xy = neo_hookean_stress(xx, xy, yx, yy, lame, shear)
        add(force, i, j, k, m, 0.0, 0.0, a, b, c, d, 4.0 * s_xx, 4.0 * s_yy, 4.0 * s_xy)
        x1, x2, x3 = _modes(u[i, 0], u[j, 0], u[k, 0], u[m, 0])
        y1, y2, y3 = _modes(u[i, 1], u[j, 1], u[k, 1], u[m, 1])
        inverse = 1.0 / (x1 * y2 - x2 * y1)
        stiffness = 0.0625 * modulus * (x1 * x1 + x2 * x2 + y1 * y1 + y2 * y2) * inverse
        along, across = (x3 * y2 - y3 * x2) * inverse, (y3 * x1 - x3 * y1) * inverse
        for e in range(2):
            v = displacement
            v1, v2, v3 = _modes(v[i, e], v[j, e], v[k, e], v[m, e])
            f = stiffness * (v3 - along * v1 - across * v2)
            force[i, e] += f * (1.0 + along + across)
            force[j, e] -= f * (1.0 + along - across)
            force[k, e] += f * (1.0 - along - across)
            force[m, e] -= f * (1.0 - along + across)


@fused
def q1_fbar(x, u, cells, force, lame, shear):
    """The volume change of the centre at every point, with conjugate forces."""
    for n in range(cells.shape[0]):
        i, j, k, m = cells[n, 0], cells[n, 1], cells[n, 2], cells[n, 3]
        xx, xy, yx, yy, a, b, c, d = gradient(x, u, i, j, k, m, 0.0, 0.0)
        centre, area, mean = xx * yy - xy * yx, a * d - b * c, 0.0
        for g in range(4):
            xx, xy, yx, yy, p, q, r, s = gradient(x, u, i, j, k, m, _XI[g], _ETA[g])
            ratio = (xx * yy - xy * yx) / centre
            scale = 1.0 / sqrt(ratio)
            s_xx, s_yy, s_xy = neo_hookean_stress(scale * xx, scale * xy, scale * yx, scale * yy, lame, shear)
            half = 0.5 * ratio * (s_xx - s_yy)
            add(force, i, j, k, m, _XI[g], _ETA[g], p, q, r, s, half, -half, ratio * s_xy)
            mean += 0.5 * ratio * (s_xx + s_yy) * (p * s - q * r) / area
        add(force, i, j, k, m, 0.0, 0.0, a, b, c, d, mean, mean, 0.0)


@fused
def by_table(x, u, cells, force, lame, shear, derivatives, weights):
    """Any element from derivatives (points, nodes, 2) of its shape functions and weights (points,)."""
    points, nodes = derivatives.shape[0], derivatives.shape[1]
    here, before, own = np.empty((nodes, 2)), np.empty((nodes, 2)), np.empty((nodes, 2))
    for n in range(cells.shape[0]):
        for a in range(nodes):
            node = cells[n, a]
            here[a, 0], here[a, 1] = x[node, 0], x[node, 1]
            before[a, 0], before[a, 1] = u[node, 0], u[node, 1]
            own[a, 0], own[a, 1] = 0.0, 0.0
        for g in range(points):
            x_xi, x_eta, y_xi, y_eta = 0.0, 0.0, 0.0, 0.0
            u_xi, u_eta, v_xi, v_eta = 0.0, 0.0, 0.0, 0.0
            for a in range(nodes):
                p, q = derivatives[g, a, 0], derivatives[g, a, 1]
                x_xi, x_eta = x_xi + p * here[a, 0], x_eta + q * here[a, 0]
                y_xi, y_eta = y_xi + p * here[a, 1], y_eta + q * here[a, 1]
                u_xi, u_eta = u_xi + p * before[a, 0], u_eta + q * before[a, 0]
                v_xi, v_eta = v_xi + p * before[a, 1], v_eta + q * before[a, 1]
            inverse = 1.0 / (x_xi * y_eta - x_eta * y_xi)
            s_xx, s_yy, s_xy = neo_hookean_stress(
                (u_xi * y_eta - u_eta * y_xi) * inverse, (u_eta * x_xi - u_xi * x_eta) * inverse,
                (v_xi * y_eta - v_eta * y_xi) * inverse, (v_eta * x_xi - v_xi * x_eta) * inverse, lame, shear,
            )  # fmt: skip
            w = weights[g]
            a_x, b_x = w * (s_xx * y_eta - s_xy * x_eta), w * (s_xy * x_xi - s_xx * y_xi)
            a_y, b_y = w * (s_xy * y_eta - s_yy * x_eta), w * (s_yy * x_xi - s_xy * y_xi)
            for a in range(nodes):
                own[a, 0] += derivatives[g, a, 0] * a_x + derivatives[g, a, 1] * b_x
                own[a, 1] += derivatives[g, a, 0] * a_y + derivatives[g, a, 1] * b_y
        for a in range(nodes):
            force[cells[n, a], 0] += own[a, 0]
            force[cells[n, a], 1] += own[a, 1]
