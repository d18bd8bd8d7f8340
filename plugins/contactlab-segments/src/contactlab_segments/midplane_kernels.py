"""Overlaps of two chains of segments, pair by pair: energy, forces, stiffness, and points that rub.

A pair is two segments that face each other. Points of both are matched along the mean of their normals, and pressure is
k times the overlap: linear along a segment, so that all integrals are exact (docs/theory/midplane.md).
"""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled import mathematics  # noqa: F401 - vectors of dual numbers inside kernels
from contactlab.api.compiled.dual import derivatives, seed
from contactlab.api.compiled.kernel import kernel, point
from contactlab.api.mathematics import sqrt
from contactlab.api.tensors import Vector

FACING = 0.3  # cosine from which on outward normals count as opposed: segments beyond are flanks of a corner
BEYOND = 0.1  # of a segment that a chain's end may lie beyond the end of the other chain
TOUCH = 1e-9  # of a segment: sides that are apart by less touch, so that what lies on something is held from the start
GAUSS = 0.5773502691896258


@point
def lines(a, b, c, d):
    """Direction of the mean line of ab and cd, and b, c and d as seen from a: along it, and across it."""
    ab, cd = b - a, d - c
    along = (ab / ab.length() + cd / cd.length()).unit()
    across, ac, ad = along.turned(), c - a, d - a
    return along, (ab @ along, ac @ along, ad @ along), (ab @ across, ac @ across, ad @ across)


@point
def part(a, b, c, d, starts, ends, k, deepest):
    """Find the part of ab opposite cd: c and d on ab (0 at a, 1 at b), low, high, and the pressures there.

    Each vertex of the other chain ends one part and begins the next. If nothing is pressed, high is low.
    """
    _, s, h = lines(a, b, c, d)
    ab = b - a
    square = ab @ ab
    slope, first, last = (h[2] - h[1]) / (s[2] - s[1]), ((c - a) @ ab) / square, ((d - a) @ ab) / square
    first, last = first - starts * (last - first), last + ends * (last - first)
    low, high = max(0.0 * first, first), min(1.0 + 0.0 * last, last)
    p_low = k * (low * h[0] - h[1] - slope * (low * s[0] - s[1]))
    p_high = k * (high * h[0] - h[1] - slope * (high * s[0] - s[1]))
    most, touch = max(p_low, p_high), TOUCH * k * sqrt(square)
    if not (low < high and most < k * deepest and (most > 0.0 or min(p_low, p_high) > -touch)):
        high = low
    return first, last, low, high, p_low, p_high


@point
def pressed(low, high, p_low, p_high):
    """Pressed range of a part, and its pressures; all of it if both sides only touch."""
    if p_low < 0.0 < p_high:
        return low + (high - low) * p_low / (p_low - p_high), high, 0.0 * p_low, p_high
    if p_high < 0.0 < p_low:
        return low, high + (low - high) * p_high / (p_high - p_low), p_low, 0.0 * p_high
    return low, high, p_low, p_high


@point
def half_pass(a, b, c, d, length, starts, ends, k, deepest):
    """Energy of the overlaps of segment ab with cd, over ab, and its derivatives by a, b, c and d.

    Both segments run the same way. `length` [mm] undeformed, k [MPa/mm]; overlaps of more than `deepest` [mm] do not
    count. `starts`, `ends`: fraction by which cd counts as longer.
    """
    first, last, low, high, p_low, p_high = part(a, b, c, d, starts, ends, k, deepest)
    ab, cd = b - a, d - c
    none = 0.0 * ab
    if not low < high:
        return 0.0 * first, none, none, none, none
    own = ab / ab.length()
    # derivatives by where the part begins and ends, as vertices of the other chain move along ab
    edge = length / (2.0 * k * ab.length())
    at_low = edge * max(0.0 * p_low, p_low) ** 2 if first > 0.0 else 0.0 * first
    at_high = edge * max(0.0 * p_high, p_high) ** 2 if last < 1.0 else 0.0 * first
    l_a, l_b = at_low * (1.0 - low) - at_high * (1.0 - high), at_low * low - at_high * high
    l_c, l_d = -at_low * (1.0 + starts) - at_high * ends, at_high * (1.0 + ends) + at_low * starts
    begin, end, p, q = pressed(low, high, p_low, p_high)
    size = length * (end - begin)
    energy, force = size * (p * p + p * q + q * q) / (6.0 * k), 0.5 * size * (p + q)
    along, s, h = lines(a, b, c, d)
    span = s[2] - s[1]
    slope = (h[2] - h[1]) / span
    on_b = size * (begin * (2.0 * p + q) + end * (p + 2.0 * q)) / 6.0
    on_d = (on_b * s[0] - force * s[1]) / span
    on_a, on_c, push = force - on_b, force - on_d, along.turned() - slope * along
    # the mean line turns by half of what either segment does
    half = 0.5 * (on_b * (s[0] + slope * h[0]) - on_c * (s[1] + slope * h[1]) - on_d * (s[2] + slope * h[2]))
    aside = l_c * ((c - a) @ own.turned()) + l_d * ((d - a) @ own.turned())
    turn, far = ((half - aside) / (ab @ ab)) * ab.turned(), (half / (cd @ cd)) * cd.turned()
    return (
        energy, on_a * push + l_a * own + turn, on_b * push + l_b * own - turn,
        l_c * own - on_c * push + far, l_d * own - on_d * push - far,
    )  # fmt: skip


