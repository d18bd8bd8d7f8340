"""Derivatives of contact pieces by differences, and what they do to gaps and forces.

Nodes that no piece depends on together are moved at once (colours), so that a few evaluations of the
algorithm give the derivatives of all pieces.
"""

from __future__ import annotations

from contactlab.api.compiled.kernel import kernel

JUMP = 2.0  # a change that is larger than that to the other side by this factor is a kink or a jump


@kernel
def _ends(nodes, p, size):
    """First and last of a piece's nodes along the chain of `size` nodes, which may run through its start."""
    low, high = nodes[p, 0], nodes[p, 0]
    for i in range(1, nodes.shape[1]):
        low, high = min(low, nodes[p, i]), max(high, nodes[p, i])
    if 2 * (high - low) <= size or high - low < nodes.shape[1]:
        return low, high
    first, last = high, low
    for i in range(nodes.shape[1]):
        n = nodes[p, i]
        if 2 * n > size:
            first = min(first, n)
        else:
            last = max(last, n)
    return first, last


@kernel
def moved_node(nodes, p, ring, chain, colour):
    """The node of `colour` that piece p may depend on: its own nodes and `ring` more on either side; -1 for none.

    chain = (following, preceding, colours) of the surface
    """
    following, preceding, colours = chain
    v, beyond = _ends(nodes, p, colours.size)
    for _ in range(ring):
        if preceding[v] >= 0:
            v = preceding[v]
        if following[beyond] >= 0:
            beyond = following[beyond]
    for _ in range(colours.size):
        if colours[v] == colour:
            return v
        if v == beyond or following[v] < 0:
            return -1
        v = following[v]
    return -1


@kernel
def _alike(p, first, q, second):
    """Whether piece p of one set and piece q of the other couple the same nodes and multipliers."""
    for i in range(first[0].shape[1]):
        if first[0][p, i] != second[0][q, i]:
            return False
    for i in range(first[1].shape[1]):
        if first[1][p, i] != second[1][q, i]:
            return False
    for i in range(first[2].shape[1]):
        if first[2][p, i] != second[2][q, i]:
            return False
    return True


@kernel
def _put(at, scale, p, pieces, moved, out):
    """Entry `at` becomes scale * piece p."""
    slave, multiplier, master, D, M, T = pieces
    o_slave, o_multiplier, o_master, o_moved, dD, dM, dT = out
    for i in range(slave.shape[1]):
        o_slave[at, i] = slave[p, i]
        for j in range(multiplier.shape[1]):
            dD[at, i, j] = scale * D[p, i, j]
    for i in range(master.shape[1]):
        o_master[at, i] = master[p, i]
        for j in range(multiplier.shape[1]):
            dM[at, i, j] = scale * M[p, i, j]
    for i in range(multiplier.shape[1]):
        o_multiplier[at, i] = multiplier[p, i]
        for j in range(multiplier.shape[1]):
            dT[at, i, j] = scale * T[p, i, j]
    o_moved[at] = moved


@kernel
def _take_off(at, scale, q, pieces, out):
    """Subtract scale * piece q from entry `at`; False if nothing is left of it."""
    D, M, T = pieces[3], pieces[4], pieces[5]
    dD, dM, dT = out[4], out[5], out[6]
    left = 0.0
    for j in range(dT.shape[2]):
        for i in range(dD.shape[1]):
            dD[at, i, j] -= scale * D[q, i, j]
            left = max(left, abs(dD[at, i, j]))
        for i in range(dM.shape[1]):
            dM[at, i, j] -= scale * M[q, i, j]
            left = max(left, abs(dM[at, i, j]))
        for i in range(dT.shape[1]):
            dT[at, i, j] -= scale * T[q, i, j]
            left = max(left, abs(dT[at, i, j]))
    return left > 0.0


