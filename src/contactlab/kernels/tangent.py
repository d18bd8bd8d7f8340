"""Kernels of the assembled stiffness: moduli of the points, then cells scattered into columns.

A two-point modulus A (4, 4, P) says how the stress that acts through the fixed shape of a cell changes
with the gradient of a small displacement: rows ij and columns kl in the order xx, xy, yx, yy,

    K_(ai)(bk) = sum over points of weight * det * dN_a/dx_j A_ijkl dN_b/dx_l .
"""

from __future__ import annotations

from contactlab.api.compiled.kernel import kernel

SMALL, FINITE, RATE = 0, 1, 2

_ROW = (0, 3, 3, 1)  # row of the stress (xx, yy, zz, xy) for component ij = xx, xy, yx, yy


@kernel
def two_point_modulus(kind, gradient, stress, tangent, out):
    """Fill modulus A (4, 4, P) from a law's tangent (4, 4, P), with the geometric part from the stress.

    small   gradient of u by X: the tangent itself
    finite  gradient g of X by x: d g = -g grad(du)
    rate    increment L at mid-step: d L = (I - L/2) grad(du) (I + L/2)
    The last two act on the current geometry: A_ijkl += s_ij delta_kl - s_il delta_jk.
    """
    for p in range(gradient.shape[1]):
        xx, xy, yx, yy = gradient[0, p], gradient[1, p], gradient[2, p], gradient[3, p]
        for r in range(4):
            s = _ROW[r]
            a, b, c, d = tangent[s, 0, p], tangent[s, 1, p], tangent[s, 2, p], tangent[s, 3, p]
            if kind == FINITE:
                out[r, 0, p], out[r, 1, p] = -(a * xx + c * yx), -(b * xx + d * yx)
                out[r, 2, p], out[r, 3, p] = -(a * xy + c * yy), -(b * xy + d * yy)
            elif kind == RATE:
                # rows of (I - L/2)^T applied from the left, of (I + L/2)^T from the right
                e, f = (1.0 - 0.5 * xx) * a - 0.5 * yx * c, (1.0 - 0.5 * xx) * b - 0.5 * yx * d
                g, h = (1.0 - 0.5 * yy) * c - 0.5 * xy * a, (1.0 - 0.5 * yy) * d - 0.5 * xy * b
                out[r, 0, p], out[r, 1, p] = e * (1.0 + 0.5 * xx) + f * 0.5 * xy, e * 0.5 * yx + f * (1.0 + 0.5 * yy)
                out[r, 2, p], out[r, 3, p] = g * (1.0 + 0.5 * xx) + h * 0.5 * xy, g * 0.5 * yx + h * (1.0 + 0.5 * yy)
            else:
                out[r, 0, p], out[r, 1, p], out[r, 2, p], out[r, 3, p] = a, b, c, d
        if kind == SMALL:
            continue
        s_xx, s_yy, s_xy = stress[0, p], stress[1, p], stress[3, p]
        out[0, 1, p] -= s_xy
        out[0, 3, p] += s_xx
        out[1, 0, p] += s_xy
        out[1, 2, p] -= s_xx
        out[2, 1, p] -= s_yy
        out[2, 3, p] += s_xy
        out[3, 0, p] += s_yy
        out[3, 2, p] -= s_xy


@kernel
def add_cells(geometry, connectivity, derivatives, weights, modulus, pairs, place, stride, data, gradients, matrix):
    """Add the stiffness of a block of cells to `data`, the values of a sparse matrix by columns.

    geometry (N, 2), connectivity (a, B), derivatives (q, a, 2), modulus (4, 4, q B), pairs (B, a, a) numbers of
    the node pairs; a pair's 2x2 entries (i, k) stand at place[pair] + i + k * stride[pair].
    `gradients` (a + 1, 2) and `matrix` (2a, 2a) are scratch.
    """
    nodes, cells = connectivity.shape
    for c in range(cells):
        for i in range(2 * nodes):
            for k in range(2 * nodes):
                matrix[i, k] = 0.0
        for g in range(derivatives.shape[0]):
            _gradients_at(geometry, connectivity, c, derivatives[g], gradients)
            _add_point(gradients, weights[g] * gradients[nodes, 0], modulus, g * cells + c, nodes, matrix)
        scatter(matrix, pairs[c], place, stride, data)


@kernel
def _gradients_at(geometry, connectivity, c, parent, gradients):
    """Compute gradients of the shape functions of cell c into gradients[:a]; the determinant into gradients[a, 0]."""
    nodes = connectivity.shape[0]
    x_xi, x_eta, y_xi, y_eta = 0.0, 0.0, 0.0, 0.0
    for a in range(nodes):
        x, y = geometry[connectivity[a, c], 0], geometry[connectivity[a, c], 1]
        x_xi += parent[a, 0] * x
        x_eta += parent[a, 1] * x
        y_xi += parent[a, 0] * y
        y_eta += parent[a, 1] * y
    det = x_xi * y_eta - x_eta * y_xi
    for a in range(nodes):
        gradients[a, 0] = (parent[a, 0] * y_eta - parent[a, 1] * y_xi) / det
        gradients[a, 1] = (parent[a, 1] * x_xi - parent[a, 0] * x_eta) / det
    gradients[nodes, 0] = det


@kernel
def _add_point(gradients, volume, modulus, p, nodes, matrix):
    for b in range(nodes):
        bx, by = volume * gradients[b, 0], volume * gradients[b, 1]
        for k in range(2):
            xx = modulus[0, 2 * k, p] * bx + modulus[0, 2 * k + 1, p] * by
            xy = modulus[1, 2 * k, p] * bx + modulus[1, 2 * k + 1, p] * by
            yx = modulus[2, 2 * k, p] * bx + modulus[2, 2 * k + 1, p] * by
            yy = modulus[3, 2 * k, p] * bx + modulus[3, 2 * k + 1, p] * by
            for a in range(nodes):
                matrix[2 * a, 2 * b + k] += gradients[a, 0] * xx + gradients[a, 1] * xy
                matrix[2 * a + 1, 2 * b + k] += gradients[a, 0] * yx + gradients[a, 1] * yy


@kernel
def scatter(matrix, pairs, place, stride, data):
    """Add one cell's matrix (2a, 2a) to the columns; pairs (a, a) of row and column node."""
    nodes = pairs.shape[0]
    for a in range(nodes):
        for b in range(nodes):
            at, step = place[pairs[a, b]], stride[pairs[a, b]]
            for i in range(2):
                for k in range(2):
                    data[at + i + k * step] += matrix[2 * a + i, 2 * b + k]


@kernel
def scatter_all(matrices, pairs, place, stride, data):
    """Call `scatter` for all cells (B, 2a, 2a)."""
    for c in range(matrices.shape[0]):
        scatter(matrices[c], pairs[c], place, stride, data)
