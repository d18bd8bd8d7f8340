"""All pieces of a mortar contact: slave segment by slave segment, overlap by overlap."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.api.compiled.bound_arrays import Floats2, Ints1
from contactlab.api.compiled.chains import nodal_normals, segment_normals
from contactlab.api.compiled.contact_tables import PiecesTable, SurfaceTable
from contactlab.api.compiled.kernel import kernel, point, section
from contactlab.api.compiled.unpack import unpack
from contactlab_mortar.integrals import integrate, integrate_straight
from contactlab_mortar.projection import master_parameter, opening, slave_parameter
from contactlab_mortar.vertices import turn_at_vertices

FACING = 0.25  # cosine by which normals must be opposed: flanks of a corner are no partners
SMALLEST = 1e-12  # overlaps shorter than this fraction of a slave segment carry nothing but round-off


class MortarTable(NamedTuple):
    """All that pieces are made from and written to; start and candidates are the near list."""

    slave: SurfaceTable
    master: SurfaceTable
    slave_at: Floats2
    master_at: Floats2
    start: Ints1
    candidates: Ints1
    pieces: PiecesTable


@point
def _ends(first, second):
    """Part of the slave segment between two parameters: low and high, high below low where there is none."""
    if np.isnan(first) or np.isnan(second):
        return 1.0, 0.0
    return max(0.0, min(first, second)), min(1.0, max(first, second))


@point
def _seen(xi, first, second, ax, ay, ex, ey, nx, ny, mx, my, cx, cy, fx, fy):
    """eta at an end xi of an overlap: a master node where the end is one, else where the normal meets the segment."""
    if xi == first:
        return 0.0
    if xi == second:
        return 1.0
    return min(1.0, max(0.0, master_parameter(xi, ax, ay, ex, ey, nx, ny, mx, my, cx, cy, fx, fy)))


@point
def _faces(ex, ey, fx, fy):
    """Whether two segments face each other: their directions are opposed, as the bodies lie on the left of both."""
    along = ex * fx + ey * fy
    return along < 0.0 and along * along >= FACING * FACING * ((ex * ex + ey * ey) * (fx * fx + fy * fy))


@section
def overlap(a, b, na, nb, c, d, out):
    """Overlap of slave (a, b) with normals (na, nb) and master (c, d) into out (6,).

    out = xi_low, xi_high, eta at either end, gap at either end. False where they do not overlap or
    do not face each other.
    """
    ex, ey, fx, fy = b[0] - a[0], b[1] - a[1], d[0] - c[0], d[1] - c[1]
    nx, ny, mx, my = na[0], na[1], nb[0] - na[0], nb[1] - na[1]
    if not _faces(ex, ey, fx, fy):
        return False
    first = slave_parameter(a[0], a[1], ex, ey, nx, ny, mx, my, c[0], c[1])
    second = slave_parameter(a[0], a[1], ex, ey, nx, ny, mx, my, d[0], d[1])
    low, high = _ends(first, second)
    if not high - low > SMALLEST:
        return False
    for i in range(2):
        xi = low if i == 0 else high
        eta = _seen(xi, first, second, a[0], a[1], ex, ey, nx, ny, mx, my, c[0], c[1], fx, fy)
        out[i] = xi
        out[2 + i] = eta
        out[4 + i] = opening(xi, eta, a[0], a[1], ex, ey, nx, ny, mx, my, c[0], c[1], fx, fy)
    return True


@point
def _tilt(tx, ty, ax, ay, bx, by):
    """Largest slope of the field between the normals a and b against the segment's own normal."""
    a = abs(ax * tx + ay * ty) / max(abs(ax * ty - ay * tx), 1e-3)
    b = abs(bx * tx + by * ty) / max(abs(bx * ty - by * tx), 1e-3)
    return max(a, b)


@kernel
def inward_normals(positions, segments, node_segments, normals):
    """Averaged slave normals (m, 2), length-weighted and turned inward; returns the longest segment [mm]."""
    normal, length = np.empty((segments.shape[0], 2)), np.empty(segments.shape[0])
    segment_normals(positions, segments, normal, length)
    nodal_normals(node_segments, normal, length, normals)
    for i in range(normals.shape[0]):
        normals[i, 0], normals[i, 1] = -normals[i, 0], -normals[i, 1]
    longest = 0.0
    for s in range(length.size):
        longest = max(longest, length[s])
    return longest


@point
def _passes(low, high, least, length, starts, ends):
    """Whether the end of a chain slips past the end of the other: `least` deeper behind it than both overlap.

    That is the far flank of a corner whose near flank carries the contact.
    """
    at_end = (starts and low == 0.0) or (ends and high == 1.0)
    return at_end and -least > 2.0 * (high - low) * length


@kernel
def _begin(edges, edge, nodes, p, values):
    """Nodes of an edge into piece p, and zero for the integrals of its traces."""
    for k in range(edges.shape[1]):
        nodes[p, k] = edges[edge, k]
        values[p, k, 0], values[p, k, 1] = 0.0, 0.0


