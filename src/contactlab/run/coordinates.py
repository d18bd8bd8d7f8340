"""Positions in messages."""

from __future__ import annotations

import numpy as np

from contactlab.api.arrays import Floats
from contactlab.model.model import Model


def coordinates(model: Model, point: Floats) -> str:
    """A position, without digits that are round-off of the size of the model."""
    size = float(np.ptp(model.reference, axis=0).max())
    x, y = (float(f"{value:.4g}") if abs(value) > 1e-6 * size else 0.0 for value in point)
    return f"({x:g}, {y:g})"
