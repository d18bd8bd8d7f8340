"""Smooth surfaces: curves through the nodes of both sides of a contact that replace their segments.

A curve lies off its segments by a cubic between any two nodes, to the left of a segment of length l from a to b by

    c(s) = s (1 - s)^2 v - s^2 (1 - s) w,    v = l m(alpha_a),  w = l m(alpha_b),  m(x) = (12 tan(x/2) - sin(x)) / 5,

where alpha is the angle from the segment to the tangent at a node, the tangent of the parabola through the node and
its neighbours. On an arc c has the area of the arc up to alpha^4 of itself: m is alpha (1 + 2/15 alpha^2), to this
order. `bends` are v and w as vectors. A piece of contact adds integrals of psi_j times c of the slave less integrals
of the master: `moments` (p, 4, 2) [mm] are the integrals of psi_j times s (1 - s)^2 and - s^2 (1 - s), of the slave
and, with the other sign, of the master.

`beside` (s, 2) holds the segments before and after each segment, -1 at ends of the curve: at ends of chains, at
corners. There it has the curvature of the other end.
"""

from __future__ import annotations

from contactlab.api.compiled.dual import derivatives, seed
from contactlab.api.compiled.kernel import kernel, point, section
from contactlab.api.compiled.unpack import unpack
from contactlab.api.tensors import Vector
from contactlab.kernels.contact.pair import PairTable


@point
def bend(other, edge):
    """Return l m(alpha) across an edge at the end that meets the `other` edge, both along the chain."""
    far, own = other.length(), edge.length()
    share = own / (far + own)
    tangent = (share * own / far) * other + (1.0 - share) * edge
    size = own * tangent.length()
    return (edge.cross(tangent) * (0.2 / size - 2.4 / (size + edge @ tangent))) * edge.turned()


@point
def hermite(s):
    """Return the weights of v and w at s."""
    return s * (1.0 - s) * (1.0 - s), -s * s * (1.0 - s)


@point
def edge_of(at, segments, s):
    """Return the edge of segment s."""
    a, b = segments[s, 0], segments[s, 1]
    return Vector(at[b, 0] - at[a, 0], at[b, 1] - at[a, 1])


@section
def put_bends(at, segments, beside, out):
    """Compute bends (s, 4) [mm] at positions (m, 2): v and w of each segment."""
    for s in range(segments.shape[0]):
        edge, before, after = edge_of(at, segments, s), beside[s, 0], beside[s, 1]
        v, w = Vector(0.0, 0.0), Vector(0.0, 0.0)
        if before >= 0:
            v = bend(edge_of(at, segments, before), edge)
        if after >= 0:
            w = bend(edge_of(at, segments, after), edge)
        if before < 0:
            v = -w
        if after < 0:
            w = -v
        out[s, 0], out[s, 1], out[s, 2], out[s, 3] = v.x, v.y, w.x, w.y


@kernel
def put_all_bends(at, sides):
    """Compute bends of both sides, see `shifts`."""
    for side in range(2):
        put_bends(at[side], sides[side][0], sides[side][1], sides[side][2])


@section
def _solve_transposed(c, values):
    """Overwrite values (k, 2) by T^-T values."""
    for i in range(c.kept[0]):
        k = c.order[i]
        p = c.previous[k]
        factor = c.upper[p] if p >= 0 else 0.0
        for d in range(2):
            carried = values[p, d] if p >= 0 else 0.0
            values[k, d] = (values[k, d] - factor * carried) / c.pivot[k]
    for i in range(c.kept[0] - 1, -1, -1):
        k = c.order[i]
        n = c.next[k]
        if n >= 0:
            for d in range(2):
                values[k, d] -= c.lower[n] / c.pivot[k] * values[n, d]


