"""Kernels of J2 plasticity in logarithmic elastic strains (see `j2`).

The elastic state of a point is its unimodular in-plane plastic metric C = Cp^-1/sqrt(det) and the elastic
logarithmic strain zz. With the rows a, b, c, d of F^-1, D = det F^-1 and A = adj F^-1, the in-plane
elastic left Cauchy-Green tensor is A C A^T up to a factor, which ln J and the strain zz determine. So

    delta = e_1 - e_2 = asinh(r/D),  r^2 = d^2 + x^2,   d, x = deviator (half difference, shear) of A C A^T
    s_d, s_x = mu delta (d, x)/r,    s_z = 2 mu (e_z - ln J/3),    tau = K ln J + s

need no eigenvectors, and a radial return scales s. History rows: half difference and shear of C,
strain zz, equivalent plastic strain, and (power law) the rise of the yield stress.

The work is cut so that the cost of a block depends on its points. `trial` gives the stress of an elastic step
and counts the points that yield; a return takes those. Divisions and roots cost as much as twenty
products, so series stand in for functions of small numbers, elastic strains of metals and short steps;
points beyond a series are counted, left alone, and taken by a general kernel afterwards. Which function
serves a point depends on that point alone, never on its neighbours.
"""

from __future__ import annotations

from math import sqrt

from contactlab.api.compiled.kernel import exp, kernel, log, point

NARROW = 0.0064  # (r/D)^2 up to which eight terms of asinh are exact: elastic strains that differ by 8 %
SLIGHT = 0.03  # |D - 1| up to which eleven terms of the logarithm are exact
WEAK = 0.3  # Mises stress over shear modulus up to which five terms of cosh are exact
REACH = 0.01  # plastic step over (e0 + ep) up to which the binomial series of the power is exact
THIRD = 1.0 / 3.0


@point
def deviator(a, b, c, d, half, cross):
    """Half difference, shear and mean of A C A^T."""
    mean = sqrt(1.0 + half * half + cross * cross)
    first, second = mean + half, mean - half
    xx = d * d * first - 2.0 * b * d * cross + b * b * second
    yy = c * c * first - 2.0 * a * c * cross + a * a * second
    xy = (a * d + b * c) * cross - c * d * first - a * b * second
    return 0.5 * (xx - yy), xy, 0.5 * (xx + yy)


@point
def _asinh_over(x):
    """asinh(s)/s for x = s^2 up to `NARROW`."""
    p = -429.0 / 30720.0
    p = p * x + 231.0 / 13312.0
    p = p * x - 63.0 / 2816.0
    p = p * x + 35.0 / 1152.0
    p = p * x - 5.0 / 112.0
    p = p * x + 3.0 / 40.0
    p = p * x - 1.0 / 6.0
    return p * x + 1.0


@point
def _log_and_inverse(det):
    """ln(det) and 1/det for det within `SLIGHT` of 1."""
    x = det - 1.0
    p = 1.0 / 11.0
    p = 1.0 / 10.0 - p * x
    p = 1.0 / 9.0 - p * x
    p = 1.0 / 8.0 - p * x
    p = 1.0 / 7.0 - p * x
    p = 1.0 / 6.0 - p * x
    p = 1.0 / 5.0 - p * x
    p = 1.0 / 4.0 - p * x
    p = 1.0 / 3.0 - p * x
    p = 0.5 - p * x
    square = x * x
    fourth = square * square
    return x - square * p, (1.0 - x) * (1.0 + square) * (1.0 + fourth) * (1.0 + fourth * fourth)


@point
def wide_factor(r, det, mean, log_j):
    """delta/r, and its limit 1/det if the in-plane elastic strain is a pure change of area."""
    return (log(mean + r) + log_j) / r if r > 1e-14 * mean else 1.0 / det


@point
def mises_squared(s_d, s_x, s_z):
    """Square of Mises' stress from the stress rows."""
    return 2.25 * s_z * s_z + 3.0 * (s_d * s_d + s_x * s_x)


