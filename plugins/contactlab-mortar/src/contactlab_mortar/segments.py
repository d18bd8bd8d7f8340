"""All pieces of a mortar contact: slave segment by slave segment, overlap by overlap."""

from __future__ import annotations

import numpy as np

from contactlab.api.chains import nodal_normals, segment_normals
from contactlab.api.kernel import kernel, point, section
from contactlab_mortar.integrals import integrate
from contactlab_mortar.projection import master_parameter, opening, slave_parameter

FACING = 0.25  # cosine by which normals must be opposed: flanks of a corner are no partners
SMALLEST = 1e-12  # overlaps shorter than this fraction of a slave segment carry nothing but round-off


@section
def overlap(a, b, na, nb, c, d, out):
    """Overlap of slave (a, b) with normals (na, nb) and master (c, d) into out (6,).

    out = xi_low, xi_high, eta at either end, gap at either end. False where they do not overlap or
    do not face each other.
    """
    ex, ey, fx, fy = b[0] - a[0], b[1] - a[1], d[0] - c[0], d[1] - c[1]
    nx, ny, mx, my = na[0], na[1], nb[0] - na[0], nb[1] - na[1]
    if ex * fx + ey * fy > -FACING * np.sqrt((ex * ex + ey * ey) * (fx * fx + fy * fy)):
        return False
    first = slave_parameter(a[0], a[1], ex, ey, nx, ny, mx, my, c[0], c[1])
    second = slave_parameter(a[0], a[1], ex, ey, nx, ny, mx, my, d[0], d[1])
    if np.isnan(first) or np.isnan(second):
        return False
    low, high = max(0.0, min(first, second)), min(1.0, max(first, second))
    if not high - low > SMALLEST:
        return False
    for i in range(2):
        xi = low if i == 0 else high
        eta = master_parameter(xi, a[0], a[1], ex, ey, nx, ny, mx, my, c[0], c[1], fx, fy)
        eta = min(1.0, max(0.0, eta))
        out[i] = xi
        out[2 + i] = eta
        out[4 + i] = opening(xi, eta, a[0], a[1], ex, ey, nx, ny, mx, my, c[0], c[1], fx, fy)
    return True


@point
def _tilt(tx, ty, na, nb):
    """Largest slope of the normal field against the segment's own normal."""
    a = abs(na[0] * tx + na[1] * ty) / max(abs(na[0] * ty - na[1] * tx), 1e-3)
    b = abs(nb[0] * tx + nb[1] * ty) / max(abs(nb[0] * ty - nb[1] * tx), 1e-3)
    return max(a, b)


@point
def _beside(a, tx, ty, length, tilt, c, d):
    """Whether a master segment lies beside the slave segment, beyond where any of its normals leads."""
    c_along, d_along = (c[0] - a[0]) * tx + (c[1] - a[1]) * ty, (d[0] - a[0]) * tx + (d[1] - a[1]) * ty
    c_away, d_away = abs((c[0] - a[0]) * ty - (c[1] - a[1]) * tx), abs((d[0] - a[0]) * ty - (d[1] - a[1]) * tx)
    slack = tilt * max(c_away, d_away) + 1e-9 * length
    return max(c_along, d_along) < -slack or min(c_along, d_along) > length + slack


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
def _passes(found, length, starts, ends):
    """Whether the end of a chain slips past the end of the other: deeper behind it than both overlap.

    That is the far flank of a corner whose near flank carries the contact.
    """
    at_end = (starts and found[0] == 0.0) or (ends and found[1] == 1.0)
    return at_end and -min(found[4], found[5]) > 2.0 * (found[1] - found[0]) * length


@kernel
def _begin(edges, edge, nodes, p, values):
    """Nodes of an edge into piece p, and zero for the integrals of its traces."""
    for k in range(edges.shape[1]):
        nodes[p, k] = edges[edge, k]
        values[p, k, 0], values[p, k, 1] = 0.0, 0.0


@kernel
def mortar_pieces(slave, master, slave_at, master_at, near, reach, depth, linear, out):
    """Fill the pieces; returns their number.

    slave = (segments, node_segments, edges, segment_edge), master = (segments, edges, segment_edge)
    near = (start, master segments); out = (slave nodes, multipliers, master nodes, D, M, T, normals)
    A slave segment farther than `reach` [mm] or deeper than `depth` segments at all its overlaps is left out.
    """
    segments, node_segments, edges, segment_edge = slave
    master_segments, master_edges, master_segment_edge = master
    start, candidates = near
    slave_nodes, multipliers, master_nodes, D, M, T, inward = out
    depth *= inward_normals(slave_at, segments, node_segments, inward)
    normals, found = np.empty(inward.shape), np.empty(6)
    for i in range(inward.shape[0]):
        normals[i, 0], normals[i, 1] = -inward[i, 0], -inward[i, 1]
    count = 0
    for s in range(segments.shape[0]):
        i, j = segments[s, 0], segments[s, 1]
        a, b = slave_at[i], slave_at[j]
        ex, ey = b[0] - a[0], b[1] - a[1]
        length = np.sqrt(ex * ex + ey * ey)
        tilt = _tilt(ex / length, ey / length, normals[i], normals[j])
        begin, close = count, False
        for z in range(start[s], start[s + 1]):
            m = candidates[z]
            c, d = master_at[master_segments[m, 0]], master_at[master_segments[m, 1]]
            if _beside(a, ex / length, ey / length, length, tilt, c, d):
                continue
            if not overlap(a, b, normals[i], normals[j], c, d, found):
                continue
            least = min(found[4], found[5])
            if least < -depth or _passes(found, length, node_segments[i, 0] < 0, node_segments[j, 1] < 0):
                continue
            close = close or least <= reach
            _begin(edges, segment_edge[s, 0], slave_nodes, count, D)
            _begin(master_edges, master_segment_edge[m, 0], master_nodes, count, M)
            for k in range(2):
                multipliers[count, k] = segments[s, k]
                T[count, 0, k], T[count, 1, k] = 0.0, 0.0
            _integrate_halves(found, length, segment_edge[s, 1], master_segment_edge[m, 1], linear, count, D, M, T)
            count += 1
        if not close:
            count = begin
    return count


@section
def _integrate_halves(found, length, slave_half, master_half, linear, p, D, M, T):
    """Integrate an overlap, cut where the P0 basis jumps."""
    low, high, eta_low, eta_high = found[0], found[1], found[2], found[3]
    slope = (eta_high - eta_low) / (high - low)
    for part in range(2):
        begin, finish = low, high
        if not linear:
            begin, finish = (low, min(high, 0.5)) if part == 0 else (max(low, 0.5), high)
        if finish <= begin or (linear and part == 1):
            continue
        first, last = eta_low + (begin - low) * slope, eta_low + (finish - low) * slope
        integrate(begin, finish, first, last, length, slave_half, master_half, linear, p, D, M, T)
