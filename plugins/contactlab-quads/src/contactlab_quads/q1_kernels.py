"""Kernels of the bilinear quadrilateral.

A bilinear field is f = f0 + f1 xi + f2 eta + f3 xi eta, so its parent gradient at any point is
(f1 + f3 eta, f2 + f3 xi): three coefficients per component instead of four nodal values and eight
slopes. Forces go the same way back.
"""

from __future__ import annotations

from contactlab.api.kernel import kernel, point

_G = 0.5773502691896258  # 1/sqrt(3)
_XI = (-_G, _G, _G, -_G)
_ETA = (-_G, -_G, _G, _G)


@point
def _coefficients(values, component, i, j, k, m):
    a, b, c, d = values[i, component], values[j, component], values[k, component], values[m, component]
    return 0.25 * ((b - a) + (c - d)), 0.25 * ((c - b) + (d - a)), 0.25 * ((c - d) - (b - a))


@kernel
def gather(geometry, field, connectivity, scratch):
    """Coefficients 1, 2, 3 of geometry x, y and field u, v into the first twelve rows of scratch."""
    first, second, third, fourth = connectivity[0], connectivity[1], connectivity[2], connectivity[3]
    for c in range(connectivity.shape[1]):
        i, j, k, m = first[c], second[c], third[c], fourth[c]
        scratch[0, c], scratch[1, c], scratch[2, c] = _coefficients(geometry, 0, i, j, k, m)
        scratch[3, c], scratch[4, c], scratch[5, c] = _coefficients(geometry, 1, i, j, k, m)
        scratch[6, c], scratch[7, c], scratch[8, c] = _coefficients(field, 0, i, j, k, m)
        scratch[9, c], scratch[10, c], scratch[11, c] = _coefficients(field, 1, i, j, k, m)


@kernel
def gradient_at(xi, eta, begin, x1, x2, x3, y1, y2, y3, u1, u2, u3, v1, v2, v3, xx, xy, yx, yy):
    """d(field)/d(geometry) at one point of every cell."""
    for c in range(x1.size):
        x_xi, x_eta = x1[c] + eta * x3[c], x2[c] + xi * x3[c]
        y_xi, y_eta = y1[c] + eta * y3[c], y2[c] + xi * y3[c]
        u_xi, u_eta = u1[c] + eta * u3[c], u2[c] + xi * u3[c]
        v_xi, v_eta = v1[c] + eta * v3[c], v2[c] + xi * v3[c]
        inverse = 1.0 / (x_xi * y_eta - x_eta * y_xi)
        xx[begin + c] = (u_xi * y_eta - u_eta * y_xi) * inverse
        xy[begin + c] = (u_eta * x_xi - u_xi * x_eta) * inverse
        yx[begin + c] = (v_xi * y_eta - v_eta * y_xi) * inverse
        yy[begin + c] = (v_eta * x_xi - v_xi * x_eta) * inverse


@kernel
def gradient(geometry, field, connectivity, out, scratch):
    """d(field)/d(geometry) (4, P) at the 2x2 points."""
    gather(geometry, field, connectivity, scratch)
    s = scratch
    for g in range(4):
        gradient_at(
            _XI[g], _ETA[g], g * connectivity.shape[1],
            s[0], s[1], s[2], s[3], s[4], s[5], s[6], s[7], s[8], s[9], s[10], s[11],
            out[0], out[1], out[2], out[3],
        )  # fmt: skip


@kernel
def _force_at(xi, eta, begin, x1, x2, x3, y1, y2, y3, sxx, syy, sxy, fx1, fx2, fx3, fy1, fy2, fy3):
    for c in range(x1.size):
        p = begin + c
        x_xi, x_eta = x1[c] + eta * x3[c], x2[c] + xi * x3[c]
        y_xi, y_eta = y1[c] + eta * y3[c], y2[c] + xi * y3[c]
        a = sxx[p] * y_eta - sxy[p] * x_eta
        b = sxy[p] * x_xi - sxx[p] * y_xi
        fx1[c] += a
        fx2[c] += b
        fx3[c] += eta * a + xi * b
        a = sxy[p] * y_eta - syy[p] * x_eta
        b = syy[p] * x_xi - sxy[p] * y_xi
        fy1[c] += a
        fy2[c] += b
        fy3[c] += eta * a + xi * b


@kernel
def scatter(connectivity, s, force):
    """Add nodal forces from their coefficients in rows 6 to 11 of scratch."""
    first, second, third, fourth = connectivity[0], connectivity[1], connectivity[2], connectivity[3]
    for component in range(2):
        row = 6 + 3 * component
        for c in range(connectivity.shape[1]):
            a, b, d = 0.25 * s[row, c], 0.25 * s[row + 1, c], 0.25 * s[row + 2, c]
            force[first[c], component] += d - a - b
            force[second[c], component] += a - b - d
            force[third[c], component] += a + b + d
            force[fourth[c], component] += b - a - d


@kernel
def force(geometry, connectivity, stress, force, scratch):
    """Add the nodal forces of `stress` (4, P); the map's coefficients are still in `scratch`."""
    s = scratch
    s[6:12] = 0.0
    for g in range(4):
        _force_at(
            _XI[g], _ETA[g], g * connectivity.shape[1],
            s[0], s[1], s[2], s[3], s[4], s[5], stress[0], stress[1], stress[3],
            s[6], s[7], s[8], s[9], s[10], s[11],
        )  # fmt: skip
    scatter(connectivity, s, force)