@point
def _elastic(det, log_j, factor, difference, shearing, strain_zz, shear, bulk):
    """Cauchy stress rows and the square of Mises' Kirchhoff stress."""
    s_d, s_x, s_z = factor * difference, factor * shearing, 2.0 * shear * (strain_zz - THIRD * log_j)
    pressure = bulk * log_j
    middle = pressure - 0.5 * s_z
    mises = mises_squared(s_d, s_x, s_z)
    return (middle + s_d) * det, (middle - s_d) * det, (pressure + s_z) * det, s_x * det, mises


@kernel
def trial(gradient, history, stress, shear, bulk, yield_stress, slope, slope_row):
    """Cauchy stress of an elastic step; the numbers of points that yield and of points beyond the series.

    The yield stress is yield_stress + slope * history[slope_row].
    """
    g_xx, g_xy, g_yx, g_yy = gradient[0], gradient[1], gradient[2], gradient[3]
    xx, yy, zz, xy = stress[0], stress[1], stress[2], stress[3]
    half, cross, strain_zz, rise = history[0], history[1], history[2], history[slope_row]
    yielding, wide = 0, 0
    for p in range(g_xx.size):
        a, b, c, d = g_xx[p], g_xy[p], g_yx[p], g_yy[p]
        det = a * d - b * c
        log_det, inverse = _log_and_inverse(det)
        difference, shearing, _ = deviator(a, b, c, d, half[p], cross[p])
        square = (difference * difference + shearing * shearing) * inverse * inverse
        factor = shear * inverse * _asinh_over(square)
        xx[p], yy[p], zz[p], xy[p], mises = _elastic(
            det, -log_det, factor, difference, shearing, strain_zz[p], shear, bulk
        )
        strong = yield_stress + slope * rise[p]
        yielding += 1 if mises > strong * strong else 0
        wide += 0 if square <= NARROW and abs(det - 1.0) <= SLIGHT else 1
    return yielding, wide


@kernel
def wide_trial(gradient, history, stress, shear, bulk, all_points):
    """The same for points beyond the series, or for all."""
    for p in range(gradient.shape[1]):
        a, b, c, d = gradient[0, p], gradient[1, p], gradient[2, p], gradient[3, p]
        det = a * d - b * c
        _, inverse = _log_and_inverse(det)
        difference, shearing, mean = deviator(a, b, c, d, history[0, p], history[1, p])
        square = difference * difference + shearing * shearing
        if not all_points and square * inverse * inverse <= NARROW and abs(det - 1.0) <= SLIGHT:
            continue
        log_j = -log(det)
        factor = shear * wide_factor(sqrt(square), det, mean, log_j)
        stress[0, p], stress[1, p], stress[2, p], stress[3, p], _ = _elastic(
            det, log_j, factor, difference, shearing, history[2, p], shear, bulk
        )


@point
def _kirchhoff(xx, yy, zz, xy, det):
    """s_d, s_x, s_z, Mises' stress, its inverse, and pressure of tau = sigma/det F^-1; then 1/det.

    One division for all. A point without stress gets nan, does not yield, and keeps what it has.
    """
    mean = THIRD * (xx + yy + zz)
    s_d, s_z = 0.5 * (xx - yy), zz - mean
    cauchy = sqrt(mises_squared(s_d, xy, s_z))
    both = 1.0 / (det * cauchy)
    inverse = both * cauchy
    return inverse * s_d, inverse * xy, inverse * s_z, inverse * cauchy, both * det * det, inverse * mean, inverse


@point
def _weak_cosh(x):
    """cosh(s) and sinh(s)/s for x = s^2 of weak stresses."""
    p, q = 1.0 / 40320.0, 1.0 / 362880.0
    p, q = p * x + 1.0 / 720.0, q * x + 1.0 / 5040.0
    p, q = p * x + 1.0 / 24.0, q * x + 1.0 / 120.0
    p, q = p * x + 0.5, q * x + 1.0 / 6.0
    return p * x + 1.0, q * x + 1.0


