"""Precision of stored fields of frames: they are for viewing, a restart uses data that is stored separately.

Digits that nobody sees are noise, and noise cannot be compressed.
"""

from __future__ import annotations

import numpy as np

PLACES, SHOWN = 16, 12
"""Bits of positions and displacements, and of all else, of the largest value in a frame: to 8e-6 and 1.2e-4 of it."""


def placed(values: np.ndarray, bits: int) -> np.ndarray:
    """The values (...) in single precision, all to the same place: with so many bits for the largest of them."""
    largest = float(np.abs(values).max(initial=0.0))
    if not np.isfinite(largest):
        return np.array(values, np.float32)
    place = np.ldexp(1.0, int(np.frexp(largest)[1]) - bits)
    with np.errstate(over="ignore"):  # beyond single precision: infinite
        return np.asarray(np.rint(values / place) * place, np.float32)
