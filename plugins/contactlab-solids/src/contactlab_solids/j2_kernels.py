"""Kernels of J2 plasticity in logarithmic elastic strains (see `j2`).

The elastic state of a point is its unimodular in-plane plastic metric C = Cp^-1/sqrt(det) and the elastic
logarithmic strain zz. With the rows a, b, c, d of F^-1, D = det F^-1 and A = adj F^-1, the in-plane
elastic left Cauchy-Green tensor is A C A^T up to a factor, which ln J and the strain zz determine. So

    delta = e_1 - e_2 = asinh(r/D),  r^2 = d^2 + x^2,   d, x = deviator (half difference, shear) of A C A^T
    s_d, s_x = mu delta (d, x)/r,    s_z = 2 mu (e_z - ln J/3),    tau = K ln J + s

need no eigenvectors, and a radial return scales s. History rows: half difference and shear of C,
strain zz, equivalent plastic strain, and (power law) the rise of the yield stress.

The work is cut in two so that a block pays for what its points do: `trial` gives the stress of an elastic
step and counts points; where some yield, one of the other kernels returns those and leaves the rest alone.
"""

from __future__ import annotations

from math import sqrt

from contactlab.api.kernel import exp, kernel, log, point

DIFFERENCE, SHEAR, STRAIN_ZZ, PLASTIC, RISE = range(5)  # history rows


@point
def _deviator(a, b, c, d, half, cross):
    """Half difference, shear and mean of A C A^T."""
    mean = sqrt(1.0 + half * half + cross * cross)
    first, second = mean + half, mean - half
    xx = d * d * first - 2.0 * b * d * cross + b * b * second
    yy = c * c * first - 2.0 * a * c * cross + a * a * second
    xy = (a * d + b * c) * cross - c * d * first - a * b * second
    return 0.5 * (xx - yy), xy, 0.5 * (xx + yy)


@point
def _mises(s_d, s_x, s_z):
    return sqrt(2.25 * s_z * s_z + 3.0 * (s_d * s_d + s_x * s_x))


@kernel
def trial(gradient, history, stress, shear, bulk, yield_stress, slope, slope_row, reach, reach_slope):
    """Cauchy stress of an elastic step.

    Returns how many points yield, and at how many the Mises stress exceeds the yield stress by more
    than reach + reach_slope * (plastic strain). The yield stress is yield_stress + slope * history[slope_row].
    """
    g_xx, g_xy, g_yx, g_yy = gradient[0], gradient[1], gradient[2], gradient[3]
    xx, yy, zz, xy = stress[0], stress[1], stress[2], stress[3]
    half, cross, strain_zz = history[0], history[1], history[2]
    plastic, rise = history[3], history[slope_row]
    yielding, far = 0, 0
    for p in range(g_xx.size):
        a, b, c, d = g_xx[p], g_xy[p], g_yx[p], g_yy[p]
        det = a * d - b * c
        log_j = -log(det)
        difference, shearing, mean = _deviator(a, b, c, d, half[p], cross[p])
        r = sqrt(difference * difference + shearing * shearing)
        # delta/r, and its limit 1/det where the in-plane elastic strain is a pure change of area
        factor = (log(mean + r) + log_j) / r if r > 1e-14 * mean else 1.0 / det
        s_d, s_x = shear * factor * difference, shear * factor * shearing
        s_z = 2.0 * shear * (strain_zz[p] - log_j / 3.0)
        excess = _mises(s_d, s_x, s_z) - (yield_stress + slope * rise[p])
        yielding += 1 if excess > 0.0 else 0
        far += 1 if excess > reach + reach_slope * plastic[p] else 0
        middle = bulk * log_j - 0.5 * s_z
        xx[p], yy[p] = (middle + s_d) * det, (middle - s_d) * det
        zz[p], xy[p] = (bulk * log_j + s_z) * det, s_x * det
    return yielding, far


@point
def _kirchhoff(p, gradient, stress):
    """s_d, s_x, s_z, Mises' stress and pressure of tau = sigma/det F^-1 at point p."""
    det = gradient[0][p] * gradient[3][p] - gradient[1][p] * gradient[2][p]
    inverse = 1.0 / det
    xx, yy, zz = stress[0][p] * inverse, stress[1][p] * inverse, stress[2][p] * inverse
    pressure = (xx + yy + zz) / 3.0
    s_d, s_x, s_z = 0.5 * (xx - yy), stress[3][p] * inverse, zz - pressure
    return s_d, s_x, s_z, pressure, _mises(s_d, s_x, s_z)