@kernel
def shifts(bound, count, at, sides, places, moments, out):
    """Compute shifts of separations by curves, (k, 2) [mm], with the last coupling; 0 without a constraint.

    `bound` is the address of a `PairTable`; of slave and master: at (m, 2), sides = segments, `beside` and arrays for
    bends, places (p, 2) the segments of each piece
    """
    c, multiplier = unpack(bound, PairTable).coupling, unpack(bound, PairTable).pieces.multiplier
    put_all_bends(at, sides)
    for k in range(out.shape[0]):
        out[k, 0], out[k, 1] = 0.0, 0.0
    for p in range(count):
        for side in range(2):
            s, bends = places[p, side], sides[side][2]
            for j in range(multiplier.shape[1]):
                k = c.owner[multiplier[p, j]]
                if k >= 0:
                    v, w = moments[p, 2 * side, j], moments[p, 2 * side + 1, j]
                    out[k, 0] += v * bends[s, 0] + w * bends[s, 2]
                    out[k, 1] += v * bends[s, 1] + w * bends[s, 3]
    _solve_transposed(c, out)


@kernel
def add_normal(shift, normals, gaps):
    """Add the part of shifts (k, 2) along normals to the normal gaps (k, 2)."""
    for k in range(shift.shape[0]):
        gaps[k, 0] += normals[k, 0] * shift[k, 0] + normals[k, 1] * shift[k, 1]


# --- derivatives ------------------------------------------------------------------------------------------------------


@section
def put_rates(at, segments, beside, rates):
    """Compute derivatives (s, 4, 8) of the bends by four nodes' coordinates: before the segment, its own, after it."""
    for s in range(segments.shape[0]):
        before, after, i, j = beside[s, 0], beside[s, 1], segments[s, 0], segments[s, 1]
        a, b = Vector(seed(at[i, 0], 2, 8), seed(at[i, 1], 3, 8)), Vector(seed(at[j, 0], 4, 8), seed(at[j, 1], 5, 8))
        v, w = 0.0 * (b - a), 0.0 * (b - a)
        if before >= 0:
            n = segments[before, 0]
            v = bend(a - Vector(seed(at[n, 0], 0, 8), seed(at[n, 1], 1, 8)), b - a)
        if after >= 0:
            n = segments[after, 1]
            w = bend(Vector(seed(at[n, 0], 6, 8), seed(at[n, 1], 7, 8)) - b, b - a)
        if before < 0:
            v = -w
        if after < 0:
            w = -v
        vx, vy, wx, wy = derivatives(v.x, 8), derivatives(v.y, 8), derivatives(w.x, 8), derivatives(w.y, 8)
        for q in range(8):
            rates[s, 0, q], rates[s, 1, q], rates[s, 2, q], rates[s, 3, q] = vx[q], vy[q], wx[q], wy[q]


@kernel
def bend_derivatives(count, multiplier, owner, places, moments, at, sides, out):
    """Write derivatives of separations by bends, before T: entries 2 k + component by coordinate. Return their number.

    sides = segments, `beside`, global nodes and arrays for rates (s, 4, 8), of slave and master
    out = row, column, value
    """
    row, column, value = out
    e = 0
    for side in range(2):
        segments, beside, nodes, rates = sides[side]
        put_rates(at[side], segments, beside, rates)
        for p in range(count):
            s = places[p, side]
            before, after = beside[s, 0], beside[s, 1]
            for z in range(4):
                if (z == 0 and before < 0) or (z == 3 and after < 0):
                    continue
                n = segments[s, 0] if z == 1 else segments[s, 1]
                n = segments[before, 0] if z == 0 else (segments[after, 1] if z == 3 else n)
                for j in range(multiplier.shape[1]):
                    k = owner[multiplier[p, j]]
                    if k < 0:
                        continue
                    v, w = moments[p, 2 * side, j], moments[p, 2 * side + 1, j]
                    for c in range(2):
                        for d in range(2):
                            row[e], column[e] = 2 * k + d, 2 * nodes[n] + c
                            value[e] = v * rates[s, d, 2 * z + c] + w * rates[s, 2 + d, 2 * z + c]
                            e += 1
    return e
