"""Derivatives of laws by central differences, for those that give none."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from contactlab.api.arrays import Floats

if TYPE_CHECKING:
    from contactlab.api.material import Material

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