@point
def beyond(own, other):
    """Fractions by which the other segment counts as longer: where chains end, at the start and at the end of `own`."""
    return (BEYOND if own[1] and other[2] else 0.0), (BEYOND if own[2] and other[1] else 0.0)


@point
def both(a, b, c, d, own, other, k, deepest):
    """Half of either pass: of ab, outward normal on its right, and of cd, which runs against it.

    own, other  undeformed length [mm], and whether a chain starts and ends there
    """
    starts, ends = beyond(own, other)
    one, a_1, b_1, d_1, c_1 = half_pass(a, b, d, c, 0.5 * own[0], starts, ends, k, deepest)
    two, c_2, d_2, b_2, a_2 = half_pass(c, d, b, a, 0.5 * other[0], ends, starts, k, deepest)
    return one + two, a_1 + a_2, b_1 + b_2, c_1 + c_2, d_1 + d_2


@point
def near(at, nodes, deepest):
    """Return whether segments i to j and e to f face each other and are close enough to overlap."""
    i, j, e, f = nodes
    x, y, u, v = at[j, 0] - at[i, 0], at[j, 1] - at[i, 1], at[f, 0] - at[e, 0], at[f, 1] - at[e, 1]
    reach = abs(x) + abs(y) + abs(u) + abs(v) + 2.0 * deepest
    if abs(at[i, 0] + at[j, 0] - at[e, 0] - at[f, 0]) > reach or abs(at[i, 1] + at[j, 1] - at[e, 1] - at[f, 1]) > reach:
        return False
    return x * u + y * v < -FACING * np.sqrt((x * x + y * y) * (u * u + v * v))


@point
def meet(corners, own, other, k, deepest):
    """Return whether two segments touch or overlap."""
    a, b, c, d = corners
    starts, ends = beyond(own, other)
    _, _, low, high, _, _ = part(a, b, d, c, starts, ends, k, deepest)
    if low < high:
        return True
    _, _, low, high, _, _ = part(c, d, b, a, ends, starts, k, deepest)
    return low < high


@point
def vectors(at, nodes):
    """Positions of four nodes."""
    i, j, e, f = nodes
    return (
        Vector(at[i, 0], at[i, 1]), Vector(at[j, 0], at[j, 1]), Vector(at[e, 0], at[e, 1]), Vector(at[f, 0], at[f, 1])
    )  # fmt: skip


@point
def sides(pair, length, ends):
    """Nodes of two segments, and of each its undeformed length and whether a chain starts and ends there."""
    p, q, i, j, e, f = pair[0], pair[1], pair[2], pair[3], pair[4], pair[5]
    return (i, j, e, f), (length[p], ends[i], ends[j]), (length[q], ends[e], ends[f])


