"""How the separations of the multipliers change with their weights.

The weighted separation of multiplier j is the sum of D x - M y - T r over its pieces, at fixed positions x and y and
separations r of the multipliers.
"""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import kernel, section
from contactlab.api.compiled.unpack import unpack
from contactlab_mortar.changes import average_normals, piece_changes, six_nodes
from contactlab_mortar.normals import normal_derivatives
from contactlab_mortar.segments import segments_of
from contactlab_mortar.tables import SeparationsTable


@section
def _weighted(table, p, z, changes, out):
    """What number z changes of the separations of piece p, into out (2, 2): multiplier, direction."""
    sides, pieces, (dD, dM, dT) = table.sides, table.pieces, changes
    for j in range(2):
        for d in range(2):
            total = 0.0
            for i in range(dD.shape[1]):
                total += dD[z, i, j] * sides.slave_at[pieces.slave[p, i], d]
            for i in range(dM.shape[1]):
                total -= dM[z, i, j] * sides.master_at[pieces.master[p, i], d]
            for i in range(2):
                owner = table.owner[pieces.multiplier[p, i]]
                total -= dT[z, i, j] * table.separation[owner, d] if owner >= 0 else 0.0
            out[j, d] = total


@kernel
def mortar_gradients(bound, count, linear, vertices):
    """Fill the gradients of the first `count` pieces and of the averaged normals; returns the number of the latter.

    `bound` is the address of a `SeparationsTable`. -1 where the normals are not the averaged ones.
    """
    table = unpack(bound, SeparationsTable)
    sides, pieces, out = table.sides, table.pieces, table.out
    if not average_normals(sides, pieces.normal, table.averaged):
        return -1
    segments, rates, weighted = np.empty((count, 2), np.int64), np.empty((3, 6, 2)), np.empty((2, 2))
    changes = np.empty((3, pieces.D.shape[1], 2)), np.empty((3, pieces.M.shape[1], 2)), np.empty((3, 2, 2))
    segments_of(sides, pieces, count, table.averaged, vertices, segments)
    for p in range(count):
        s, m = segments[p, 0], segments[p, 1]
        piece_changes(table, p, s, m, (linear, vertices), rates, changes)
        six_nodes(s, m, sides, out.node[p])
        out.multiplier[p, 0], out.multiplier[p, 1] = pieces.multiplier[p, 0], pieces.multiplier[p, 1]
        out.value[p] = 0.0
        for z in range(3):
            _weighted(table, p, z, changes, weighted)
            for j in range(2):
                for d in range(2):
                    for v in range(6):
                        for c in range(2):
                            out.value[p, j, d, v, c] += weighted[j, d] * rates[z, v, c]
    normals = out.normal_of, out.normal_moved, out.dnormal
    return normal_derivatives(sides.slave_at, sides.slave.segments, sides.slave.node_segments, normals)
