"""References for the end of a run: energy and momenta of its start, and which nodes mirror each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from contactlab.api import Floats, Ints


@dataclass
class Start:
    """Data at the start of a run.

    energy    [mJ] kinetic
    momentum  (4,) as in `Model.momenta`
    """

    energy: float
    momentum: Floats


def mirrored_nodes(reference: Floats, parts: Sequence[slice]) -> Ints:
    """Return the node at the mirror image in x = 0 of each node (N,), within the same of the `parts`.

    -1 without one within 1e-6 of the size.
    """
    size = float(np.ptp(reference, axis=0).max())
    grid = np.round(reference / (1e-6 * size)).astype(np.int64)
    mirror = np.full(len(reference), -1, np.int32)
    for part in parts:
        own = grid[part]
        if not len(own):
            continue
        (left, low), (right, high) = own.min(axis=0), own.max(axis=0)
        rows = high - low + 1
        key, image = (own[:, 0] - left) * rows + own[:, 1] - low, (-own[:, 0] - left) * rows + own[:, 1] - low
        order = np.argsort(key, kind="stable")
        place = order[np.searchsorted(key[order], image, side="right") - 1]
        inside = (-own[:, 0] >= left) & (-own[:, 0] <= right)  # elsewhere a key would belong to another place
        mirror[part] = np.where(inside & (key[place] == image), part.start + place, -1)
    return mirror
