"""Energies of pairs of segments, completed by an author's formulas: values, derivatives, and points that rub.

Slots: NORMAL(own, other, p), OVERLAP(own, other, p) and ENERGY(gap, stiffness, p), see
`contactlab.api.segment_potential`; POINTS, WEIGHTS, a rule on 0 to 1.
"""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.dual import changes, derivatives, seed, seed_changing, value
from contactlab.api.compiled.formulas import methods_of, slots
from contactlab.api.compiled.kernel import kernel, point
from contactlab.api.segments import SideSegment
from contactlab.api.tensors import Vector
from contactlab.formulas.segment_kernels import FACING, PARAMETERS

NORMAL, OVERLAP, ENERGY, POINTS, WEIGHTS = slots("NORMAL", "OVERLAP", "ENERGY", "POINTS", "WEIGHTS")
TOUCH = 1e-9  # of a segment: sides that are apart by less touch, so that what lies on something is held from the start

methods_of(SideSegment)


# --- one pair ---------------------------------------------------------------------------------------------------------


@point
def pressed(own, other, begins, deepest, p):
    """Return the part of `own` that `other` presses: both xi and the gaps there; none if the first are equal.

    Gaps are linear between them: points are matched along NORMAL. Parts deeper than `deepest` below `begins` [mm] are
    the far side of a thin body.
    """
    low, high = OVERLAP(own, other, p)
    normal = NORMAL(own, other, p)
    along, edge, near, far = -normal.turned(), own.edge(), other.start - own.start, other.end - own.start
    slope = ((far - near) @ normal) / ((far - near) @ along)
    rise, offset = slope * (edge @ along) - edge @ normal, near @ normal - slope * (near @ along)
    at_low, at_high = offset + low * rise, offset + high * rise
    least, most = min(at_low, at_high), max(at_low, at_high)
    if not (low < high and least > begins - deepest and (least < begins or most < begins + TOUCH * own.length)):
        high = low
    elif at_low > begins > at_high:
        low, at_low = low + (high - low) * (at_low - begins) / (at_low - at_high), begins + 0.0 * at_low
    elif at_high > begins > at_low:
        high, at_high = high - (high - low) * (at_high - begins) / (at_high - at_low), begins + 0.0 * at_high
    return low, high, at_low, at_high


@point
def half_pass(own, other, stiffness, begins, deepest, p):
    """Return half of the energy of `own` against `other`."""
    low, high, at_low, at_high = pressed(own, other, begins, deepest, p)
    energy = 0.0 * low
    if low < high:
        for q in range(len(POINTS)):
            energy = energy + WEIGHTS[q] * ENERGY(at_low + POINTS[q] * (at_high - at_low), stiffness, p)
    return energy * (0.5 * own.length * (high - low))


@point
def both_passes(one, two, stiffness, begins, deepest, p):
    """Return the energy of two segments, each in the direction of its side: of the one against the other, and back."""
    first = half_pass(one, two.back(), stiffness, begins, deepest, p)
    return first + half_pass(two, one.back(), stiffness, begins, deepest, p)


@point
def segments(a, b, c, d, pair, length, ends):
    """Return both segments of a pair from the positions of their four ends."""
    p, q, i, j, e, f = pair[0], pair[1], pair[2], pair[3], pair[4], pair[5]
    return SideSegment(a, b, length[p], ends[i], ends[j]), SideSegment(c, d, length[q], ends[e], ends[f])


@point
def fixed(at, pair, length, ends):
    """Return both segments of a pair."""
    i, j, e, f = pair[2], pair[3], pair[4], pair[5]
    a, b = Vector(at[i, 0], at[i, 1]), Vector(at[j, 0], at[j, 1])
    c, d = Vector(at[e, 0], at[e, 1]), Vector(at[f, 0], at[f, 1])
    return segments(a, b, c, d, pair, length, ends)


# --- all pairs --------------------------------------------------------------------------------------------------------


@point
def near(at, i, j, e, f, reach):
    """Return whether segments i to j and e to f face each other and are close enough."""
    x, y, u, v = at[j, 0] - at[i, 0], at[j, 1] - at[i, 1], at[f, 0] - at[e, 0], at[f, 1] - at[e, 1]
    most = abs(x) + abs(y) + abs(u) + abs(v) + 2.0 * reach
    if abs(at[i, 0] + at[j, 0] - at[e, 0] - at[f, 0]) > most or abs(at[i, 1] + at[j, 1] - at[e, 1] - at[f, 1]) > most:
        return False
    return x * u + y * v < -FACING * np.sqrt((x * x + y * y) * (u * u + v * v))


@kernel
def meeting(at, edges, slaves, length, ends, begins, deepest, numbers, pairs):
    """Fill numbers and nodes (c, 6) of pairs of segments that press, as far as there is room; return how many press.

    at      (n, 2) [mm]
    edges   (e, 2), the first `slaves` of one side; length (e,) [mm], undeformed
    ends    (n,) whether a side begins or ends at a node
    """
    count, pair, p = 0, np.zeros(6, np.int32), PARAMETERS(numbers)
    for s in range(slaves):
        for m in range(slaves, edges.shape[0]):
            if not near(at, edges[s, 0], edges[s, 1], edges[m, 0], edges[m, 1], deepest + begins):
                continue
            pair[0], pair[1], pair[2:4], pair[4:] = s, m, edges[s], edges[m]
            one, two = fixed(at, pair, length, ends)
            first, second = pressed(one, two.back(), begins, deepest, p), pressed(two, one.back(), begins, deepest, p)
            if first[0] < first[1] or second[0] < second[1]:
                if count < len(pairs):
                    pairs[count] = pair
                count += 1
    return count