@kernel
def mortar_pieces(bound, reach, depth, linear, vertices):
    """Fill the pieces; returns their number.

    `bound` is the address of a `MortarTable`.
    A slave segment farther than `reach` [mm] or deeper than `depth` segments at all its overlaps is left out.
    `vertices`: multipliers of quadratic slave edges belong to their ends alone.
    """
    found = unpack(bound, MortarTable)
    segments, node_segments, edges, segment_edge = found.slave
    master_segments, _, master_edges, master_segment_edge = found.master
    slave_at, master_at, start, candidates = found.slave_at, found.master_at, found.start, found.candidates
    slave_nodes, multipliers, master_nodes, D, M, T, inward = found.pieces
    depth *= inward_normals(slave_at, segments, node_segments, inward)
    straight = edges.shape[1] == 2 and master_edges.shape[1] == 2
    vertices = vertices and edges.shape[1] == 3
    count = 0
    for s in range(segments.shape[0]):
        if start[s] == start[s + 1]:
            continue
        i, j = segments[s, 0], segments[s, 1]
        ax, ay, bx, by = slave_at[i, 0], slave_at[i, 1], slave_at[j, 0], slave_at[j, 1]
        nx, ny, mx, my = -inward[i, 0], -inward[i, 1], -inward[j, 0], -inward[j, 1]
        starts, ends = node_segments[i, 0] < 0, node_segments[j, 1] < 0
        ex, ey = bx - ax, by - ay
        length = np.sqrt(ex * ex + ey * ey)
        tx, ty = ex / length, ey / length
        tilt, slack = _tilt(tx, ty, nx, ny, mx, my), 1e-9 * length
        mx, my = mx - nx, my - ny
        begin, close, before, seen, parameter = count, False, -1, -1, 0.0
        dx, dy, d_along, d_away = 0.0, 0.0, 0.0, 0.0
        for z in range(start[s], start[s + 1]):
            m = candidates[z]
            first_node, second_node = master_segments[m, 0], master_segments[m, 1]
            # neighbours on the master share a node
            if before == first_node:
                cx, cy, c_along, c_away = dx, dy, d_along, d_away
            else:
                cx, cy = master_at[first_node, 0], master_at[first_node, 1]
                c_along, c_away = (cx - ax) * tx + (cy - ay) * ty, abs((cx - ax) * ty - (cy - ay) * tx)
            dx, dy = master_at[second_node, 0], master_at[second_node, 1]
            d_along, d_away = (dx - ax) * tx + (dy - ay) * ty, abs((dx - ax) * ty - (dy - ay) * tx)
            before = second_node
            # beside the slave segment, beyond where any of its normals leads
            beyond = tilt * max(c_away, d_away) + slack
            if max(c_along, d_along) < -beyond or min(c_along, d_along) > length + beyond:
                continue
            fx, fy = dx - cx, dy - cy
            if not _faces(ex, ey, fx, fy):
                continue
            first = parameter
            if seen != first_node:
                first = slave_parameter(ax, ay, ex, ey, nx, ny, mx, my, cx, cy)
            second = slave_parameter(ax, ay, ex, ey, nx, ny, mx, my, dx, dy)
            seen, parameter = second_node, second
            low, high = _ends(first, second)
            if not high - low > SMALLEST:
                continue
            eta_low = _seen(low, first, second, ax, ay, ex, ey, nx, ny, mx, my, cx, cy, fx, fy)
            eta_high = _seen(high, first, second, ax, ay, ex, ey, nx, ny, mx, my, cx, cy, fx, fy)
            least = min(
                opening(low, eta_low, ax, ay, ex, ey, nx, ny, mx, my, cx, cy, fx, fy),
                opening(high, eta_high, ax, ay, ex, ey, nx, ny, mx, my, cx, cy, fx, fy),
            )
            if least < -depth or _passes(low, high, least, length, starts, ends):
                continue
            close = close or least <= reach
            if vertices:
                multipliers[count, 0], multipliers[count, 1] = carriers(s, edges, segment_edge)
            else:
                multipliers[count, 0], multipliers[count, 1] = i, j
            if straight:
                slave_nodes[count, 0], slave_nodes[count, 1] = i, j
                master_nodes[count, 0], master_nodes[count, 1] = first_node, second_node
                integrate_straight(low, high, eta_low, eta_high, length, linear, count, D, M, T)
            else:
                _begin(edges, segment_edge[s, 0], slave_nodes, count, D)
                _begin(master_edges, master_segment_edge[m, 0], master_nodes, count, M)
                halves = (segment_edge[s, 1], master_segment_edge[m, 1], segment_edge[s, 1] + 1 if vertices else 0)
                _integrate_halves(low, high, eta_low, eta_high, length, halves, linear, count, D, M, T)
            count += 1
        if not close:
            count = begin
    turn_at_vertices(count, (multipliers, master_nodes, T), (segments, node_segments), slave_at, master_at, inward)
    return count


@point
def carriers(s, edges, segment_edge):
    """Ends of the quadratic edge of slave segment s: first the one that this half touches, then the other."""
    edge, half = segment_edge[s, 0], segment_edge[s, 1]
    return edges[edge, half], edges[edge, 1 - half]


@kernel
def _integrate_halves(low, high, eta_low, eta_high, length, halves, linear, p, D, M, T):
    """Integrate an overlap, cut where the P0 basis jumps."""
    T[p, 0, 0], T[p, 0, 1], T[p, 1, 0], T[p, 1, 1] = 0.0, 0.0, 0.0, 0.0
    slope = (eta_high - eta_low) / (high - low)
    whole = linear or halves[2] != 0
    for part in range(1 if whole else 2):
        begin, finish = low, high
        if not whole:
            begin, finish = (low, min(high, 0.5)) if part == 0 else (max(low, 0.5), high)
        if finish <= begin:
            continue
        first, last = eta_low + (begin - low) * slope, eta_low + (finish - low) * slope
        integrate(begin, finish, first, last, length, halves[0], halves[1], halves[2], linear, p, D, M, T)
