"""Kernels of the rate law: stored stress turned by the step's spin, plus Hooke on the step's strain.

The increment gradient G is referred to the middle of the step, so that with d = sym G and w = skew G the
Hughes-Winget rotation Q = (I - w/2)^-1 (I + w/2) is exact for a rigid rotation of any angle below 180
degrees: G = 2 tan(angle/2) times the unit skew tensor. Hooke's increment belongs to the middle of the
step: the stress turns half the way, takes it, and turns on, which makes the law second order in the step
(added at the end it is first order: 1e-3 of the modulus in simple shear of 1 in 400 steps).
"""

from __future__ import annotations

from contactlab.api.compiled.kernel import kernel, point


@point
def _half_turn(spin):
    """Cosine and sine of twice half the angle of Q, where `spin` is w_xy: what turns a stress half the way."""
    h = 0.5 * spin
    scale = 1.0 / (1.0 + h * h)
    return (1.0 - h * h) * scale, 2.0 * h * scale


@kernel
def stress(gradient, history, stress, lame, shear):
    """Stress rows of the end of the step from those in `history`, which is updated in place."""
    u_x, u_y, v_x, v_y = gradient[0], gradient[1], gradient[2], gradient[3]
    xx, yy, zz, xy = stress[0], stress[1], stress[2], stress[3]
    h_xx, h_yy, h_zz, h_xy = history[0], history[1], history[2], history[3]
    for p in range(u_x.size):
        c, s = _half_turn(0.5 * (u_y[p] - v_x[p]))
        mean, half = 0.5 * (h_xx[p] + h_yy[p]), 0.5 * (h_xx[p] - h_yy[p])
        trace = u_x[p] + v_y[p]
        mean += (lame + shear) * trace
        middle = c * half + s * h_xy[p] + shear * (u_x[p] - v_y[p])
        shearing = c * h_xy[p] - s * half + shear * (u_y[p] + v_x[p])
        half, t_xy = c * middle + s * shearing, c * shearing - s * middle
        t_zz = h_zz[p] + lame * trace
        xx[p], yy[p], zz[p], xy[p] = mean + half, mean - half, t_zz, t_xy
        h_xx[p], h_yy[p], h_zz[p], h_xy[p] = mean + half, mean - half, t_zz, t_xy


@kernel
def tangent(gradient, history, tangent, lame, shear):
    """d(stress row)/d(row of G): Hooke's constants turned half the way, and the turning of the stress.

    The half difference and the shear of the stress are a plane vector that turns by the angle of Q before
    and after Hooke's increment; that angle is 2 atan(w_xy/2).
    """
    for p in range(gradient.shape[1]):
        spin = 0.5 * (gradient[1, p] - gradient[2, p])
        c, s = _half_turn(spin)
        half, xy = 0.5 * (history[0, p] - history[1, p]), history[3, p]
        middle = c * half + s * xy + shear * (gradient[0, p] - gradient[3, p])
        shearing = c * xy - s * half + shear * (gradient[1, p] + gradient[2, p])
        # derivatives by the spin: of the first turn, then of the second
        angle = 1.0 / (1.0 + 0.25 * spin * spin)
        d_middle, d_shearing = (c * xy - s * half) * angle, -(c * half + s * xy) * angle
        d_half = c * d_middle + s * d_shearing + (c * shearing - s * middle) * angle
        d_xy = c * d_shearing - s * d_middle - (c * middle + s * shearing) * angle
        for j in range(4):
            trace = 1.0 if j == 0 or j == 3 else 0.0
            by_middle = (shear if j == 0 else -shear) * trace
            by_shearing, by_spin = shear * (1.0 - trace), (0.5 if j == 1 else -0.5) * (1.0 - trace)
            mean = (lame + shear) * trace
            turned = c * by_middle + s * by_shearing + d_half * by_spin
            tangent[0, j, p] = mean + turned
            tangent[1, j, p] = mean - turned
            tangent[2, j, p] = lame * trace
            tangent[3, j, p] = c * by_shearing - s * by_middle + d_xy * by_spin