@point
def _plastic_metric(a, b, c, d, det, s_d, s_x, shear):
    """Half difference and shear of C = F^-1 B F^-T/det, B unimodular with logarithmic deviator s/(2 mu)."""
    norm = sqrt(s_d * s_d + s_x * s_x)
    grown = exp(norm / shear)
    inverse = 1.0 / grown
    cosh = 0.5 * (grown + inverse)
    ratio = 0.5 * (grown - inverse) / norm if norm > 0.0 else 0.0
    u, v = ratio * s_d, ratio * s_x
    half = 0.5 * (cosh * (a * a + b * b - c * c - d * d) + u * (a * a + d * d - b * b - c * c)) + v * (a * b - c * d)
    cross = cosh * (a * c + b * d) + u * (a * c - b * d) + v * (a * d + b * c)
    return half / det, cross / det


@point
def _return(p, gradient, history, stress, shear, bulk, s_d, s_x, s_z, pressure, mises, step):
    """Where the plastic strain `step` is positive, scale the deviator and write what follows from it."""
    a, b, c, d = gradient[0][p], gradient[1][p], gradient[2][p], gradient[3][p]
    det = a * d - b * c
    keep = 1.0 - 3.0 * shear * step / mises
    s_d, s_x, s_z = keep * s_d, keep * s_x, keep * s_z
    half, cross = _plastic_metric(a, b, c, d, det, s_d, s_x, shear)
    yields = step > 0.0
    history[0][p] = half if yields else history[0][p]
    history[1][p] = cross if yields else history[1][p]
    history[2][p] = s_z / (2.0 * shear) + pressure / (3.0 * bulk) if yields else history[2][p]
    history[3][p] = history[3][p] + step if yields else history[3][p]
    middle = pressure - 0.5 * s_z
    stress[0][p] = (middle + s_d) * det if yields else stress[0][p]
    stress[1][p] = (middle - s_d) * det if yields else stress[1][p]
    stress[2][p] = (pressure + s_z) * det if yields else stress[2][p]
    stress[3][p] = s_x * det if yields else stress[3][p]


@kernel
def linear_return(gradient, history, stress, shear, bulk, yield_stress, hardening):
    """sigma_y = yield_stress + hardening * ep: the return is linear."""
    for p in range(gradient.shape[1]):
        s_d, s_x, s_z, pressure, mises = _kirchhoff(p, gradient, stress)
        excess = mises - (yield_stress + hardening * history[3][p])
        step = excess / (3.0 * shear + hardening) if excess > 0.0 else 0.0
        _return(p, gradient, history, stress, shear, bulk, s_d, s_x, s_z, pressure, mises, step)


@point
def _power_steps(mises, plastic, rise, shear, yield_stress, strength, prestrain, exponent):
    """Plastic step from the tangent at the start, then one Newton step: final for steps below the reach."""
    start = prestrain + plastic
    strong = yield_stress + rise
    step = (mises - strong) / (3.0 * shear + exponent * strong / start)
    return _newton(step, mises, start, shear, strength, exponent)


@point
def _newton(step, mises, start, shear, strength, exponent):
    """One Newton step on mises - 3 mu step - K (start + step)^n = 0; convex, so it only falls short."""
    now = start + step
    strong = strength * exp(exponent * log(now))
    return step + (mises - 3.0 * shear * step - strong) / (3.0 * shear + exponent * strong / now)


@kernel
def power_return(gradient, history, stress, shear, bulk, yield_stress, strength, prestrain, exponent):
    """sigma_y = K (e0 + ep)^n where every step of the block is within reach of one Newton step."""
    for p in range(gradient.shape[1]):
        s_d, s_x, s_z, pressure, mises = _kirchhoff(p, gradient, stress)
        rise = history[4][p]
        step = _power_steps(mises, history[3][p], rise, shear, yield_stress, strength, prestrain, exponent)
        step = step if mises > yield_stress + rise else 0.0
        history[4][p] = mises - 3.0 * shear * step - yield_stress if step > 0.0 else rise
        _return(p, gradient, history, stress, shear, bulk, s_d, s_x, s_z, pressure, mises, step)


@kernel
def power_return_far(gradient, history, stress, shear, bulk, yield_stress, strength, prestrain, exponent):
    """The same with as many Newton steps as each point needs."""
    for p in range(gradient.shape[1]):
        s_d, s_x, s_z, pressure, mises = _kirchhoff(p, gradient, stress)
        rise, step = history[4][p], 0.0
        if mises > yield_stress + rise:
            step = _power_steps(mises, history[3][p], rise, shear, yield_stress, strength, prestrain, exponent)
            for _ in range(60):
                before = step
                step = _newton(step, mises, prestrain + history[3][p], shear, strength, exponent)
                if abs(step - before) <= 1e-15 * (prestrain + step):
                    break
            history[4][p] = mises - 3.0 * shear * step - yield_stress
        _return(p, gradient, history, stress, shear, bulk, s_d, s_x, s_z, pressure, mises, step)
