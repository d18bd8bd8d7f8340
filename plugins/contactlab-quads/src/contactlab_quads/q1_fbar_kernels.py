"""Kernels of the bilinear quadrilateral with one dilatation per cell.

The gradient's volume change at every point is taken from the cell's centre, and forces are conjugate
to it (B-bar), so that elastic energy is conserved. With r = J0/J at a point, s its stress in
the plane and m = (s_xx + s_yy)/2, a cell's virtual work is

    sum over points of r dv [(s - m I) : grad(v) + m div0(v)],

div0 being the divergence at the centre; r is 1 if the law counts volume per increment or strains are
small. Brackets and coefficients as in `q1_kernels`.
"""

from __future__ import annotations

from math import sqrt

from contactlab.api.compiled.kernel import kernel
from contactlab_quads.q1_kernels import at_points, component, scatter
from contactlab_quads.q1_kernels import gradient as plain_gradient

RATIO, DEVIATOR, SHEAR, MEAN = 12, 16, 20, 24  # first scratch rows: r, r (s_xx - s_yy)/2 and r s_xy at the points; mean


@kernel
def _small(x1, x2, y1, y2, u1, u2, v1, v2, xx, yy, ratio):
    for c in range(x1.size):
        trace = (u1[c] * y2[c] - u2[c] * y1[c] + v2[c] * x1[c] - v1[c] * x2[c]) / (x1[c] * y2[c] - x2[c] * y1[c])
        shift = 0.5 * (trace - xx[c] - yy[c])
        xx[c] += shift
        yy[c] += shift
        ratio[c] = 1.0


@kernel
def _finite(x1, x2, y1, y2, u1, u2, v1, v2, xx, xy, yx, yy, ratio):
    for c in range(x1.size):
        centre = (u1[c] * v2[c] - u2[c] * v1[c]) / (x1[c] * y2[c] - x2[c] * y1[c])
        r = (xx[c] * yy[c] - xy[c] * yx[c]) / centre
        scale = 1.0 / sqrt(r)
        xx[c], xy[c], yx[c], yy[c] = scale * xx[c], scale * xy[c], scale * yx[c], scale * yy[c]
        ratio[c] = r


@kernel
def _rate(x1, x2, y1, y2, u1, u2, v1, v2, xx, xy, yx, yy, ratio):
    for c in range(x1.size):
        # coefficients of x - u, whose gradient I - G is the inverse of the step's deformation gradient
        a1, a2, b1, b2 = x1[c] - u1[c], x2[c] - u2[c], y1[c] - v1[c], y2[c] - v2[c]
        centre = (a1 * b2 - a2 * b1) / (x1[c] * y2[c] - x2[c] * y1[c])
        scale = sqrt(centre / ((1.0 - xx[c]) * (1.0 - yy[c]) - xy[c] * yx[c]))
        xx[c], yy[c] = 1.0 - scale * (1.0 - xx[c]), 1.0 - scale * (1.0 - yy[c])
        xy[c], yx[c] = scale * xy[c], scale * yx[c]
        ratio[c] = 1.0


@kernel
def small_gradient(geometry, field, connectivity, out, scratch):
    """du/dX (4, P) with the trace of the centre at every point."""
    plain_gradient(geometry, field, connectivity, out, scratch)
    s, n = scratch, connectivity.shape[1]
    for g in range(4):
        xx, yy = out[0, g * n : (g + 1) * n], out[3, g * n : (g + 1) * n]
        _small(s[0], s[1], s[3], s[4], s[6], s[7], s[9], s[10], xx, yy, s[RATIO + g])


@kernel
def finite_gradient(geometry, field, connectivity, out, scratch):
    """F^-1 (4, P) scaled to the determinant at the centre; r = det F^-1 over that is kept."""
    plain_gradient(geometry, field, connectivity, out, scratch)
    s, n = scratch, connectivity.shape[1]
    for g in range(4):
        xx, xy = out[0, g * n : (g + 1) * n], out[1, g * n : (g + 1) * n]
        yx, yy = out[2, g * n : (g + 1) * n], out[3, g * n : (g + 1) * n]
        _finite(s[0], s[1], s[3], s[4], s[6], s[7], s[9], s[10], xx, xy, yx, yy, s[RATIO + g])


@kernel
def rate_gradient(geometry, field, connectivity, out, scratch):
    """d(du)/dx (4, P) with the step's volume ratio of the centre at every point."""
    plain_gradient(geometry, field, connectivity, out, scratch)
    s, n = scratch, connectivity.shape[1]
    for g in range(4):
        xx, xy = out[0, g * n : (g + 1) * n], out[1, g * n : (g + 1) * n]
        yx, yy = out[2, g * n : (g + 1) * n], out[3, g * n : (g + 1) * n]
        _rate(s[0], s[1], s[3], s[4], s[6], s[7], s[9], s[10], xx, xy, yx, yy, s[RATIO + g])


@kernel
def _split(sxx, syy, sxy, ratio, deviator, shear):
    for c in range(ratio.size):
        deviator[c] = 0.5 * ratio[c] * (sxx[c] - syy[c])
        shear[c] = ratio[c] * sxy[c]


@kernel
def _mean(x1, x2, x3, y1, y2, y3, sxx, syy, r0, r1, r2, r3, mean):
    """Sum of m r dv over the points, over 16 det J of the centre."""
    n = x1.size
    for c in range(n):
        a, b, d, e = at_points(x1[c], x2[c], x3[c], y1[c], y2[c], y3[c])
        total = a * r0[c] * (sxx[c] + syy[c]) + b * r1[c] * (sxx[n + c] + syy[n + c])
        total += d * r2[c] * (sxx[2 * n + c] + syy[2 * n + c]) + e * r3[c] * (sxx[3 * n + c] + syy[3 * n + c])
        mean[c] = 0.03125 * total / (x1[c] * y2[c] - x2[c] * y1[c])


@kernel
def _add_mean(mean, x1, x2, y1, y2, fx1, fx2, fy1, fy2):
    for c in range(mean.size):
        fx1[c] += mean[c] * y2[c]
        fx2[c] -= mean[c] * y1[c]
        fy1[c] -= mean[c] * x2[c]
        fy2[c] += mean[c] * x1[c]


@kernel
def force(geometry, connectivity, stress, force, scratch):
    """Add the nodal forces of `stress` (4, P); coefficients and volume ratios are still in `scratch`."""
    s, n = scratch, connectivity.shape[1]
    for g in range(4):
        xx, yy = stress[0, g * n : (g + 1) * n], stress[1, g * n : (g + 1) * n]
        xy = stress[3, g * n : (g + 1) * n]
        _split(xx, yy, xy, s[RATIO + g], s[DEVIATOR + g], s[SHEAR + g])
    _mean(
        s[0], s[1], s[2], s[3], s[4], s[5], stress[0], stress[1], s[RATIO], s[RATIO + 1], s[RATIO + 2], s[RATIO + 3],
        s[MEAN],
    )  # fmt: skip
    deviator, shear = s[DEVIATOR : DEVIATOR + 4].reshape(4 * n), s[SHEAR : SHEAR + 4].reshape(4 * n)
    component(s, deviator, shear, 1.0, 6)
    component(s, shear, deviator, -1.0, 9)
    _add_mean(s[MEAN], s[0], s[1], s[3], s[4], s[6], s[7], s[9], s[10])
    scatter(connectivity, s, force)
