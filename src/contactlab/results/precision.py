"""How exactly fields of frames are stored: they are looked at, and what a restart needs is stored beside them.

Digits that nobody sees are noise, and noise is what cannot be compressed.
"""

from __future__ import annotations

import numpy as np

SHOWN = 16
"""Significant bits of stresses, velocities, tractions and internal variables: to 1.5e-5 of each value."""
PLACES = 19
"""Significant bits of positions, which are exactly the nodes and their displacement: to 2e-6 of each coordinate."""
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
