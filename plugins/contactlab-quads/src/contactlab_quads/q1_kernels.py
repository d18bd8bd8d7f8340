"""Kernels of the bilinear quadrilateral.

A bilinear field is f = (F0 + F1 xi + F2 eta + F3 xi eta)/4, with F1, F2, F3 sums and differences of its
nodal values. The bracket of two such fields,

    [f, g] = f_xi g_eta - f_eta g_xi = ([f, g]_0 + xi [f, g]_1 + eta [f, g]_2)/16,

is linear, and everything that a point needs is a bracket: det J = [x, y], and du/dx = [u, y]/[x, y],
du/dy = [x, u]/[x, y]. So all four Gauss points come from three numbers per bracket, and one division
serves the four of them. Forces go the same way back, from the sums of the stresses over the points.

Gathering and scattering use flat arrays and unsigned numbers: negative indices, which mean "from the
end", would cost a third of the time.
"""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import kernel, point

G = 0.5773502691896258  # 1/sqrt(3)
GEOMETRY, FIELD, INVERSE = 0, 6, 12  # first scratch rows: F1, F2, F3 of x, y; of the field; 1/[x, y] at the points


@point
def _coefficients(a, b, c, d):
    """F1, F2, F3 from the nodal values."""
    low, high = b - a, c - d
    return high + low, (c - b) + (d - a), high - low


@kernel
def gather(geometry, field, connectivity, scratch):
    """Coefficients of x, y and of the field's components into the first twelve rows of scratch."""
    n = connectivity.shape[1]
    node, x, u = connectivity.reshape(4 * n), geometry.reshape(geometry.size), field.reshape(field.size)
    s = scratch.reshape(scratch.size)
    for c in range(n):
        i, j = 2 * np.uint32(node[c]), 2 * np.uint32(node[n + c])
        k, m = 2 * np.uint32(node[2 * n + c]), 2 * np.uint32(node[3 * n + c])
        s[c], s[n + c], s[2 * n + c] = _coefficients(x[i], x[j], x[k], x[m])
        s[3 * n + c], s[4 * n + c], s[5 * n + c] = _coefficients(x[i + 1], x[j + 1], x[k + 1], x[m + 1])
        s[6 * n + c], s[7 * n + c], s[8 * n + c] = _coefficients(u[i], u[j], u[k], u[m])
        s[9 * n + c], s[10 * n + c], s[11 * n + c] = _coefficients(u[i + 1], u[j + 1], u[k + 1], u[m + 1])


@point
def at_points(f1, f2, f3, g1, g2, g3):
    """16 [f, g] at the four Gauss points, counter-clockwise."""
    centre, along, across = f1 * g2 - f2 * g1, G * (f1 * g3 - f3 * g1), G * (f3 * g2 - f2 * g3)
    low, high = centre - along, centre + along
    return low - across, high - across, high + across, low + across


@kernel
def _inverses(x1, x2, x3, y1, y2, y3, first, second, third, fourth):
    for c in range(x1.size):
        a, b, d, e = at_points(x1[c], x2[c], x3[c], y1[c], y2[c], y3[c])
        ab, de = a * b, d * e
        both = 1.0 / (ab * de)
        ab, de = both * de, both * ab
        first[c], second[c], third[c], fourth[c] = ab * b, ab * a, de * e, de * d


@kernel
def _quotient(f1, f2, f3, g1, g2, g3, i0, i1, i2, i3, first, second, third, fourth):
    for c in range(f1.size):
        a, b, d, e = at_points(f1[c], f2[c], f3[c], g1[c], g2[c], g3[c])
        first[c], second[c], third[c], fourth[c] = a * i0[c], b * i1[c], d * i2[c], e * i3[c]