@point
def _any_cosh(x):
    """Compute what `_cosh` does, for stresses of any size."""
    s = sqrt(x)
    grown = exp(s)
    inverse = 1.0 / grown
    return 0.5 * (grown + inverse), 0.5 * (grown - inverse) / s if s > 1e-8 else 1.0


@point
def _metric(a, b, c, d, inverse, u, v, cosh, ratio):
    """Half difference and shear of C = F^-1 B F^-T/det, B unimodular with logarithmic deviator u, v."""
    u, v = ratio * u, ratio * v
    half = 0.5 * (cosh * (a * a + b * b - c * c - d * d) + u * (a * a + d * d - b * b - c * c)) + v * (a * b - c * d)
    cross = cosh * (a * c + b * d) + u * (a * c - b * d) + v * (a * d + b * c)
    return half * inverse, cross * inverse


@point
def _return(p, g, history, stress, det, tau, step, shear, compliance, softness, weak):
    """Take the plastic strain `step`, if it is positive, from the trial `tau` and write what follows.

    `weak` is a constant at every call: only one of the two functions is compiled in.
    """
    s_d, s_x, s_z, _, over, pressure, inverse = tau
    keep = 1.0 - 3.0 * shear * step * over
    s_d, s_x, s_z = keep * s_d, keep * s_x, keep * s_z
    u, v = compliance * s_d, compliance * s_x
    cosh, ratio = _weak_cosh(u * u + v * v) if weak else _any_cosh(u * u + v * v)
    half, cross = _metric(g[0, p], g[1, p], g[2, p], g[3, p], inverse, u, v, cosh, ratio)
    yields = step > 0.0
    history[0, p] = half if yields else history[0, p]
    history[1, p] = cross if yields else history[1, p]
    history[2, p] = 0.5 * compliance * s_z + softness * pressure if yields else history[2, p]
    history[3, p] = history[3, p] + step if yields else history[3, p]
    middle = pressure - 0.5 * s_z
    stress[0, p] = (middle + s_d) * det if yields else stress[0, p]
    stress[1, p] = (middle - s_d) * det if yields else stress[1, p]
    stress[2, p] = (pressure + s_z) * det if yields else stress[2, p]
    stress[3, p] = s_x * det if yields else stress[3, p]


@kernel
def linear_return(gradient, history, stress, shear, bulk, yield_stress, hardening):
    """sigma_y = yield_stress + hardening * ep: the return is linear. Returns how many stresses are not weak."""
    compliance, softness, per_stress = 1.0 / shear, THIRD / bulk, 1.0 / (3.0 * shear + hardening)
    left = 0
    for p in range(gradient.shape[1]):
        det = gradient[0, p] * gradient[3, p] - gradient[1, p] * gradient[2, p]
        tau = _kirchhoff(stress[0, p], stress[1, p], stress[2, p], stress[3, p], det)
        excess = tau[3] - (yield_stress + hardening * history[3, p])
        step = per_stress * excess if excess > 0.0 and tau[3] <= WEAK * shear else 0.0
        left += 1 if tau[3] > WEAK * shear else 0
        _return(p, gradient, history, stress, det, tau, step, shear, compliance, softness, True)
    return left


@kernel
def far_linear_return(gradient, history, stress, shear, bulk, yield_stress, hardening):
    """Compute what `linear_return` does, for stresses that are not weak."""
    compliance, softness, per_stress = 1.0 / shear, THIRD / bulk, 1.0 / (3.0 * shear + hardening)
    for p in range(gradient.shape[1]):
        det = gradient[0, p] * gradient[3, p] - gradient[1, p] * gradient[2, p]
        tau = _kirchhoff(stress[0, p], stress[1, p], stress[2, p], stress[3, p], det)
        excess = tau[3] - (yield_stress + hardening * history[3, p])
        if excess > 0.0 and tau[3] > WEAK * shear:
            _return(p, gradient, history, stress, det, tau, per_stress * excess, shear, compliance, softness, False)


