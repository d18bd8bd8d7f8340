"""What one would write by hand: one scalar loop over cells and points for one element and one law.

Bilinear quadrilateral with 2x2 points (others in `fused_elements.py`), everything of a cell in local
variables, mathematics from the C library, compiled with the options of the block kernels. They compute
what the parts compute, so a test of a benchmark is that forces agree: `elements.py` makes it.
"""

from __future__ import annotations

from math import exp, log, sqrt
from typing import Any

from numba import njit

_G = 0.5773502691896258
_XI, _ETA = (-_G, _G, _G, -_G), (-_G, -_G, _G, _G)

fused = njit(error_model="numpy", fastmath={"contract"}, cache=True)
inlined = njit(error_model="numpy", fastmath={"contract"}, forceinline=True)


@inlined
def derivatives(xi: float, eta: float) -> Any:
    """d/dxi and d/deta of the four shape functions."""
    a, b, c, d = 0.25 * (1.0 - eta), 0.25 * (1.0 + eta), 0.25 * (1.0 - xi), 0.25 * (1.0 + xi)
    return -a, a, b, -b, -c, -d, d, c


@inlined
def gradient(x, u, i, j, k, m, xi, eta):
    """Rows of du/dx, the Jacobian's cofactors, and the derivatives."""
    p, q, r, s, e, f, g, h = derivatives(xi, eta)
    x_xi = p * x[i, 0] + q * x[j, 0] + r * x[k, 0] + s * x[m, 0]
    y_xi = p * x[i, 1] + q * x[j, 1] + r * x[k, 1] + s * x[m, 1]
    x_eta = e * x[i, 0] + f * x[j, 0] + g * x[k, 0] + h * x[m, 0]
    y_eta = e * x[i, 1] + f * x[j, 1] + g * x[k, 1] + h * x[m, 1]
    u_xi = p * u[i, 0] + q * u[j, 0] + r * u[k, 0] + s * u[m, 0]
    v_xi = p * u[i, 1] + q * u[j, 1] + r * u[k, 1] + s * u[m, 1]
    u_eta = e * u[i, 0] + f * u[j, 0] + g * u[k, 0] + h * u[m, 0]
    v_eta = e * u[i, 1] + f * u[j, 1] + g * u[k, 1] + h * u[m, 1]
    inverse = 1.0 / (x_xi * y_eta - x_eta * y_xi)
    xx, xy = (u_xi * y_eta - u_eta * y_xi) * inverse, (u_eta * x_xi - u_xi * x_eta) * inverse
    yx, yy = (v_xi * y_eta - v_eta * y_xi) * inverse, (v_eta * x_xi - v_xi * x_eta) * inverse
    return xx, xy, yx, yy, x_xi, x_eta, y_xi, y_eta


@inlined
def add(force, i, j, k, m, xi, eta, x_xi, x_eta, y_xi, y_eta, xx, yy, xy):
    """Nodal forces of one point's stress."""
    p, q, r, s, e, f, g, h = derivatives(xi, eta)
    a, b = xx * y_eta - xy * x_eta, xy * x_xi - xx * y_xi
    c, d = xy * y_eta - yy * x_eta, yy * x_xi - xy * y_xi
    force[i, 0] += p * a + e * b
    force[j, 0] += q * a + f * b
    force[k, 0] += r * a + g * b
    force[m, 0] += s * a + h * b
    force[i, 1] += p * c + e * d
    force[j, 1] += q * c + f * d
    force[k, 1] += r * c + g * d
    force[m, 1] += s * c + h * d


@fused
def linear_elastic(x, u, cells, force, lame, shear):
    """Hooke's law, small strains: x undeformed, u displacement."""
    for n in range(cells.shape[0]):
        i, j, k, m = cells[n, 0], cells[n, 1], cells[n, 2], cells[n, 3]
        for g in range(4):
            xx, xy, yx, yy, a, b, c, d = gradient(x, u, i, j, k, m, _XI[g], _ETA[g])
            pressure = lame * (xx + yy)
            s_xx, s_yy, s_xy = pressure + 2.0 * shear * xx, pressure + 2.0 * shear * yy, shear * (xy + yx)
            add(force, i, j, k, m, _XI[g], _ETA[g], a, b, c, d, s_xx, s_yy, s_xy)


@inlined
def neo_hookean_stress(xx, xy, yx, yy, lame, shear):
    """Cauchy stress of F^-1."""
    det = xx * yy - xy * yx
    spherical, scale = -(lame * log(det) + shear) * det, shear / det
    return (
        spherical + scale * (yy * yy + xy * xy), spherical + scale * (xx * xx + yx * yx), -scale * (yx * yy + xx * xy),
    )  # fmt: skip