@kernel
def quotients(s, f, g, row):
    """[f, g]/[x, y] at the points into `row`; f and g are first rows of coefficients in scratch."""
    n, i = s.shape[1], INVERSE
    _quotient(
        s[f], s[f + 1], s[f + 2], s[g], s[g + 1], s[g + 2], s[i], s[i + 1], s[i + 2], s[i + 3],
        row[:n], row[n : 2 * n], row[2 * n : 3 * n], row[3 * n :],
    )  # fmt: skip


@kernel
def gradient(geometry, field, connectivity, out, scratch):
    """d(field)/d(geometry) (4, P) at the 2x2 points."""
    s = scratch
    gather(geometry, field, connectivity, s)
    _inverses(s[0], s[1], s[2], s[3], s[4], s[5], s[12], s[13], s[14], s[15])
    quotients(s, 6, 3, out[0])
    quotients(s, 0, 6, out[1])
    quotients(s, 9, 3, out[2])
    quotients(s, 0, 9, out[3])


@kernel
def _component(x1, x2, x3, y1, y2, y3, p0, p1, p2, p3, q0, q1, q2, q3, sign, f1, f2, f3):
    for c in range(x1.size):
        low, high, right, left = p0[c] + p1[c], p2[c] + p3[c], p1[c] + p2[c], p0[c] + p3[c]
        p, p_xi, p_eta = 0.0625 * (low + high), 0.0625 * G * (right - left), 0.0625 * G * (high - low)
        low, high, right, left = q0[c] + q1[c], q2[c] + q3[c], q1[c] + q2[c], q0[c] + q3[c]
        factor = 0.0625 * sign
        q, q_xi, q_eta = factor * (low + high), factor * G * (right - left), factor * G * (high - low)
        f1[c] = y2[c] * p + y3[c] * p_xi - x2[c] * q - x3[c] * q_xi
        f2[c] = x1[c] * q + x3[c] * q_eta - y1[c] * p - y3[c] * p_eta
        f3[c] = y2[c] * p_eta - x2[c] * q_eta + x1[c] * q_xi - y1[c] * p_xi


@kernel
def component(s, p, q, sign, row):
    """Put a force component's coefficients into scratch rows row ... row + 2: stresses p along x, sign q along y."""
    n = s.shape[1]
    _component(
        s[0], s[1], s[2], s[3], s[4], s[5], p[:n], p[n : 2 * n], p[2 * n : 3 * n], p[3 * n :],
        q[:n], q[n : 2 * n], q[2 * n : 3 * n], q[3 * n :], sign, s[row], s[row + 1], s[row + 2],
    )  # fmt: skip


@kernel
def scatter(connectivity, scratch, force):
    """Add nodal forces from their coefficients, rows 6 to 11 of scratch."""
    n = connectivity.shape[1]
    node, f, s = connectivity.reshape(4 * n), force.reshape(force.size), scratch.reshape(scratch.size)
    for c in range(n):
        x1, x2, x3 = s[6 * n + c], s[7 * n + c], s[8 * n + c]
        y1, y2, y3 = s[9 * n + c], s[10 * n + c], s[11 * n + c]
        i = 2 * np.uint32(node[c])
        f[i] += x3 - x1 - x2
        f[i + 1] += y3 - y1 - y2
        i = 2 * np.uint32(node[n + c])
        f[i] += x1 - x2 - x3
        f[i + 1] += y1 - y2 - y3
        i = 2 * np.uint32(node[2 * n + c])
        f[i] += x1 + x2 + x3
        f[i + 1] += y1 + y2 + y3
        i = 2 * np.uint32(node[3 * n + c])
        f[i] += x2 - x1 - x3
        f[i + 1] += y2 - y1 - y3


@kernel
def force(geometry, connectivity, stress, force, scratch):
    """Add the nodal forces of `stress` (4, P); the coefficients of x, y are still in `scratch`."""
    component(scratch, stress[0], stress[3], 1.0, 6)
    component(scratch, stress[3], stress[1], 1.0, 9)
    scatter(connectivity, scratch, force)
