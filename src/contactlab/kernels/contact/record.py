"""Step record of one pair: a row of numbers per slave node, in one call."""

from __future__ import annotations

from typing import NamedTuple

from contactlab.api.compiled.bound_arrays import Bytes2, Floats1, Floats2, Ints1, Ints2, Shorts2, Singles2
from contactlab.api.compiled.friction import STICKS, friction_limit
from contactlab.api.compiled.kernel import kernel, section
from contactlab.api.compiled.unpack import unpack
from contactlab.kernels.contact.coupling import solve_pivots
from contactlab.kernels.contact.pair import FAR, PairTable, separations
from contactlab.kernels.contact.search import take

NONE = 65535


class RecordScratch(NamedTuple):
    """Positions of both sides (m, 2), (l, 2), separations and gaps (k, 2), tractions (2, k) and slips (k,)."""

    slave: Floats2
    master: Floats2
    parted: Floats2
    apart: Floats2
    traction: Floats2
    slid: Floats1


class RecordColumns(NamedTuple):
    """Recorded columns, (b, m) each; shear and slip are empty without friction."""

    gap: Singles2
    pressure: Singles2
    shear: Singles2
    slip: Singles2
    state: Bytes2
    segment: Shorts2


class RecordTable(NamedTuple):
    """Inputs and outputs of a record, for m slave nodes and k multipliers of a pair, b rows.

    position, force, multipliers  of the model; `force` are the contact forces
    compliance       (N, 2) displacement per contact force in the last step [mm/N]; 0 if motion is prescribed
    law              (3 or more, k) coefficient, adhesion, cap of the friction law; (3, 0) without one
    slots            (1,) first multiplier of the pair
    next_master      (l, 2) segments that end and begin at each master node
    inner, following, preceding  nodes without a multiplier and their neighbours
    distance         (k,) [mm] uncounted gaps, all at `uncounted` = 1
    """

    position: Floats2
    force: Floats2
    multipliers: Floats2
    compliance: Floats2
    law: Floats2
    slots: Ints1
    next_master: Ints2
    inner: Ints1
    following: Ints1
    preceding: Ints1
    distance: Floats1
    scratch: RecordScratch
    out: RecordColumns


@kernel
def record_pair(row, bound_pair, bound, rows, count, uncounted):
    """Fill a row of the record of a pair from the last accepted step.

    bound_pair, bound  addresses of a `PairTable` and a `RecordTable`
    rows, count  the model's `Rows`, and how many are in use; -1: `slid` is filled already
    uncounted    share of `distance` that does not count [-]
    """
    pair, r = unpack(bound_pair, PairTable), unpack(bound, RecordTable)
    c, friction = pair.coupling, r.law.shape[1] > 0
    take(r.position, pair.places.slave, r.scratch.slave)
    take(r.position, pair.places.master, r.scratch.master)
    separations(
        c, pair.columns, (r.scratch.slave, r.scratch.master), pair.pieces.normal, r.scratch.parted, r.scratch.apart
    )
    if uncounted != 0.0:
        for k in range(r.distance.size):
            r.scratch.apart[k, 0] -= uncounted * r.distance[k]
    _tractions(c, r, friction)
    if friction and count >= 0:
        _slips(rows, count, r)
    nodes = r.out.gap.shape[1]
    for i in range(nodes):
        _node(row, i, nodes, c.cover, r, friction)
        r.out.segment[row, i] = _segment(i, nodes, pair.columns.master, c.owner, r.next_master)
    for j in range(r.inner.size):
        _between(row, r.inner[j], r.following[j], r.preceding[j], r, friction)


@section
def _tractions(c, r, friction):
    """Compute Lambda = T^-1 y, the owner's value for merged multipliers, 0 for dropped ones."""
    first = r.slots[0]
    for side in range(2 if friction else 1):
        values = r.scratch.traction[side]
        for k in range(values.size):
            values[k] = r.multipliers[side, first + k]
        solve_pivots(c, values)
        # owners are kept: values read here were not overwritten before
        for k in range(values.size):
            if c.owner[k] < 0:
                values[k] = 0.0
            elif c.owner[k] != k:
                values[k] = values[c.owner[k]]


@section
def _slips(rows, count, r):
    """Compute slips: the prediction of the rows plus the change by forces."""
    first, slots = r.slots[0], r.scratch.slid.size
    for k in range(slots):
        r.scratch.slid[k] = 0.0
    for i in range(count):
        k = rows.slot[i] - first
        if k < 0 or k >= slots:
            continue
        total = rows.slip[i]
        for z in range(rows.start[i], rows.start[i + 1]):
            n = rows.node[z]
            total += rows.tangent_weight[z, 0] * r.compliance[n, 0] * r.force[n, 0]
            total += rows.tangent_weight[z, 1] * r.compliance[n, 1] * r.force[n, 1]
        r.scratch.slid[k] = total


@section
def _node(row, i, nodes, cover, r, friction):
    """Write sums of tractions, mean slip, smallest gap and last state over the multipliers of a node."""
    first, gap, pressure, shear, slip, near, state = r.slots[0], FAR, 0.0, 0.0, 0.0, 0, 0
    for k in range(i, r.scratch.apart.shape[0], nodes):
        normal, tangential, limit = r.multipliers[0, first + k], 0.0, 0.0
        gap = min(gap, r.scratch.apart[k, 0])
        pressure += r.scratch.traction[0, k]
        if friction:
            tangential = r.multipliers[1, first + k]
            shear += r.scratch.traction[1, k]
            if r.scratch.apart[k, 0] < FAR:
                slip += r.scratch.slid[k]
                near += 1
            limit = friction_limit(r.law[0, k], r.law[1, k], r.law[2, k], cover[k], normal)
        if normal > 0.0 or tangential != 0.0:
            state = max(state, 1 if friction and abs(tangential) < limit * STICKS else 2)
    r.out.gap[row, i] = gap if gap < FAR else float("nan")
    r.out.pressure[row, i] = pressure
    r.out.state[row, i] = state
    if friction:
        r.out.shear[row, i], r.out.slip[row, i] = shear, slip / max(near, 1)


@section
def _segment(i, nodes, columns, owner, next_master):
    """Find the master segment whose two nodes have most of the weight in the constraints of a node."""
    heaviest, found = 0.0, NONE
    for k in range(i, owner.size, nodes):
        if owner[k] != k:
            continue
        start, end = columns.start[k], columns.end[k]
        for z in range(start, max(end - 1, start + 1) if end > start else start):
            segment = next_master[z, 1]
            weight = abs(columns.weight[k, z - start])
            if z + 1 < end:
                weight += abs(columns.weight[k, z + 1 - start])
            elif segment < 0:
                segment = next_master[z, 0]
            if weight > heaviest and 0 <= segment < NONE:
                heaviest, found = weight, segment
    return found


@section
def _between(row, i, after, before, r, friction):
    """Write a node without multiplier: the mean of its neighbours; it touches if a neighbour does."""
    r.out.gap[row, i] = 0.5 * (r.out.gap[row, after] + r.out.gap[row, before])
    r.out.pressure[row, i] = 0.5 * (r.out.pressure[row, after] + r.out.pressure[row, before])
    r.out.state[row, i] = max(r.out.state[row, after], r.out.state[row, before])
    r.out.segment[row, i] = r.out.segment[row, after]
    if friction:
        r.out.shear[row, i] = 0.5 * (r.out.shear[row, after] + r.out.shear[row, before])
        r.out.slip[row, i] = 0.5 * (r.out.slip[row, after] + r.out.slip[row, before])
