"""A contact pair from positions to gaps, on its bound arrays: the work of `OperatorPair` in every step.

`bound` is the address of a `PairTable` throughout.
"""

from __future__ import annotations

from contactlab.api.compiled.chains import tributary_lengths
from contactlab.api.compiled.kernel import kernel, section
from contactlab.api.compiled.unpack import unpack
from contactlab.kernels.contact.banded_rows import fill_columns
from contactlab.kernels.contact.coupling import couple, unmerged
from contactlab.kernels.contact.search import largest_move, take
from contactlab.kernels.contact.tables import PairTable

FAR = 1e300  # gap of a multiplier that is not kept


@section
def weigh(k, column, at, sign, x, y):
    """Return x and y plus sign times the weighted sum of positions `at` over column k."""
    start, end, weight = column.start, column.end, column.weight
    begin = start[k]
    for z in range(begin, end[k]):
        w = sign * weight[k, z - begin]
        x += w * at[z, 0]
        y += w * at[z, 1]
    return x, y


@kernel
def separations(c, columns, at, normals, separation, gaps):
    """Compute the vector from the master's to the slave's weighted position, its normal and tangential part (k, 2).

    at = positions of slave and master; dropped constraints count as `FAR` open.
    Both substitutions with T^T carry the last place of a chain in x and y, as `order` goes along the chains.
    """
    slave_at, master_at = at
    single, order, kept, nodes = c.single[0], c.order, c.kept[0], slave_at.shape[0]
    pivot, lower, upper, next_, previous = c.pivot, c.lower, c.upper, c.next, c.previous
    for k in range(gaps.shape[0]):
        gaps[k, 0] = FAR
    x, y = 0.0, 0.0
    for i in range(kept):
        k = order[i]
        u, v = weigh(k, columns.master, master_at, -1.0, 0.0, 0.0)
        if not single:
            u, v = weigh(k, columns.slave, slave_at, 1.0, u, v)
        p, inverse = previous[k], 1.0 / pivot[k]
        factor = upper[p] * inverse if p >= 0 else 0.0
        x, y = u * inverse - factor * x, v * inverse - factor * y
        separation[k, 0], separation[k, 1] = x, y
    x, y = 0.0, 0.0
    for i in range(kept - 1, -1, -1):
        k = order[i]
        n = next_[k]
        factor = lower[n] / pivot[k] if n >= 0 else 0.0
        x, y = separation[k, 0] - factor * x, separation[k, 1] - factor * y
        u, v = x, y
        if single:
            node = k % nodes
            u, v = u + slave_at[node, 0], v + slave_at[node, 1]
        nx, ny = normals[k, 0], normals[k, 1]
        separation[k, 0], separation[k, 1] = u, v
        gaps[k, 0], gaps[k, 1] = nx * u + ny * v, ny * u - nx * v


@kernel
def largest_sideways(bound):
    """Return the largest offset across the normal between joined points, over the length of their slave segments.

    `bound` is the address of a `PairTable`, with gaps at the positions of the constraints.
    """
    pair = unpack(bound, PairTable)
    c, largest = pair.coupling, 0.0
    for i in range(c.kept[0]):
        k = c.order[i]
        largest = max(largest, abs(pair.gaps[k, 1]) / c.full[k])
    return largest


@kernel
def place(bound, positions, compliance, force, pushed):
    """Copy positions of surface nodes from all nodes (N, 2). Return their distance from the near list.

    Gaps belong to `positions`, and so do rows, unless they are `pushed` to positions + compliance * force.
    """
    pair = unpack(bound, PairTable)
    at = pair.places
    take(positions, at.slave, at.slave_measured)
    take(positions, at.master, at.master_measured)
    take(positions, at.slave, at.slave_at)
    take(positions, at.master, at.master_at)
    if pushed:
        _push(compliance, force, at.slave, at.slave_at)
        _push(compliance, force, at.master, at.master_at)
    c, full = pair.coupling, pair.coupling.full
    tributary_lengths(at.slave_at, at.segments, at.node_segments, full)
    for i in range(c.absent.size):  # half the length of nodes without multiplier goes to each adjacent node with one
        k = c.absent[i]
        full[c.following[k]] += 0.5 * full[k]
        full[c.preceding[k]] += 0.5 * full[k]
        full[k] = 0.0
    return max(largest_move(at.slave_at, at.slave_before), largest_move(at.master_at, at.master_before))


@kernel
def _push(compliance, force, nodes, at):
    for i in range(nodes.size):
        n = nodes[i]
        for c in range(2):
            at[i, c] += compliance[n, c] * force[n, c]


@kernel
def join(bound, count, straight):
    """Compute coupling, columns and gaps of the first `count` segment contributions.

    Returns (kept, width lacking in columns of D, in columns of M); gaps are valid if nothing lacks.
    kept is -1 if a closed chain overlaps all around. `straight`: every slave edge has two nodes.
    """
    pair = unpack(bound, PairTable)
    c, pieces, columns = pair.coupling, pair.pieces, pair.columns
    kept = couple(count, pieces.multiplier, pieces.T, c)
    if kept < 0:
        return kept, 0, 0
    single = straight and unmerged(c.owner, pieces.D, pieces.T, count)
    c.single[0] = single
    lacking = 0
    if not single:
        lacking = fill_columns(count, pieces.multiplier, pieces.slave, pieces.D, c.owner, columns.slave)
    missing = fill_columns(count, pieces.multiplier, pieces.master, pieces.M, c.owner, columns.master)
    if lacking == 0 and missing == 0:
        at = (pair.places.slave_measured, pair.places.master_measured)
        separations(c, columns, at, pieces.normal, pair.separation, pair.gaps)
    return kept, lacking, missing


@kernel
def compute_gaps_at(bound, at, normals, separation, gaps):
    """Compute separations and gaps (k, 2) of kept multipliers with other `normals`, at = slave and master positions."""
    pair = unpack(bound, PairTable)
    separations(pair.coupling, pair.columns, at, normals, separation, gaps)