@fused
def neo_hookean(x, u, cells, force, lame, shear):
    """Neo-Hookean law: x deformed, u undeformed positions."""
    for n in range(cells.shape[0]):
        i, j, k, m = cells[n, 0], cells[n, 1], cells[n, 2], cells[n, 3]
        for g in range(4):
            xx, xy, yx, yy, a, b, c, d = gradient(x, u, i, j, k, m, _XI[g], _ETA[g])
            s_xx, s_yy, s_xy = neo_hookean_stress(xx, xy, yx, yy, lame, shear)
            add(force, i, j, k, m, _XI[g], _ETA[g], a, b, c, d, s_xx, s_yy, s_xy)


@inlined
def _midpoint(xx, xy, yx, yy):
    a, b, c, d = 1.0 - 0.5 * xx, -0.5 * xy, -0.5 * yx, 1.0 - 0.5 * yy
    inverse = 1.0 / (a * d - b * c)
    return (
        (xx * d - xy * c) * inverse, (xy * a - xx * b) * inverse,
        (yx * d - yy * c) * inverse, (yy * a - yx * b) * inverse,
    )  # fmt: skip


@inlined
def _turned(xx, yy, xy, spin):
    h = 0.5 * spin
    scale = 1.0 / (1.0 + h * h)
    c, s = (1.0 - h * h) * scale, 2.0 * h * scale
    mean, half = 0.5 * (xx + yy), 0.5 * (xx - yy)
    return mean, c * half + s * xy, c * xy - s * half, c, s


@fused
def hypoelastic(x, u, cells, force, history, lame, shear):
    """Jaumann rate: x deformed, u increment, history (n, 4, 4) stresses xx, yy, zz, xy."""
    for n in range(cells.shape[0]):
        i, j, k, m = cells[n, 0], cells[n, 1], cells[n, 2], cells[n, 3]
        for g in range(4):
            xx, xy, yx, yy, a, b, c, d = gradient(x, u, i, j, k, m, _XI[g], _ETA[g])
            xx, xy, yx, yy = _midpoint(xx, xy, yx, yy)
            old = history[n, g]
            mean, half, s_xy, cos, sin = _turned(old[0], old[1], old[3], 0.5 * (xy - yx))
            mean += (lame + shear) * (xx + yy)
            half, s_xy = half + shear * (xx - yy), s_xy + shear * (xy + yx)
            half, s_xy = cos * half + sin * s_xy, cos * s_xy - sin * half
            old[0], old[1], old[3] = mean + half, mean - half, s_xy
            old[2] += lame * (xx + yy)
            add(force, i, j, k, m, _XI[g], _ETA[g], a, b, c, d, mean + half, mean - half, s_xy)


@inlined
def _power_step(mises, plastic, shear, strength, prestrain, exponent):
    """Plastic step: Newton from zero with the C library's power."""
    step = 0.0
    for _ in range(50):
        now = prestrain + plastic + step
        strong = strength * now**exponent
        change = (mises - 3.0 * shear * step - strong) / (3.0 * shear + exponent * strong / now)
        step += change
        if abs(change) <= 1e-12 * now:
            break
    return step


@fused
def power_law_rate(x, u, cells, force, history, lame, shear, strength, prestrain, exponent):
    """The customary J2 law with stored stress, history (n, 4, 5): stresses and plastic strain."""
    for n in range(cells.shape[0]):
        i, j, k, m = cells[n, 0], cells[n, 1], cells[n, 2], cells[n, 3]
        for g in range(4):
            xx, xy, yx, yy, a, b, c, d = gradient(x, u, i, j, k, m, _XI[g], _ETA[g])
            xx, xy, yx, yy = _midpoint(xx, xy, yx, yy)
            old = history[n, g]
            mean, half, s_xy, cos, sin = _turned(old[0], old[1], old[3], 0.5 * (xy - yx))
            mean += (lame + shear) * (xx + yy)
            half, s_xy = half + shear * (xx - yy), s_xy + shear * (xy + yx)
            half, s_xy = cos * half + sin * s_xy, cos * s_xy - sin * half
            zz = old[2] + lame * (xx + yy)
            pressure = (2.0 * mean + zz) / 3.0
            s_z = zz - pressure
            mises = sqrt(2.25 * s_z * s_z + 3.0 * (half * half + s_xy * s_xy))
            if mises > strength * (prestrain + old[4]) ** exponent:
                step = _power_step(mises, old[4], shear, strength, prestrain, exponent)
                keep = 1.0 - 3.0 * shear * step / mises
                half, s_xy, s_z = keep * half, keep * s_xy, keep * s_z
                old[4] += step
            middle = pressure - 0.5 * s_z
            old[0], old[1], old[2], old[3] = middle + half, middle - half, pressure + s_z, s_xy
            add(force, i, j, k, m, _XI[g], _ETA[g], a, b, c, d, middle + half, middle - half, s_xy)


