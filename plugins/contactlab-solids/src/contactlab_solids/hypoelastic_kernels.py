"""Kernels of the rate law: stored stress turned by the step's spin, plus Hooke on the step's strain.

The increment gradient G is referred to the middle of the step, so that with d = sym G and w = skew G the
Hughes-Winget rotation Q = (I - w/2)^-1 (I + w/2) is exact for a rigid rotation of any angle below 180
degrees: G = 2 tan(angle/2) times the unit skew tensor.
"""

from __future__ import annotations

from contactlab.api.kernel import kernel, point


@point
def _turned(xx, yy, xy, spin):
    """Rows xx, yy, xy of Q sigma Q^T, where `spin` is w_xy."""
    h = 0.5 * spin
    scale = 1.0 / (1.0 + h * h)
    c, s = (1.0 - h * h) * scale, 2.0 * h * scale
    mean, half = 0.5 * (xx + yy), 0.5 * (xx - yy)
    cos, sin = c * c - s * s, 2.0 * c * s  # of twice the angle
    turned = cos * half + sin * xy
    return mean + turned, mean - turned, cos * xy - sin * half


@kernel
def stress(gradient, history, stress, lame, shear):
    """Stress rows of the end of the step from those in `history`, which is updated in place."""
    u_x, u_y, v_x, v_y = gradient[0], gradient[1], gradient[2], gradient[3]
    xx, yy, zz, xy = stress[0], stress[1], stress[2], stress[3]
    h_xx, h_yy, h_zz, h_xy = history[0], history[1], history[2], history[3]
    for p in range(u_x.size):
        pressure = lame * (u_x[p] + v_y[p])
        t_xx, t_yy, t_xy = _turned(h_xx[p], h_yy[p], h_xy[p], 0.5 * (u_y[p] - v_x[p]))
        t_xx += pressure + 2.0 * shear * u_x[p]
        t_yy += pressure + 2.0 * shear * v_y[p]
        t_zz = h_zz[p] + pressure
        t_xy += shear * (u_y[p] + v_x[p])
        xx[p], yy[p], zz[p], xy[p] = t_xx, t_yy, t_zz, t_xy
        h_xx[p], h_yy[p], h_zz[p], h_xy[p] = t_xx, t_yy, t_zz, t_xy


@kernel
def tangent(gradient, history, tangent, lame, shear):
    """d(stress row)/d(row of G): Hooke's constants and the turning of the stored stress.

    The angle of Q is 2 atan(w_xy/2); turning further by an angle changes xx, yy, xy at the rates
    2 xy, -2 xy, yy - xx.
    """
    for p in range(gradient.shape[1]):
        spin = 0.5 * (gradient[1, p] - gradient[2, p])
        xx, yy, xy = _turned(history[0, p], history[1, p], history[3, p], spin)
        angle = 0.5 / (1.0 + 0.25 * spin * spin)
        for i in range(4):
            for j in range(4):
                tangent[i, j, p] = 0.0
        for i in range(3):
            tangent[i, 0, p] = tangent[i, 3, p] = lame
        tangent[0, 0, p] += 2.0 * shear
        tangent[1, 3, p] += 2.0 * shear
        tangent[0, 1, p], tangent[0, 2, p] = 2.0 * xy * angle, -2.0 * xy * angle
        tangent[1, 1, p], tangent[1, 2, p] = -2.0 * xy * angle, 2.0 * xy * angle
        tangent[3, 1, p], tangent[3, 2, p] = shear + (yy - xx) * angle, shear - (yy - xx) * angle
