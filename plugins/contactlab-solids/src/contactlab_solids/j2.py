"""J2 plasticity at finite strain, exact for any step: what the laws with different hardening share.

F = Fe Fp with elastic logarithmic strains e = ln(Fe Fe^T)/2 and Hencky's energy
W = K/2 (ln J)^2 + mu dev e : dev e, so that the Kirchhoff stress is tau = K ln J I + 2 mu dev e. Flow is
associative, plastic volume is kept exactly, and with the exponential map the return is the radial one of
small strains (Simo 1992; Weber & Anand 1990). Mises' condition is written in tau; the Cauchy stress is
tau/J, which differs by the elastic change of volume (0.3 % at a mean stress of 0.3 % of the bulk modulus).

The state is total: it needs F, not its increments. Rigid rotations change nothing, whatever the step, and
a proportional path gives the same result in one step as in a thousand.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from contactlab.api import Floats, Tensor, formula
from contactlab.api.compiled.late import late
from contactlab_solids.elastic_constants import lame, lame_constants

HISTORY = (
    "plastic_metric_difference",
    "plastic_metric_shear",
    "elastic_strain_zz",
    "equivalent_plastic_strain",
)
"""Rows of the history: half difference and shear of the unimodular Cp^-1, ln of the elastic stretch zz, ep."""


class Moduli(NamedTuple):
    """Shear and bulk modulus [MPa]."""

    shear: float
    bulk: float


@cache
def moduli(young: float, poisson: float) -> Moduli:
    """Shear and bulk modulus [MPa] of the elastic part."""
    lame, shear = lame_constants(young, poisson)
    return Moduli(shear, lame + 2.0 / 3.0 * shear)


@formula
def returned(F: Any, history: Any, flow: Any, p: Any) -> Any:
    """Cauchy stress and the four numbers of `HISTORY`: an elastic trial and its radial return.

    flow(plastic, p) gives the yield stress and its slope.
    """
    (shear, bulk), log_j = constants(p), math.log(F.det())
    s_d, s_x, s_z = trial(F, history, shear)
    half, cross, zz = history.plastic_metric_difference, history.plastic_metric_shear, history.elastic_strain_zz
    plastic, squared = history.equivalent_plastic_strain, 2.25 * s_z * s_z + 3.0 * (s_d * s_d + s_x * s_x)
    limit, slope = flow(plastic, p)
    if squared > limit * limit:
        mises, step = math.sqrt(squared), 0.0
        for _ in range(60):
            # the strength is concave, so that Newton from the start only falls short
            change = (mises - 3.0 * shear * step - limit) / (3.0 * shear + slope)
            step = step + change
            limit, slope = flow(plastic + step, p)
            if abs(change) <= 1e-15 * (plastic + step):
                break
        keep, plastic = 1.0 - 3.0 * shear * step / mises, plastic + step
        s_d, s_x, s_z = keep * s_d, keep * s_x, keep * s_z
        half, cross = metric(F, s_d / shear, s_x / shear)
        zz = 0.5 * s_z / shear + log_j / 3.0
    middle = bulk * log_j - 0.5 * s_z
    kirchhoff = Tensor(middle + s_d, s_x, s_x, middle - s_d, bulk * log_j + s_z)
    return kirchhoff / F.det(), (half, cross, zz, plastic)


@formula
def constants(p: Any) -> Any:
    """Shear and bulk modulus [MPa]."""
    first, shear = lame(p)
    return shear, first + 2.0 / 3.0 * shear


@formula
def trial(F: Any, history: Any, shear: Any) -> Any:
    """Half difference, shear and zz of the deviator of tau for an elastic step."""
    half, cross = history.plastic_metric_difference, history.plastic_metric_shear
    mean, J = math.sqrt(1.0 + half * half + cross * cross), F.det()
    elastic = F @ Tensor(mean + half, cross, cross, mean - half, 1.0) @ F.T()
    d, x = 0.5 * (elastic.xx - elastic.yy) / J, elastic.xy / J
    square = d * d + x * x
    # asinh(r)/r of r^2, by its series if digits cancel
    if square < 1e-4:
        over = 1.0 - square * (1.0 / 6.0 - square * (3.0 / 40.0 - square * (5.0 / 112.0 - square * 35.0 / 1152.0)))
    else:
        over = math.log(math.sqrt(square) + math.sqrt(1.0 + square)) / math.sqrt(square)
    return shear * over * d, shear * over * x, 2.0 * shear * (history.elastic_strain_zz - math.log(J) / 3.0)


@formula
def metric(F: Any, u: Any, v: Any) -> Any:
    """Half difference and shear of C = J F^-1 B F^-T, B unimodular with the logarithmic deviator u, v."""
    square, inverse = u * u + v * v, F.inverse()
    size = math.sqrt(square)
    cosh, over = 0.5 * (math.exp(size) + math.exp(-size)), 1.0 + square / 6.0 * (1.0 + square / 20.0)
    if square > 1e-4:
        over = 0.5 * (math.exp(size) - math.exp(-size)) / size
    both = inverse @ Tensor(cosh + over * u, over * v, over * v, cosh - over * u, 1.0) @ inverse.T()
    return 0.5 * (both.xx - both.yy) * F.det(), both.xy * F.det()


@formula
def stored(F: Any, history: Any, p: Any) -> Any:
    """Hencky's energy per current volume, from the state of an accepted step."""
    (shear, bulk), log_j = constants(p), math.log(F.det())
    s_d, s_x, s_z = trial(F, history, shear)
    return (0.5 * bulk * log_j * log_j + (0.75 * s_z * s_z + s_d * s_d + s_x * s_x) / (2.0 * shear)) / F.det()


def elastic_trial(
    gradient: Floats, history: Floats, stress: Floats, elastic: Moduli, flow: tuple[float, float, int]
) -> bool:
    """Stress of an elastic step, and whether any point may yield.

    flow   yield stress at the start, slope, and the history row that the slope multiplies
    """
    j2_kernels = late("contactlab_solids.j2_kernels")
    yielding, wide = j2_kernels.trial(gradient, history, stress, *elastic, *flow)
    if wide:
        j2_kernels.wide_trial(gradient, history, stress, *elastic, False)
    return bool(yielding or wide)


def stiffening(gradient: Floats, stress: Floats, constants: Moduli, out: Floats) -> None:
    """Spatial moduli are C/J; a stress adds at most its largest principal value."""
    mean, radius = 0.5 * (stress[0] + stress[1]), np.hypot(0.5 * (stress[0] - stress[1]), stress[3])
    largest = np.maximum(np.abs(mean) + radius, np.abs(stress[2]))
    inverse_j = gradient[0] * gradient[3] - gradient[1] * gradient[2]
    np.maximum(inverse_j + largest / constants.shear, 1e-3, out=out)
