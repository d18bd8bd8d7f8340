"""Fastest waves in strained points, from a tangent of "finite" laws."""

from __future__ import annotations

from math import sqrt

from contactlab.api.compiled.kernel import kernel, point


@point
def by_angle(one, two, three, i, along, across):
    """Return a number of point i at an angle of the cosine `along` and the sine `across`."""
    return one[i] + along * two[i] + across * three[i]


@kernel
def waves(gradient, tangent, cosines, sines, parts, most, least):
    """Fill the largest and smallest (P,) of the moduli of the fastest waves in some directions; NaN gives NaN.

    The acoustic tensor of a plane wave along n with displacement u is Q u = d(stress) n under the motion u n^T, on the
    current geometry (Ogden 1984, 6.4): F' = (1 + u n^T) F changes the given F^-1 by -F^-1 u n^T. Q is quadratic in n,
    so (Q_xx + Q_yy)/2, (Q_xx - Q_yy)/2 and Q_xy of its symmetric part are sums of 1 and of the cosine and the sine of
    twice the angle of n; `parts` (9, P) are their coefficients.
    """
    a, b, c, d = gradient[0], gradient[1], gradient[2], gradient[3]
    xx, yy, xy = tangent[0], tangent[1], tangent[3]
    for i in range(a.size):
        # R_km: change of a stress row R by u_k n_m
        xx_xx, xx_xy = -xx[0, i] * a[i] - xx[2, i] * c[i], -xx[1, i] * a[i] - xx[3, i] * c[i]
        xx_yx, xx_yy = -xx[0, i] * b[i] - xx[2, i] * d[i], -xx[1, i] * b[i] - xx[3, i] * d[i]
        xy_xx, xy_xy = -xy[0, i] * a[i] - xy[2, i] * c[i], -xy[1, i] * a[i] - xy[3, i] * c[i]
        xy_yx, xy_yy = -xy[0, i] * b[i] - xy[2, i] * d[i], -xy[1, i] * b[i] - xy[3, i] * d[i]
        yy_xx, yy_xy = -yy[0, i] * a[i] - yy[2, i] * c[i], -yy[1, i] * a[i] - yy[3, i] * c[i]
        yy_yx, yy_yy = -yy[0, i] * b[i] - yy[2, i] * d[i], -yy[1, i] * b[i] - yy[3, i] * d[i]
        # Q_xx of n_x^2, n_y^2 and n_x n_y, then Q_yy and the mean of Q_xy and Q_yx
        one, two, three = xx_xx, xy_xy, xx_xy + xy_xx
        four, five, six = xy_yx, yy_yy, xy_yy + yy_yx
        seven, eight = 0.5 * (xx_yx + xy_xx), 0.5 * (xy_yy + yy_xy)
        nine = 0.5 * (xx_yy + xy_yx + xy_xy + yy_xx)
        parts[0, i], parts[1, i] = 0.25 * (one + two + four + five), 0.25 * (one - two + four - five)
        parts[2, i] = 0.25 * (three + six)
        parts[3, i], parts[4, i] = 0.25 * (one + two - four - five), 0.25 * (one - two - four + five)
        parts[5, i] = 0.25 * (three - six)
        parts[6, i], parts[7, i], parts[8, i] = 0.5 * (seven + eight), 0.5 * (seven - eight), 0.5 * nine
        most[i], least[i] = -1e300, 1e300
    m0, m1, m2, h0, h1, h2 = parts[0], parts[1], parts[2], parts[3], parts[4], parts[5]
    o0, o1, o2 = parts[6], parts[7], parts[8]
    for k in range(cosines.size):
        along, across = cosines[k], sines[k]
        for i in range(a.size):
            half, off = by_angle(h0, h1, h2, i, along, across), by_angle(o0, o1, o2, i, along, across)
            found = by_angle(m0, m1, m2, i, along, across) + sqrt(half * half + off * off)
            # NaN is kept
            most[i] = most[i] if most[i] > found else found
            least[i] = least[i] if least[i] < found else found