@kernel
def differences(
    high_count, high, high_nodes, low_count, low, low_nodes, shift, ring, chain, colour, direction, scale, at, out
):  # fmt: skip
    """Append scale * (high - low) for the pieces that depend on a node of `colour` moved along `direction`.

    high, low = (slave, multiplier, master, D, M, T) of both evaluations; `high_nodes` and `low_nodes` are
    their slave or master nodes, whichever were moved; coordinates count on from `shift`. Pieces that only one has
    are entries of their own. Returns the next free entry.
    """
    head = 0
    while head < min(high_count, low_count) and _alike(head, high, head, low):
        head += 1
    tail = 0
    while tail < min(high_count, low_count) - head and _alike(high_count - 1 - tail, high, low_count - 1 - tail, low):
        tail += 1
    for p in range(high_count):
        v = moved_node(high_nodes, p, ring, chain, colour)
        if v < 0:
            continue
        _put(at, scale, p, high, 2 * (shift + v) + direction, out)
        if p < head or p >= high_count - tail:
            q = p if p < head else p - high_count + low_count
            if _take_off(at, scale, q, low, out):
                at += 1
        else:
            at += 1
    for q in range(head, low_count - tail):
        v = moved_node(low_nodes, q, ring, chain, colour)
        if v >= 0:
            _put(at, -scale, q, low, 2 * (shift + v) + direction, out)
            at += 1
    return at


@kernel
def normal_differences(high, middle, low, owners, shift, ring, chain, colour, direction, scale, at, out):
    """Append scale * (high - low) of the normals (k, 2); `owners` (k, b) are surface nodes of each multiplier.

    Where a normal jumps, as between two segments, the side without the jump is taken.
    out = (normal_of, normal_moved, dnormal). Returns the next free entry.
    """
    normal_of, normal_moved, dnormal = out
    for k in range(high.shape[0]):
        ahead = max(abs(high[k, 0] - middle[k, 0]), abs(high[k, 1] - middle[k, 1]))
        behind = max(abs(middle[k, 0] - low[k, 0]), abs(middle[k, 1] - low[k, 1]))
        x, y = scale * (high[k, 0] - low[k, 0]), scale * (high[k, 1] - low[k, 1])
        if ahead > JUMP * behind:
            x, y = 2.0 * scale * (middle[k, 0] - low[k, 0]), 2.0 * scale * (middle[k, 1] - low[k, 1])
        elif behind > JUMP * ahead:
            x, y = 2.0 * scale * (high[k, 0] - middle[k, 0]), 2.0 * scale * (high[k, 1] - middle[k, 1])
        if (x == 0.0 and y == 0.0) or owners[k, 0] < 0:
            continue
        v = moved_node(owners, k, ring, chain, colour)
        if v < 0:
            continue
        normal_of[at], normal_moved[at] = k, 2 * (shift + v) + direction
        dnormal[at, 0], dnormal[at, 1] = x, y
        at += 1
    return at


@kernel
def master_owners(count, multiplier, master, owners):
    """First and last master node (k, 2) that the pieces of each multiplier reach, -1 where there is none."""
    owners[:] = -1
    for p in range(count):
        for j in range(multiplier.shape[1]):
            k = multiplier[p, j]
            for i in range(master.shape[1]):
                n = master[p, i]
                owners[k, 0] = n if owners[k, 0] < 0 else min(owners[k, 0], n)
                owners[k, 1] = max(owners[k, 1], n)


@kernel
def _wanted(e, multiplier, owner, wanted):
    for j in range(multiplier.shape[1]):
        k = owner[multiplier[e, j]]
        if k >= 0 and wanted[k]:
            return True
    return False


@kernel
def _column(moved, slave_nodes, master_nodes):
    v = moved // 2
    node = slave_nodes[v] if v < slave_nodes.size else master_nodes[v - slave_nodes.size]
    return 2 * node + moved % 2


@kernel
def _emit(at, row, column, value, out):
    if value == 0.0:
        return at
    out[0][at], out[1][at], out[2][at] = row, column, value
    return at + 1


@kernel
def force_slopes(count, slopes, owner, wanted, traction, slave_nodes, master_nodes, force, coupling):
    """Derivatives of D a and -M a, and of T a, at fixed tractions a (k, 2); only for wanted multipliers.

    slopes = (slave, multiplier, master, moved, dD, dM, dT); force and coupling = (row, column, value).
    Rows of `force` are degrees of freedom of the model, of `coupling` 2 k + component; columns are degrees
    of freedom. Returns the number of entries of both.
    """
    slave, multiplier, master, moved, dD, dM, dT = slopes
    at, given = 0, 0
    for e in range(count):
        if not _wanted(e, multiplier, owner, wanted):
            continue
        column = _column(moved[e], slave_nodes, master_nodes)
        for c in range(2):
            for i in range(slave.shape[1]):
                total = 0.0
                for j in range(multiplier.shape[1]):
                    k = owner[multiplier[e, j]]
                    total += dD[e, i, j] * traction[k, c] if k >= 0 else 0.0
                at = _emit(at, 2 * slave_nodes[slave[e, i]] + c, column, total, force)
            for i in range(master.shape[1]):
                total = 0.0
                for j in range(multiplier.shape[1]):
                    k = owner[multiplier[e, j]]
                    total -= dM[e, i, j] * traction[k, c] if k >= 0 else 0.0
                at = _emit(at, 2 * master_nodes[master[e, i]] + c, column, total, force)
            for i in range(multiplier.shape[1]):
                row, total = owner[multiplier[e, i]], 0.0
                for j in range(multiplier.shape[1]):
                    k = owner[multiplier[e, j]]
                    total += dT[e, i, j] * traction[k, c] if k >= 0 else 0.0
                if row >= 0:
                    given = _emit(given, 2 * row + c, column, total, coupling)
    return at, given