@point
def _near_step(mises, start, strong, shear, exponent, b2, b3, b4, b5, b6, b7, b8):
    """Plastic step that is small against `start` = e0 + ep.

    Newton from the tangent at the start, which is kept; b are the binomial coefficients of (1 + x)^n.
    """
    slope = 3.0 * shear * start + exponent * strong
    both = 1.0 / (start * slope)
    inverse, per_stress = both * slope, both * start * start
    excess = mises - strong
    step = per_stress * excess
    # the first correction takes two terms of the series, the second all
    x = step * inverse
    step -= per_stress * strong * ((b3 * x + b2) * x * x)
    x = step * inverse
    rise = ((((((b8 * x + b7) * x + b6) * x + b5) * x + b4) * x + b3) * x + b2) * x + exponent
    return step + per_stress * (excess - 3.0 * shear * step - strong * (rise * x))


@kernel
def power_return(gradient, history, stress, shear, bulk, yield_stress, exponent, prestrain):
    """sigma_y = K (e0 + ep)^n for steps within reach of the series. Returns how many points are left."""
    compliance, softness = 1.0 / shear, THIRD / bulk
    b2 = 0.5 * exponent * (exponent - 1.0)
    b3 = b2 * (exponent - 2.0) / 3.0
    b4 = b3 * (exponent - 3.0) / 4.0
    b5 = b4 * (exponent - 4.0) / 5.0
    b6 = b5 * (exponent - 5.0) / 6.0
    b7 = b6 * (exponent - 6.0) / 7.0
    b8 = b7 * (exponent - 7.0) / 8.0
    left = 0
    for p in range(gradient.shape[1]):
        det = gradient[0, p] * gradient[3, p] - gradient[1, p] * gradient[2, p]
        tau = _kirchhoff(stress[0, p], stress[1, p], stress[2, p], stress[3, p], det)
        mises, strong, start = tau[3], yield_stress + history[4, p], prestrain + history[3, p]
        limit = min(strong + 3.0 * shear * REACH * start, WEAK * shear)
        step = _near_step(mises, start, strong, shear, exponent, b2, b3, b4, b5, b6, b7, b8)
        step = step if mises > strong and mises <= limit else 0.0
        left += 1 if mises > limit else 0
        history[4, p] = mises - 3.0 * shear * step - yield_stress if step > 0.0 else history[4, p]
        _return(p, gradient, history, stress, det, tau, step, shear, compliance, softness, True)
    return left


@point
def _far_step(mises, start, strong, shear, strength, exponent):
    """Plastic step of any size by Newton on mises - 3 mu step - K (start + step)^n = 0.

    Convex, so that Newton from the tangent at the start only falls short and cannot overshoot.
    """
    step = (mises - strong) / (3.0 * shear + exponent * strong / start)
    for _ in range(60):
        now = start + step
        strong = strength * exp(exponent * log(now))
        change = (mises - 3.0 * shear * step - strong) / (3.0 * shear + exponent * strong / now)
        step += change
        if abs(change) <= 1e-15 * now:
            break
    return step


@kernel
def far_power_return(gradient, history, stress, shear, bulk, yield_stress, exponent, prestrain, strength):
    """The same for the points left: as many Newton steps as each needs."""
    compliance, softness = 1.0 / shear, THIRD / bulk
    for p in range(gradient.shape[1]):
        det = gradient[0, p] * gradient[3, p] - gradient[1, p] * gradient[2, p]
        tau = _kirchhoff(stress[0, p], stress[1, p], stress[2, p], stress[3, p], det)
        mises, strong, start = tau[3], yield_stress + history[4, p], prestrain + history[3, p]
        limit = min(strong + 3.0 * shear * REACH * start, WEAK * shear)
        if mises > strong and mises > limit:
            step = _far_step(mises, start, strong, shear, strength, exponent)
            history[4, p] = mises - 3.0 * shear * step - yield_stress
            _return(p, gradient, history, stress, det, tau, step, shear, compliance, softness, False)
