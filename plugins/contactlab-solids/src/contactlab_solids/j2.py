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

from functools import cache
from typing import NamedTuple

import numpy as np

from contactlab.api import Floats
from contactlab.api.compiled.late import late
from contactlab_solids.elastic_constants import lame_constants

HISTORY = (
    "plastic_metric_difference",
    "plastic_metric_shear",
    "elastic_strain_zz",
    "equivalent_plastic_strain",
)
"""Rows of the history: half difference and shear of the unimodular Cp^-1, ln of the elastic stretch zz, ep."""
PLASTIC = 3


class Moduli(NamedTuple):
    """Shear and bulk modulus [MPa]."""

    shear: float
    bulk: float


@cache
def moduli(young: float, poisson: float) -> Moduli:
    """Shear and bulk modulus [MPa] of the elastic part."""
    lame, shear = lame_constants(young, poisson)
    return Moduli(shear, lame + 2.0 / 3.0 * shear)


def energy(gradient: Floats, history: Floats, constants: Moduli, out: Floats) -> None:
    """Hencky's energy per current volume, from the state of an accepted step."""
    from contactlab_solids import j2_kernels

    shear, bulk = constants
    stress = np.empty((4, gradient.shape[1]))
    j2_kernels.wide_trial(gradient, history, stress, shear, bulk, True)
    inverse_j = gradient[0] * gradient[3] - gradient[1] * gradient[2]
    pressure = stress[:3].mean(axis=0)
    squares = ((stress[:3] - pressure) ** 2).sum(axis=0) + 2.0 * stress[3] ** 2
    out[:] = (0.5 * pressure**2 / bulk + squares / (4.0 * shear)) / inverse_j


def elastic_trial(
    gradient: Floats, history: Floats, stress: Floats, constants: Moduli, flow: tuple[float, float, int]
) -> bool:
    """Stress of an elastic step, and whether any point may yield.

    flow   yield stress at the start, slope, and the history row that the slope multiplies
    """
    j2_kernels = late("contactlab_solids.j2_kernels")
    yielding, wide = j2_kernels.trial(gradient, history, stress, *constants, *flow)
    if wide:
        j2_kernels.wide_trial(gradient, history, stress, *constants, False)
    return bool(yielding or wide)


def per_current_volume(gradient: Floats, density: Floats, out: Floats) -> None:
    """A density (P,) per undeformed volume referred to the current one."""
    np.multiply(density, gradient[0] * gradient[3] - gradient[1] * gradient[2], out=out)


def stiffening(gradient: Floats, stress: Floats, constants: Moduli, out: Floats) -> None:
    """Spatial moduli are C/J; a stress adds at most its largest principal value."""
    mean, radius = 0.5 * (stress[0] + stress[1]), np.hypot(0.5 * (stress[0] - stress[1]), stress[3])
    largest = np.maximum(np.abs(mean) + radius, np.abs(stress[2]))
    inverse_j = gradient[0] * gradient[3] - gradient[1] * gradient[2]
    np.maximum(inverse_j + largest / constants.shear, 1e-3, out=out)