@kernel
def meeting(at, edges, slaves, length, ends, k, deepest, pairs):
    """Fill numbers and nodes (c, 6) of pairs of segments that touch or overlap, as far as there is room; their number.

    at      (n, 2) [mm]
    edges   (e, 2), the first `slaves` of one side; length (e,) [mm], undeformed
    ends    (n,) whether a chain ends at a node
    """
    count, pair = 0, np.zeros(6, np.int32)
    for p in range(slaves):
        for q in range(slaves, edges.shape[0]):
            nodes = edges[p, 0], edges[p, 1], edges[q, 0], edges[q, 1]
            if not near(at, nodes, deepest):
                continue
            pair[0], pair[1], pair[2:4], pair[4:] = p, q, edges[p], edges[q]
            _, own, other = sides(pair, length, ends)
            if meet(vectors(at, nodes), own, other, k, deepest):
                if count < len(pairs):
                    pairs[count] = pair
                count += 1
    return count


@kernel
def press(at, pairs, length, ends, k, deepest, gradient):
    """Add the derivative of the energy of `pairs` to `gradient` (n, 2); returns the energy."""
    energy = 0.0
    for pair in range(len(pairs)):
        nodes, own, other = sides(pairs[pair], length, ends)
        a, b, c, d = vectors(at, nodes)
        found, a, b, c, d = both(a, b, c, d, own, other, k, deepest)
        energy += found
        for node, force in ((nodes[0], a), (nodes[1], b), (nodes[2], c), (nodes[3], d)):
            gradient[node, 0] += force.x
            gradient[node, 1] += force.y
    return energy


@point
def put(block, row, x):
    """A row of eight derivatives."""
    changes = derivatives(x, 8)
    for column in range(8):
        block[row, column] = changes[column]


@kernel
def stiffen(at, pairs, length, ends, k, deepest, block):
    """Fill the second derivatives (c, 8, 8) [N/mm] of the energy of `pairs`."""
    for pair in range(len(pairs)):
        (i, j, e, f), own, other = sides(pairs[pair], length, ends)
        a, b = Vector(seed(at[i, 0], 0, 8), seed(at[i, 1], 1, 8)), Vector(seed(at[j, 0], 2, 8), seed(at[j, 1], 3, 8))
        c, d = Vector(seed(at[e, 0], 4, 8), seed(at[e, 1], 5, 8)), Vector(seed(at[f, 0], 6, 8), seed(at[f, 1], 7, 8))
        _, a, b, c, d = both(a, b, c, d, own, other, k, deepest)
        for number, force in enumerate((a, b, c, d)):
            put(block[pair], 2 * number, force.x)
            put(block[pair], 2 * number + 1, force.y)


@point
def put_points(count, a, b, c, d, i, j, e, f, length, starts, ends, k, deepest, nodes, weight, force):
    """Put two Gauss points on the pressed part of ab opposite cd, from number `count` on; returns the next number."""
    _, _, low, high, p_low, p_high = part(a, b, c, d, starts, ends, k, deepest)
    if low < high and count + 2 <= len(nodes):
        begin, end, p, q = pressed(low, high, p_low, p_high)
        along, s, _ = lines(a, b, c, d)
        for number in range(2):
            share = 0.5 + (number - 0.5) * GAUSS
            xi = begin + share * (end - begin)
            eta = (xi * s[0] - s[1]) / (s[2] - s[1])
            force[count] = 0.5 * length * (end - begin) * (p + share * (q - p))
            nodes[count, 0], nodes[count, 1], nodes[count, 2], nodes[count, 3] = i, j, e, f
            for corner, part_of in enumerate((1.0 - xi, xi, eta - 1.0, -eta)):
                weight[count, 2 * corner], weight[count, 2 * corner + 1] = part_of * along.x, part_of * along.y
            count += 1
    return count


@kernel
def rub(at, pairs, length, ends, k, deepest, nodes, weight, force):
    """Fill the points at which `pairs` rub: nodes (r, 4), derivatives (r, 8) of the slip, normal forces (r,) [N]."""
    count = 0
    for pair in range(len(pairs)):
        (i, j, e, f), own, other = sides(pairs[pair], length, ends)
        a, b, c, d = vectors(at, (i, j, e, f))
        first, last = beyond(own, other)
        count = put_points(count, a, b, d, c, i, j, f, e, 0.5 * own[0], first, last, k, deepest, nodes, weight, force)
        count = put_points(count, c, d, b, a, e, f, j, i, 0.5 * other[0], last, first, k, deepest, nodes, weight, force)
    return count
