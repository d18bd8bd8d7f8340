"""One contact pair from positions to gaps, on its bound arrays: what `OperatorPair` does in every step.

`bound` is the address of a `PairTable` throughout.
"""

from __future__ import annotations

from contactlab.api.compiled.chains import tributary_lengths
from contactlab.api.compiled.kernel import kernel
from contactlab.api.compiled.unpack import unpack
from contactlab.kernels.contact.banded_rows import fill_columns
from contactlab.kernels.contact.coupling import couple, unmerged
from contactlab.kernels.contact.factored_rows import separations
from contactlab.kernels.contact.search import largest_move, take
from contactlab.kernels.contact.tables import PairTable


@kernel
def place(bound, positions, compliance, force, pushed):
    """Positions of the surfaces' nodes from those of all nodes (N, 2); returns how far they are from the near list.

    Gaps belong to `positions`, and so do rows, or if they are `pushed` to positions + compliance * force.
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
    for i in range(c.absent.size):  # lengths of nodes without multiplier go to the carriers on either side, by halves
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
    """Coupling, columns and gaps of the first `count` segment contributions.

    Returns (kept, width lacking in columns of D, in columns of M); gaps are there when nothing lacks.
    kept is -1 where a closed chain is covered all around. `straight`: every slave edge has two nodes.
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
    """Separations and gaps (k, 2) of the kept multipliers with other `normals` at = positions of slave and master."""
    pair = unpack(bound, PairTable)
    separations(pair.coupling, pair.columns, at, normals, separation, gaps)