@kernel
def gap_slopes(
    count, slopes, owner, wanted, slave_at, master_at, separation, slave_nodes, master_nodes, weight
):  # fmt: skip
    """Derivatives of the weighted gaps D^T x - M^T y - T^T r at fixed positions and separations r (k, 2).

    weight = (row, column, value) with rows 2 k + component; returns the number of entries.
    """
    slave, multiplier, master, moved, dD, dM, dT = slopes
    at = 0
    for e in range(count):
        if not _wanted(e, multiplier, owner, wanted):
            continue
        column = _column(moved[e], slave_nodes, master_nodes)
        for j in range(multiplier.shape[1]):
            k = owner[multiplier[e, j]]
            if k < 0:
                continue
            for c in range(2):
                gap = 0.0
                for i in range(slave.shape[1]):
                    gap += dD[e, i, j] * slave_at[slave[e, i], c]
                for i in range(master.shape[1]):
                    gap -= dM[e, i, j] * master_at[master[e, i], c]
                for i in range(multiplier.shape[1]):
                    other = owner[multiplier[e, i]]
                    gap -= dT[e, i, j] * separation[other, c] if other >= 0 else 0.0
                at = _emit(at, 2 * k + c, column, gap, weight)
    return at


@kernel
def unit_windows(count, order, start, end, weight):
    """Windows of the identity, to be solved into rows of T^-T."""
    for i in range(count):
        k = order[i]
        start[k], end[k], weight[k, 0] = k, k + 1, 1.0


@kernel
def window_entries(chosen, window, cut, row, column, value):
    """Entries (row, column, value) of the chosen rows of a window; returns their number."""
    start, end, weight = window
    at = 0
    for i in range(chosen.size):
        k = chosen[i]
        for z in range(start[k], end[k]):
            w = weight[k, z - start[k]]
            if abs(w) > cut:
                row[at], column[at], value[at] = k, z, w
                at += 1
    return at


@kernel
def add_forces(count, order, window, nodes, sign, normals, multipliers, first, normal_force, tangent_force):
    """Add the nodal forces of normal and of tangential multipliers to (N, 2) each (the latter may be empty)."""
    start, end, weight = window
    friction = tangent_force.shape[0] > 0
    for i in range(count):
        k = order[i]
        y_n = multipliers[0, first + k]
        y_t = multipliers[1, first + k] if friction else 0.0
        if y_n == 0.0 and y_t == 0.0:
            continue
        nx, ny = normals[k, 0], normals[k, 1]
        for z in range(start[k], end[k]):
            w, n = sign * weight[k, z - start[k]], nodes[z]
            normal_force[n, 0] += w * y_n * nx
            normal_force[n, 1] += w * y_n * ny
            if friction:
                tangent_force[n, 0] += w * y_t * ny
                tangent_force[n, 1] -= w * y_t * nx


@kernel
def flexibilities(count, order, slave, master, slave_nodes, master_nodes, normals, nodal, out):
    """Sum of squared normal weights times nodal flexibility (N, 2) into out (k,) for the kept multipliers."""
    for i in range(count):
        k = order[i]
        total = 0.0
        for side in range(2):
            start, end, weight = slave if side == 0 else master
            nodes = slave_nodes if side == 0 else master_nodes
            for z in range(start[k], end[k]):
                w, n = weight[k, z - start[k]], nodes[z]
                total += w * w * (normals[k, 0] ** 2 * nodal[n, 0] + normals[k, 1] ** 2 * nodal[n, 1])
        out[k] = total
