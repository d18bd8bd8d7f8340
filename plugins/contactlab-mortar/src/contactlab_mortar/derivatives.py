"""Derivatives of the pieces and normals by the positions of their nodes, coordinate by coordinate."""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import kernel, section
from contactlab.api.compiled.unpack import unpack
from contactlab_mortar.changes import average_normals, piece_changes, six_nodes
from contactlab_mortar.normals import normal_derivatives
from contactlab_mortar.segments import begin_piece, segments_of
from contactlab_mortar.tables import DerivativesTable


@section
def _combine(rates, v, c, changes, at, out):
    """Add to entry `at` what three numbers change, each times its rate by coordinate c of node v."""
    for z in range(3):
        rate = rates[z, v, c]
        for k in range(2):
            for i in range(out.shape[1]):
                out[at, i, k] += rate * changes[z, i, k]


@kernel
def mortar_derivatives(bound, count, linear, vertices):
    """Derivatives of the first `count` pieces, and of the averaged normals; returns how many entries both have.

    Also returns whether the normals of the pieces are the averaged ones, which are filled into the `DerivativesTable`
    at the address `bound`.
    """
    table = unpack(bound, DerivativesTable)
    sides, pieces, out, at = table.sides, table.pieces, table.out, 0
    slave = sides.slave
    smooth = average_normals(sides, pieces.normal, table.averaged)
    segments, nodes, rates = np.empty((count, 2), np.int64), np.empty(6, np.int64), np.empty((3, 6, 2))
    changes = np.empty((3, out.dD.shape[1], 2)), np.empty((3, out.dM.shape[1], 2)), np.empty((3, 2, 2))
    segments_of(sides, pieces, count, table.averaged, vertices, segments)
    for p in range(count):
        s, m = segments[p, 0], segments[p, 1]
        piece_changes(table, p, s, m, (linear, vertices), rates, changes)
        six_nodes(s, m, sides, nodes)
        for v in range(6):
            if nodes[v] < 0:
                continue
            for c in range(2):
                begin_piece(s, m, sides, vertices, at, (out.slave, out.multiplier, out.master, out.dD, out.dM, out.dT))
                out.moved[at] = 2 * nodes[v] + c
                _combine(rates, v, c, changes[0], at, out.dD)
                _combine(rates, v, c, changes[1], at, out.dM)
                _combine(rates, v, c, changes[2], at, out.dT)
                at += 1
    normals = out.normal_of, out.normal_moved, out.dnormal
    return at, normal_derivatives(sides.slave_at, slave.segments, slave.node_segments, normals), smooth
