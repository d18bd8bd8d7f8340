"""Cells as VTK numbers them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from contactlab.api.arrays import Ints
from contactlab.api.frame import BodyLayout

VTK_TYPE = {4: 9, 8: 23, 9: 28}
"""VTK cell type by number of nodes: quadrilateral, and its quadratic and biquadratic kin.

The node order of the contract: corners counter-clockwise, mid-sides, middle.
"""


def connectivity(bodies: Sequence[BodyLayout]) -> tuple[Ints, Ints, Ints]:
    """Connectivity, offsets (n + 1,) and types (n,) of all cells of all bodies."""
    nodes = [body.cells.ravel() for body in bodies]
    counts = np.concatenate([np.full(len(body.cells), body.cells.shape[1]) for body in bodies])
    types = np.concatenate([np.full(len(body.cells), VTK_TYPE[body.cells.shape[1]], np.uint8) for body in bodies])
    return np.concatenate(nodes).astype(np.int64), np.concatenate([[0], np.cumsum(counts)]).astype(np.int64), types
