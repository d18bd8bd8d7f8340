"""Where pieces begin and end on both segments."""

from __future__ import annotations

from contactlab.api.compiled.kernel import kernel
from contactlab.api.compiled.unpack import unpack
from contactlab_mortar.changes import average_normals
from contactlab_mortar.overlap import overlap
from contactlab_mortar.projection import MasterSegment, SlaveSegment
from contactlab_mortar.tables import FeetTable


@kernel
def mortar_feet(bound, count, out):
    """Fill out (p, 4) with xi and eta of both ends of the first `count` pieces; whether normals are the averaged ones.

    `bound` is the address of a `FeetTable`, of surfaces with straight edges.
    """
    table = unpack(bound, FeetTable)
    sides, pieces, x, y = table.sides, table.pieces, table.sides.slave_at, table.sides.master_at
    if not average_normals(sides, pieces.normal, table.averaged):
        return False
    normal = table.averaged
    for p in range(count):
        i, j, c, d = pieces.slave[p, 0], pieces.slave[p, 1], pieces.master[p, 0], pieces.master[p, 1]
        nx, ny = -normal[i, 0], -normal[i, 1]
        slave = SlaveSegment(
            x[i, 0], x[i, 1], x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], nx, ny, -normal[j, 0] - nx, -normal[j, 1] - ny
        )
        found = overlap(slave, MasterSegment(y[c, 0], y[c, 1], y[d, 0], y[d, 1]))
        out[p, 0], out[p, 1], out[p, 2], out[p, 3] = found.low, found.eta_low, found.high, found.eta_high
    return True
