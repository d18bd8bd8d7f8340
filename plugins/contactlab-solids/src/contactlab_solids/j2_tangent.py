"""Consistent tangent of logarithmic J2 plasticity: the derivative of the stress that `j2_kernels` returns."""

from __future__ import annotations

from math import sqrt

from contactlab.api.compiled.kernel import kernel, log, point
from contactlab_solids.j2_kernels import deviator, mises_squared, wide_factor


@point
def _curvature(r, det, mean, factor):
    """(1/mean - factor)/r^2, the derivative of delta/r by r over r; its series where digits cancel."""
    x = (r / det) ** 2
    series = (-1.0 / 3.0 + x * (0.3 - x * (15.0 / 56.0))) / (det * det * det)
    return (1.0 / mean - factor) / (r * r) if x > 1e-4 else series


@kernel
def tangent(gradient, history, step, slope, out, shear, bulk):
    """Fill out (4, 4, P): d(stress row)/d(row of F^-1).

    history is that of the start of the step, step (P,) the plastic strain of the step and slope (P,) the
    derivative of the yield stress at its end.
    """
    for p in range(gradient.shape[1]):
        a, b, c, d = gradient[0, p], gradient[1, p], gradient[2, p], gradient[3, p]
        half, cross = history[0, p], history[1, p]
        det = a * d - b * c
        log_j = -log(det)
        difference, shearing, mean = deviator(a, b, c, d, half, cross)
        r = sqrt(difference * difference + shearing * shearing)
        factor = wide_factor(r, det, mean, log_j)
        bend = _curvature(r, det, mean, factor)
        s_d, s_x = shear * factor * difference, shear * factor * shearing
        s_z = 2.0 * shear * (history[2, p] - log_j / 3.0)
        mises = sqrt(mises_squared(s_d, s_x, s_z))
        keep, keep_slope = 1.0, 0.0
        if step[p] > 0.0:
            keep = 1.0 - 3.0 * shear * step[p] / mises
            keep_slope = -3.0 * shear * (1.0 / (3.0 * shear + slope[p]) - step[p] / mises) / mises
        first = sqrt(1.0 + half * half + cross * cross)
        first, second = first + half, first - half
        for j in range(4):
            # derivatives of det and of the deviator of A C A^T by a, b, c, d
            if j == 0:
                d_det, d_xx, d_yy, d_xy = d, 0.0, 2.0 * (a * second - c * cross), d * cross - b * second
            elif j == 1:
                d_det, d_xx, d_yy, d_xy = -c, 2.0 * (b * second - d * cross), 0.0, c * cross - a * second
            elif j == 2:
                d_det, d_xx, d_yy, d_xy = -b, 0.0, 2.0 * (c * first - a * cross), b * cross - d * first
            else:
                d_det, d_xx, d_yy, d_xy = a, 2.0 * (d * first - b * cross), 0.0, a * cross - c * first
            d_difference, d_log_j = 0.5 * (d_xx - d_yy), -d_det / det
            d_factor = bend * (difference * d_difference + shearing * d_xy) - d_det / (det * mean)
            d_sd = shear * (d_factor * difference + factor * d_difference)
            d_sx = shear * (d_factor * shearing + factor * d_xy)
            d_sz = -2.0 / 3.0 * shear * d_log_j
            d_keep = 0.0
            if step[p] > 0.0:
                d_keep = keep_slope * (2.25 * s_z * d_sz + 3.0 * (s_d * d_sd + s_x * d_sx)) / mises
            t_d, t_x, t_z = keep * s_d, keep * s_x, keep * s_z
            d_sd, d_sx, d_sz = keep * d_sd + d_keep * s_d, keep * d_sx + d_keep * s_x, keep * d_sz + d_keep * s_z
            middle, d_middle = bulk * log_j - 0.5 * t_z, bulk * d_log_j - 0.5 * d_sz
            out[0, j, p] = (middle + t_d) * d_det + (d_middle + d_sd) * det
            out[1, j, p] = (middle - t_d) * d_det + (d_middle - d_sd) * det
            out[2, j, p] = (bulk * log_j + t_z) * d_det + (bulk * d_log_j + d_sz) * det
            out[3, j, p] = t_x * d_det + d_sx * det