@kernel
def press(at, pairs, length, ends, stiffness, begins, deepest, numbers, gradient):
    """Add the derivative of the energy of `pairs` to `gradient` (n, 2); return the energy."""
    energy, p = 0.0, PARAMETERS(numbers)
    for number in range(len(pairs)):
        pair = pairs[number]
        i, j, e, f = pair[2], pair[3], pair[4], pair[5]
        a, b = Vector(seed(at[i, 0], 0, 8), seed(at[i, 1], 1, 8)), Vector(seed(at[j, 0], 2, 8), seed(at[j, 1], 3, 8))
        c, d = Vector(seed(at[e, 0], 4, 8), seed(at[e, 1], 5, 8)), Vector(seed(at[f, 0], 6, 8), seed(at[f, 1], 7, 8))
        one, two = segments(a, b, c, d, pair, length, ends)
        found = both_passes(one, two, stiffness, begins, deepest, p)
        change = derivatives(found, 8)
        energy += value(found)
        for corner in range(4):
            gradient[pair[2 + corner], 0] += change[2 * corner]
            gradient[pair[2 + corner], 1] += change[2 * corner + 1]
    return energy


@kernel
def stiffen(at, pairs, length, ends, stiffness, begins, deepest, numbers, block):
    """Fill the second derivatives (c, 8, 8) [N/mm] of the energy of `pairs`, column by column."""
    p, unit = PARAMETERS(numbers), np.zeros(8)
    for number in range(len(pairs)):
        pair = pairs[number]
        i, j, e, f = pair[2], pair[3], pair[4], pair[5]
        for column in range(8):
            unit[:] = 0.0
            unit[column] = 1.0
            a = Vector(seed_changing(at[i, 0], 0, 8, unit[0]), seed_changing(at[i, 1], 1, 8, unit[1]))
            b = Vector(seed_changing(at[j, 0], 2, 8, unit[2]), seed_changing(at[j, 1], 3, 8, unit[3]))
            c = Vector(seed_changing(at[e, 0], 4, 8, unit[4]), seed_changing(at[e, 1], 5, 8, unit[5]))
            d = Vector(seed_changing(at[f, 0], 6, 8, unit[6]), seed_changing(at[f, 1], 7, 8, unit[7]))
            one, two = segments(a, b, c, d, pair, length, ends)
            change = changes(both_passes(one, two, stiffness, begins, deepest, p), 8)
            for row in range(8):
                block[number, row, column] = change[row]


@point
def put_points(first, own, other, stiffness, begins, deepest, p, share, across, size):
    """Put the Gauss points of the part of `own` that `other` presses in rows from `first` on; return how many."""
    low, high, at_low, at_high = pressed(own, other, begins, deepest, p)
    if not low < high:
        return 0
    normal = NORMAL(own, other, p)
    along, edge = -normal.turned(), own.edge() @ -normal.turned()
    start, end = (other.start - own.start) @ along, (other.end - own.start) @ along
    for q in range(len(POINTS)):
        row, xi, gap = first + q, low + POINTS[q] * (high - low), at_low + POINTS[q] * (at_high - at_low)
        eta = (xi * edge - start) / (end - start)
        share[row, 0], share[row, 1], share[row, 2], share[row, 3] = 1.0 - xi, xi, eta - 1.0, -eta
        across[row, 0], across[row, 1], size[row, 0] = along.x, along.y, gap
        size[row, 1] = 0.5 * own.length * (high - low) * WEIGHTS[q]
        size[row, 2] = -derivatives(ENERGY(seed(gap, 0, 4), stiffness, p), 4)[0]
    return len(POINTS)


@kernel
def points(at, pairs, length, ends, stiffness, begins, deepest, numbers, nodes, share, across, size):
    """Fill the Gauss points of all parts; return their number.

    nodes   (r, 4) ends of the own segment, and of the other in the same direction
    share   (r, 4) weights of their motions in the motion of the own point relative to the matched one
    across  (r, 2) unit vectors across the normals, along which points slip
    size    (r, 3) gap [mm], undeformed length that the point stands for [mm], pressure [MPa]
    """
    count, p = 0, PARAMETERS(numbers)
    for number in range(len(pairs)):
        pair = pairs[number]
        one, two = fixed(at, pair, length, ends)
        for turn in range(2):
            own, other = (one, two.back()) if turn == 0 else (two, one.back())
            found = put_points(count, own, other, stiffness, begins, deepest, p, share, across, size)
            ends_of = (pair[2], pair[3], pair[5], pair[4]) if turn == 0 else (pair[4], pair[5], pair[3], pair[2])
            for row in range(count, count + found):
                for corner in range(4):
                    nodes[row, corner] = ends_of[corner]
            count += found
    return count
