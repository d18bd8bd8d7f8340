"""Tangents of laws by central differences, and the stiffening that follows from a tangent."""

from __future__ import annotations

import numpy as np

from contactlab.api.arrays import XX, XY, YY, Floats
from contactlab.api.compiled.late import late
from contactlab.api.material import Material

DIRECTIONS = 24  # of waves within half a turn
BETWEEN = 0.035  # 1 - cos(4 * 3.75 degrees): share of the spread that may be missed between two directions

STEP = 6e-6  # cube root of round-off: balances truncation and cancellation for gradients of order one


def tangent_by_differences(law: Material, gradient: Floats, history: Floats, dt: float, tangent: Floats) -> None:
    """Fill `tangent` (4, 4, P) with d(stress row i)/d(gradient row j), error about 1e-10 of the moduli."""
    trial, spare = gradient.copy(), np.empty_like(history)
    high, low = np.empty_like(gradient), np.empty_like(gradient)
    for j in range(4):
        trial[j] = gradient[j] + STEP
        law.stress(trial, history, dt, high, spare)
        trial[j] = gradient[j] - STEP
        law.stress(trial, history, dt, low, spare)
        trial[j] = gradient[j]
        tangent[:, j] = (high - low) / (2.0 * STEP)


def speeds_at_rest(law: Material) -> tuple[float, float]:
    """Dilatational and shear speed [mm/s] from the tangent of an undeformed point.

    For a material with directions of its own the first is the fastest wave in any direction, the second along x.
    """
    finite, history = law.kinematics == "finite", np.zeros((law.history_size, 1))
    gradient, tangent = np.array([[1.0], [0.0], [0.0], [1.0]]) * finite, np.empty((4, 4, 1))
    law.tangent(gradient, history, 0.0, tangent)
    # a "finite" law is given F^-1, whose change is minus the strain
    return speeds_of_moduli(law, (-1.0 if finite else 1.0) * tangent[..., 0])


def speeds_of_moduli(law: Material, moduli: Floats) -> tuple[float, float]:
    """Return the speeds of `speeds_at_rest` from derivatives (4, 4) of stress rows by strain rows at rest [MPa]."""
    dilatational, shear = float(moduli[0, 0]), float(moduli[3, 1])
    if not law.isotropic:
        # between two directions, half a degree away, the modulus hardly differs: its slope is 0 at the largest
        dilatational = fastest_modulus(moduli) * (1.0 + 1e-3)
    return float(np.sqrt(dilatational / law.density)), float(np.sqrt(shear / law.density))


def fastest_modulus(moduli: Floats) -> float:
    """Return the largest eigenvalue [MPa] of the acoustic tensor of moduli (4, 4), in directions a degree apart."""
    angle = np.arange(180) * np.pi / 180.0
    normals = np.stack([np.cos(angle), np.sin(angle)])
    by_gradient = moduli[[[XX, XY], [XY, YY]]].reshape(2, 2, 2, 2)
    acoustic = np.einsum("ja,ijkl,la->aik", normals, by_gradient, normals)
    return float(np.linalg.eigvals(acoustic).real.max())


def stiffening_of_waves(law: Material, gradient: Floats, out: Floats) -> None:
    """Fill out (P,) with the fastest wave's modulus over its value at rest, for "finite" laws without own history.

    It is searched in some directions, and a bound for the directions between two of them is added.
    """
    points = gradient.shape[1]
    tangent, history = np.empty((4, 4, points)), np.zeros((law.history_size, points))
    law.tangent(gradient, history, 0.0, tangent)
    angle = np.arange(DIRECTIONS) * 2.0 * np.pi / DIRECTIONS  # twice those of the waves
    parts, most, least = np.empty((9, points)), np.empty(points), np.empty(points)
    waves = late("contactlab.kernels.waves").waves
    waves(np.ascontiguousarray(gradient), tangent, np.cos(angle), np.sin(angle), parts, most, least)
    out[:] = (most + BETWEEN * (most - least)) / (law.density * law.wave_speeds()[0] ** 2)
