"""One contact pair from positions to gaps, on its bound arrays: what `SurfacePair` does in every step."""

from __future__ import annotations

from contactlab.api.compiled.chains import tributary_lengths
from contactlab.api.compiled.kernel import kernel
from contactlab.api.compiled.unpack import unpack
from contactlab.api.enforcement import CHAINED
from contactlab.kernels.contact.chained import separations, write_rows
from contactlab.kernels.contact.coupling import couple, unmerged
from contactlab.kernels.contact.edges import largest_move, take
from contactlab.kernels.contact.windows import columns as fill

PLACES = "i1 i1 i2 i2 d2 d2 d2 d2 d2 d2 d1"
"""Nodes of both sides; segments and node_segments of the slave; positions of slave and master where rows are made,
where gaps are measured and where the near list was made; lengths of the multipliers on full cover."""
COUPLING = "i1 i1 b1 d1 d1 d1 d1 d1 d1 i1 i1 i1 i1"
"""following, preceding, fixed, full, diagonal, lower, upper, cover, from_left, owner, next, previous, order."""
PIECES = "i2 i2 i2 d3 d3 d3 d2"
"""The arrays of `Pieces` in their order."""
COLUMNS = "i1 i1 d2 i1 i1 d2"
"""Columns of D, then of M: start, end, weight."""
GAPS = "d2 d2 d2 d2"
"""Measured positions of slave and master, separations, gaps."""
AT, MEASURED, PUSHED = 1, 2, 4  # what `place` is asked to do


@kernel
def place(bound, positions, compliance, force, asked):
    """Positions of the surfaces' nodes from those of all nodes (N, 2); returns how far they are from the near list.

    With AT rows belong to `positions`, with PUSHED moved by compliance * force; with MEASURED gaps do.
    """
    (
        slave, master, segments, node_segments, slave_at, master_at, slave_measured, master_measured, slave_before,
        master_before, full,
    ) = unpack(bound, PLACES)  # fmt: skip
    if asked & MEASURED:
        take(positions, slave, slave_measured)
        take(positions, master, master_measured)
    if not asked & AT:
        return 0.0
    take(positions, slave, slave_at)
    take(positions, master, master_at)
    if asked & PUSHED:
        _push(compliance, force, slave, slave_at)
        _push(compliance, force, master, master_at)
    tributary_lengths(slave_at, segments, node_segments, full)
    return max(largest_move(slave_at, slave_before), largest_move(master_at, master_before))


@kernel
def _push(compliance, force, nodes, at):
    for i in range(nodes.size):
        n = nodes[i]
        for c in range(2):
            at[i, c] += compliance[n, c] * force[n, c]


@kernel
def join(coupling, pieces, columns, gaps, count, straight, far):
    """Coupling, columns and gaps of the first `count` pieces.

    Returns (kept, single, width lacking in columns of D, in columns of M); gaps are there when nothing lacks.
    kept is -1 where a closed chain is covered all around. `straight`: every slave edge has two nodes.
    """
    following, preceding, fixed, full, diagonal, lower, upper, cover, from_left, owner, next_, previous, order = unpack(
        coupling, COUPLING
    )
    slave, multiplier, master, D, M, T, _ = unpack(pieces, PIECES)
    d_start, d_end, d_weight, m_start, m_end, m_weight = unpack(columns, COLUMNS)
    kept = couple(
        count, multiplier, T, full, fixed, following, preceding, diagonal, lower, upper, cover, owner, next_, previous,
        from_left, order,
    )  # fmt: skip
    if kept < 0:
        return kept, False, 0, 0
    single = straight and unmerged(owner, D, T, count)
    lacking = 0 if single else fill(count, multiplier, slave, D, owner, d_start, d_end, d_weight)
    missing = fill(count, multiplier, master, M, owner, m_start, m_end, m_weight)
    if lacking == 0 and missing == 0:
        measure(coupling, pieces, columns, gaps, kept, single, far)
    return kept, single, lacking, missing


@kernel
def measure(coupling, pieces, columns, gaps, kept, single, far):
    """Separations and gaps of the `kept` multipliers; those that are not kept count as `far` open."""
    _, _, _, _, _, lower, upper, _, from_left, _, next_, previous, order = unpack(coupling, COUPLING)
    normal = unpack(pieces, PIECES)[6]
    d_start, d_end, d_weight, m_start, m_end, m_weight = unpack(columns, COLUMNS)
    slave_at, master_at, separation, gap = unpack(gaps, GAPS)
    separations(
        kept, order, lower, upper, next_, previous, from_left, single, (d_start, d_end, d_weight),
        (m_start, m_end, m_weight), slave_at, master_at, normal, far, separation, gap,
    )  # fmt: skip


@kernel
def write_chained(coupling, pieces, columns, gaps, places, kept, single, first_slot, row, rows):
    """Append all conditions to the `row` ones of the model; returns their number, or -1 if out of room."""
    _, _, _, full, _, lower, upper, _, from_left, _, _, previous, order = unpack(coupling, COUPLING)
    normal = unpack(pieces, PIECES)[6]
    d_start, d_end, d_weight, m_start, m_end, m_weight = unpack(columns, COLUMNS)
    found = unpack(places, PLACES)
    return write_rows(
        kept, order, lower, upper, previous, from_left, single, (d_start, d_end, d_weight),
        (m_start, m_end, m_weight), found[0], found[1], normal, unpack(gaps, GAPS)[3], full, first_slot, row,
        unpack(rows, CHAINED),
    )  # fmt: skip
