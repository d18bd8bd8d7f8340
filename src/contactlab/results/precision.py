"""How exactly fields of frames are stored: they are looked at, and what a restart needs is stored beside them.

Digits that nobody sees are noise, and noise is what cannot be compressed.
"""

from __future__ import annotations

import numpy as np

SHOWN = 14
"""Significant bits of stresses, tractions and internal variables: to 3e-5 of each value; velocities: of the largest."""
PLACES = 20
"""Bits of positions and displacements: to 1e-6 of the largest one in a frame."""
FULL = 24
"""Significant bits of a number in single precision."""


def rounded(values: np.ndarray, bits: int) -> np.ndarray:
    """The values (...) to the nearest one with so many significant bits, in single precision."""
    single = np.array(values, np.float32)
    if bits < FULL:
        unused = FULL - bits
        whole = single.view(np.uint32)
        whole += np.uint32(1 << (unused - 1))
        whole &= np.uint32(0xFFFFFFFF << unused & 0xFFFFFFFF)
    return single


def placed(values: np.ndarray, bits: int) -> np.ndarray:
    """The values (...) in single precision, all to the same place: with so many bits for the largest of them."""
    largest = float(np.abs(values).max(initial=0.0))
    if not np.isfinite(largest):
        return rounded(values, FULL)
    place = np.ldexp(1.0, int(np.frexp(largest)[1]) - bits)
    with np.errstate(over="ignore"):  # beyond single precision: infinite
        return np.asarray(np.rint(values / place) * place, np.float32)
