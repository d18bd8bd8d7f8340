"""How the integrals of a piece change with the positions of its nodes.

A piece depends on six nodes: the ends of its slave segment and their neighbours, by the averaged normals, and the ends
of its master segment. It does so by three numbers alone: how far each end of the overlap is off, (y - x) x n at fixed
xi and eta, and the length of its slave segment. So its changes are those by three numbers times the rates (3, 6, 2) of
these by the positions of six nodes.
"""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import point, section
from contactlab_mortar.integrals import integrate_changes
from contactlab_mortar.normals import edge_sum, inward_normals
from contactlab_mortar.overlap import FLANK, facing, opposed, overlap
from contactlab_mortar.projection import across, edge_vector, master_segment, slave_segment
from contactlab_mortar.segments import halves_of


@section
def average_normals(sides, given, averaged):
    """Fill the averaged inward normals (m, 2); returns whether the `given` ones are the same everywhere."""
    inward_normals(sides.slave_at, sides.slave.segments, averaged)
    for k in range(given.shape[0]):
        if given[k, 0] != averaged[k, 0] or given[k, 1] != averaged[k, 1]:
            return False
    return True


@section
def six_nodes(s, m, sides, out):
    """Nodes that a piece of segments s and m depends on, those of the master after the slave's; -1 where none is."""
    segments, node_segments, shift = sides.slave.segments, sides.slave.node_segments, sides.slave_at.shape[0]
    i, j = segments[s, 0], segments[s, 1]
    before, after = node_segments[i, 0], node_segments[j, 1]
    out[0] = segments[before, 0] if before >= 0 else -1
    out[1], out[2] = i, j
    out[3] = segments[after, 1] if after >= 0 else -1
    out[4], out[5] = shift + sides.master.segments[m, 0], shift + sides.master.segments[m, 1]


@point
def end_of(found, end):
    """xi and eta where an overlap begins (0) or ends (1)."""
    return (found.low, found.eta_low) if end == 0 else (found.high, found.eta_high)


@point
def end_change(end, slave, master, found):
    """What xi and eta of an end of an overlap change by as (y - x) x n does at fixed xi and eta: one of both stays."""
    xi, eta = end_of(found, end)
    qx, qy = slave.nx + xi * slave.mx, slave.ny + xi * slave.my
    if xi == float(end):
        fx, fy = edge_vector(master)
        return 0.0, -1.0 / (fx * qy - fy * qx)
    rx, ry = across(xi, eta, slave, master)
    return -1.0 / (-slave.ex * qy + slave.ey * qx + rx * slave.my - ry * slave.mx), 0.0


@section
def end_rates(end, s, sides, slave, master, found, out):
    """d[(y - x) x n] at fixed xi and eta of an end of an overlap by the positions of six nodes, into out (6, 2)."""
    xi, eta = end_of(found, end)
    qx, qy = slave.nx + xi * slave.mx, slave.ny + xi * slave.my
    rx, ry = across(xi, eta, slave, master)
    for v in range(6):
        weight = 0.0
        if v == 1:
            weight = xi - 1.0
        elif v == 2:
            weight = -xi
        elif v == 4:
            weight = 1.0 - eta
        elif v == 5:
            weight = eta
        out[v, 0], out[v, 1] = weight * qy, -weight * qx
    # a normal turns by t x d(edge)/|edge|, t the unit vector of the edges that meet there
    for side in range(2):
        node = sides.slave.segments[s, side]
        ex, ey = edge_sum(node, sides.slave_at, sides.slave.segments, sides.slave.node_segments)
        size, share = ex * ex + ey * ey, 1.0 - xi if side == 0 else xi
        turn = share * (rx * ey - ry * ex) / (size * np.sqrt(size))
        x, y = -turn * ey, turn * ex
        # what would belong to a neighbour belongs to the end of a chain itself
        low = 1 if side == 1 or sides.slave.node_segments[node, 0] < 0 else 0
        high = 2 if side == 0 or sides.slave.node_segments[node, 1] < 0 else 3
        out[low, 0] -= x
        out[low, 1] -= y
        out[high, 0] += x
        out[high, 1] += y


@section
def length_rates(slave, master, weight, out):
    """d log(weight times length of the slave segment) by the positions of six nodes, into out (6, 2)."""
    ex, ey, (fx, fy) = slave.ex, slave.ey, edge_vector(master)
    square = ex * ex + ey * ey
    x, y, u, v = ex / square, ey / square, 0.0, 0.0
    if weight < 1.0:
        # of the cosine c: d log c = (f/(e.f) - e/e.e).de + (e/(e.f) - f/f.f).df
        cosine, along, other = opposed(slave, master), ex * fx + ey * fy, fx * fx + fy * fy
        grows = cosine / (cosine - FLANK)
        u, v = grows * (ex / along - fx / other), grows * (ey / along - fy / other)
        x, y = x + grows * (fx / along - x), y + grows * (fy / along - y)
    out[:] = 0.0
    out[1, 0], out[1, 1], out[2, 0], out[2, 1] = -x, -y, x, y
    out[4, 0], out[4, 1], out[5, 0], out[5, 1] = -u, -v, u, v


@section
def _grow(integral, p, change):
    """What the integrals (p, w, 2) of piece p grow by with the logarithm of its length, into change[2]: themselves."""
    for i in range(change.shape[1]):
        change[2, i, 0], change[2, i, 1] = integral[p, i, 0], integral[p, i, 1]


@section
def piece_changes(table, p, s, m, space, rates, out):
    """Changes of piece p by three numbers into out = dD (3, w, 2), dM (3, r, 2), dT (3, 2, 2), their rates (3, 6, 2).

    The numbers: how far off the overlap is where it begins and where it ends, and the logarithm of the weighted length
    of the slave segment, with which all integrals grow. space = (linear, vertices)
    """
    sides, pieces = table.sides, table.pieces
    slave = slave_segment(s, sides.slave_at, sides.slave.segments, table.averaged)
    master = master_segment(m, sides.master_at, sides.master.segments)
    found = overlap(slave, master)
    length, halves = np.sqrt(slave.ex * slave.ex + slave.ey * slave.ey), halves_of(s, m, sides, space[1])
    weight = facing(slave, master)
    for array in out:
        array[:2] = 0.0
    for end in range(2):
        end_rates(end, s, sides, slave, master, found, rates[end])
        xi, eta = end_change(end, slave, master, found)
        change = (xi, 0.0, eta, 0.0) if end == 0 else (0.0, xi, 0.0, eta)
        integrate_changes(found, weight * length, halves, space[0], change, end, out)
    _grow(pieces.D, p, out[0])
    _grow(pieces.M, p, out[1])
    _grow(pieces.T, p, out[2])
    length_rates(slave, master, weight, rates[2])
