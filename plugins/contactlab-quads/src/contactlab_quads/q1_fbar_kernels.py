"""Kernels of the bilinear quadrilateral with one dilatation per cell.

The gradient's volume change at every point is that of the cell's centre, and forces are what is
conjugate to that (B-bar), so that elastic energy is conserved. With r = J0/J at a point, s its stress in
the plane and m = (s_xx + s_yy)/2, a cell's virtual work is

    sum over points of r dv [(s - m I) : grad(v) + m div0(v)],

div0 being the divergence at the centre; r is 1 where the law counts volume per increment or strains are small.
"""

from __future__ import annotations

from math import sqrt

from contactlab.api.kernel import kernel
from contactlab_quads.q1_kernels import _ETA, _XI, gather, gradient_at, scatter

RATIO = 12  # first of the four scratch rows with r


@kernel
def _small_at(xx, yy, begin, s, ratio):
    """Replace the trace by that of the centre."""
    for c in range(ratio.size):
        p = begin + c
        x1, x2, y1, y2 = s[0, c], s[1, c], s[3, c], s[4, c]
        trace = (s[6, c] * y2 - s[7, c] * y1 + s[10, c] * x1 - s[9, c] * x2) / (x1 * y2 - x2 * y1)
        shift = 0.5 * (trace - xx[p] - yy[p])
        xx[p] += shift
        yy[p] += shift
        ratio[c] = 1.0


@kernel
def _finite_at(xx, xy, yx, yy, begin, s, ratio):
    """Scale F^-1 so that its determinant is that of the centre; keep r = det F^-1 over that."""
    for c in range(ratio.size):
        p = begin + c
        centre = (s[6, c] * s[10, c] - s[7, c] * s[9, c]) / (s[0, c] * s[4, c] - s[1, c] * s[3, c])
        r = (xx[p] * yy[p] - xy[p] * yx[p]) / centre
        scale = 1.0 / sqrt(r)
        xx[p], xy[p], yx[p], yy[p] = scale * xx[p], scale * xy[p], scale * yx[p], scale * yy[p]
        ratio[c] = r


@kernel
def _rate_at(xx, xy, yx, yy, begin, s, ratio):
    """The same for the increment: I - G is its inverse deformation gradient."""
    for c in range(ratio.size):
        p = begin + c
        x1, x2, y1, y2 = s[0, c], s[1, c], s[3, c], s[4, c]
        u1, u2, v1, v2 = x1 - s[6, c], x2 - s[7, c], y1 - s[9, c], y2 - s[10, c]
        centre = (u1 * v2 - u2 * v1) / (x1 * y2 - x2 * y1)
        scale = sqrt(centre / ((1.0 - xx[p]) * (1.0 - yy[p]) - xy[p] * yx[p]))
        xx[p], yy[p] = 1.0 - scale * (1.0 - xx[p]), 1.0 - scale * (1.0 - yy[p])
        xy[p], yx[p] = scale * xy[p], scale * yx[p]
        ratio[c] = 1.0


@kernel
def _all_points(cells, s, out):
    for g in range(4):
        gradient_at(
            _XI[g], _ETA[g], g * cells,
            s[0], s[1], s[2], s[3], s[4], s[5], s[6], s[7], s[8], s[9], s[10], s[11],
            out[0], out[1], out[2], out[3],
        )  # fmt: skip


@kernel
def small_gradient(geometry, field, connectivity, out, scratch):
    """du/dX (4, P) with the trace of the centre at every point."""
    cells = connectivity.shape[1]
    gather(geometry, field, connectivity, scratch)
    _all_points(cells, scratch, out)
    for g in range(4):
        _small_at(out[0], out[3], g * cells, scratch, scratch[RATIO + g])


@kernel
def finite_gradient(geometry, field, connectivity, out, scratch):
    """F^-1 (4, P) with the determinant of the centre at every point."""
    cells = connectivity.shape[1]
    gather(geometry, field, connectivity, scratch)
    _all_points(cells, scratch, out)
    for g in range(4):
        _finite_at(out[0], out[1], out[2], out[3], g * cells, scratch, scratch[RATIO + g])


@kernel
def rate_gradient(geometry, field, connectivity, out, scratch):
    """d(du)/dx (4, P) with the volume ratio of the centre at every point."""
    cells = connectivity.shape[1]
    gather(geometry, field, connectivity, scratch)
    _all_points(cells, scratch, out)
    for g in range(4):
        _rate_at(out[0], out[1], out[2], out[3], g * cells, scratch, scratch[RATIO + g])


@kernel
def _force_at(xi, eta, begin, x1, x2, x3, y1, y2, y3, ratio, sxx, syy, sxy, fx1, fx2, fx3, fy1, fy2, fy3, mean):
    for c in range(x1.size):
        p = begin + c
        x_xi, x_eta = x1[c] + eta * x3[c], x2[c] + xi * x3[c]
        y_xi, y_eta = y1[c] + eta * y3[c], y2[c] + xi * y3[c]
        deviator, xy = 0.5 * ratio[c] * (sxx[p] - syy[p]), ratio[c] * sxy[p]
        mean[c] += 0.5 * ratio[c] * (sxx[p] + syy[p]) * (x_xi * y_eta - x_eta * y_xi)
        a = deviator * y_eta - xy * x_eta
        b = xy * x_xi - deviator * y_xi
        fx1[c] += a
        fx2[c] += b
        fx3[c] += eta * a + xi * b
        a = xy * y_eta + deviator * x_eta
        b = -deviator * x_xi - xy * y_xi
        fy1[c] += a
        fy2[c] += b
        fy3[c] += eta * a + xi * b


@kernel
def _add_mean(mean, x1, x2, y1, y2, fx1, fx2, fy1, fy2):
    for c in range(mean.size):
        m = mean[c] / (x1[c] * y2[c] - x2[c] * y1[c])
        fx1[c] += m * y2[c]
        fx2[c] -= m * y1[c]
        fy1[c] -= m * x2[c]
        fy2[c] += m * x1[c]


@kernel
def force(geometry, connectivity, stress, force, scratch):
    """Add the nodal forces of `stress` (4, P); map and volume ratios are still in `scratch`."""
    s = scratch
    s[6:12] = 0.0
    s[RATIO + 4] = 0.0
    for g in range(4):
        _force_at(
            _XI[g], _ETA[g], g * connectivity.shape[1],
            s[0], s[1], s[2], s[3], s[4], s[5], s[RATIO + g], stress[0], stress[1], stress[3],
            s[6], s[7], s[8], s[9], s[10], s[11], s[RATIO + 4],
        )  # fmt: skip
    _add_mean(s[RATIO + 4], s[0], s[1], s[3], s[4], s[6], s[7], s[9], s[10])
    scatter(connectivity, s, force)
