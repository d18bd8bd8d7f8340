"""The letters and layouts of every array that crosses the contract.

Letters
    N nodes of the model, n cells of a body, B cells of one block, q points per cell,
    a nodes per cell, P = q B points of a block (point-major: index p = point * B + cell),
    m slave-surface nodes, k multipliers, z entries of sparse rows.

Layouts
    nodal fields          (N, 2)      rows x, y
    gradients             (4, P)      rows xx, xy, yx, yy: component ij is d(field_i)/d(position_j)
    Cauchy stress         (4, P)      rows xx, yy, zz, xy
    history               (h, P)
    connectivity          (a, B)      int32

Everything is float64 and C-contiguous. Blocks are component-major so that a compiler can
vectorise a law: each component of a block is one contiguous row.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
Flags = NDArray[np.bool_]

XX: Final = 0
YY: Final = 1
ZZ: Final = 2
XY: Final = 3

BLOCK_CELLS: Final = 1024
"""Cells of a full block: large enough to hide the call, small enough for the second-level cache."""