@inlined
def _log_trial(a, b, c, d, old, shear):
    """Elastic trial in logarithmic strains: deviator (half difference, shear, out of plane), ln J, Mises stress."""
    det = a * d - b * c
    log_j = -log(det)
    mean = sqrt(1.0 + old[0] * old[0] + old[1] * old[1])
    first, second, cross = mean + old[0], mean - old[0], old[1]
    b_xx = d * d * first - 2.0 * b * d * cross + b * b * second
    b_yy = c * c * first - 2.0 * a * c * cross + a * a * second
    b_xy = (a * d + b * c) * cross - c * d * first - a * b * second
    half = 0.5 * (b_xx - b_yy)
    r = sqrt(half * half + b_xy * b_xy)
    factor = (log(0.5 * (b_xx + b_yy) + r) + log_j) / r if r > 0.0 else 1.0 / det
    s_d, s_x, s_z = shear * factor * half, shear * factor * b_xy, 2.0 * shear * (old[2] - log_j / 3.0)
    return s_d, s_x, s_z, log_j, sqrt(2.25 * s_z * s_z + 3.0 * (s_d * s_d + s_x * s_x))


@inlined
def _log_return(a, b, c, d, old, shear, step, s_d, s_x, s_z, log_j, mises):
    """Scale the deviator back by a plastic step, and keep elastic strains and plastic strain in `old`."""
    det = a * d - b * c
    keep = 1.0 - 3.0 * shear * step / mises
    s_d, s_x, s_z = keep * s_d, keep * s_x, keep * s_z
    norm = sqrt(s_d * s_d + s_x * s_x)
    grown = exp(norm / shear)
    cosh, sinh = 0.5 * (grown + 1.0 / grown), 0.5 * (grown - 1.0 / grown) / norm
    p, q = sinh * s_d, sinh * s_x
    aa, bb, cc, dd = a * a, b * b, c * c, d * d
    old[0] = (0.5 * (cosh * (aa + bb - cc - dd) + p * (aa + dd - bb - cc)) + q * (a * b - c * d)) / det
    old[1] = (cosh * (a * c + b * d) + p * (a * c - b * d) + q * (a * d + b * c)) / det
    old[2] = s_z / (2.0 * shear) + log_j / 3.0
    old[3] += step
    return s_d, s_x, s_z


@inlined
def _log_stress(a, b, c, d, bulk, s_d, s_x, s_z, log_j):
    """Cauchy stress in the plane."""
    middle, det = bulk * log_j - 0.5 * s_z, a * d - b * c
    return (middle + s_d) * det, (middle - s_d) * det, s_x * det


@fused
def power_law(x, u, cells, force, history, bulk, shear, strength, prestrain, exponent):
    """J2 in logarithmic strains, as the part: x deformed, u undeformed positions, history (n, 4, 4)."""
    for n in range(cells.shape[0]):
        i, j, k, m = cells[n, 0], cells[n, 1], cells[n, 2], cells[n, 3]
        for g in range(4):
            a, b, c, d, x_xi, x_eta, y_xi, y_eta = gradient(x, u, i, j, k, m, _XI[g], _ETA[g])
            old = history[n, g]
            s_d, s_x, s_z, log_j, mises = _log_trial(a, b, c, d, old, shear)
            if mises > strength * (prestrain + old[3]) ** exponent:
                step = _power_step(mises, old[3], shear, strength, prestrain, exponent)
                s_d, s_x, s_z = _log_return(a, b, c, d, old, shear, step, s_d, s_x, s_z, log_j, mises)
            s_xx, s_yy, s_xy = _log_stress(a, b, c, d, bulk, s_d, s_x, s_z, log_j)
            add(force, i, j, k, m, _XI[g], _ETA[g], x_xi, x_eta, y_xi, y_eta, s_xx, s_yy, s_xy)


@fused
def linear_hardening(x, u, cells, force, history, bulk, shear, yield_stress, hardening):
    """The same with a yield stress that grows linearly."""
    for n in range(cells.shape[0]):
        i, j, k, m = cells[n, 0], cells[n, 1], cells[n, 2], cells[n, 3]
        for g in range(4):
            a, b, c, d, x_xi, x_eta, y_xi, y_eta = gradient(x, u, i, j, k, m, _XI[g], _ETA[g])
            old = history[n, g]
            s_d, s_x, s_z, log_j, mises = _log_trial(a, b, c, d, old, shear)
            excess = mises - yield_stress - hardening * old[3]
            if excess > 0.0:
                step = excess / (3.0 * shear + hardening)
                s_d, s_x, s_z = _log_return(a, b, c, d, old, shear, step, s_d, s_x, s_z, log_j, mises)
            s_xx, s_yy, s_xy = _log_stress(a, b, c, d, bulk, s_d, s_x, s_z, log_j)
            add(force, i, j, k, m, _XI[g], _ETA[g], x_xi, x_eta, y_xi, y_eta, s_xx, s_yy, s_xy)
