"""Size of each cell, to follow the stable step cheaply between eigenvalue evaluations."""

from __future__ import annotations

from contactlab.api.compiled.kernel import kernel


@kernel
def inverse_size_squared(positions, cells, out):
    """Fill |grad xi|^2 + |grad eta|^2 (n,) [1/mm2] from the corners; 4 (1/a^2 + 1/b^2) for an a x b rectangle."""
    for e in range(cells.shape[0]):
        i, j, k, m = cells[e, 0], cells[e, 1], cells[e, 2], cells[e, 3]
        x_xi = 0.25 * (positions[j, 0] - positions[i, 0] + positions[k, 0] - positions[m, 0])
        y_xi = 0.25 * (positions[j, 1] - positions[i, 1] + positions[k, 1] - positions[m, 1])
        x_eta = 0.25 * (positions[m, 0] - positions[i, 0] + positions[k, 0] - positions[j, 0])
        y_eta = 0.25 * (positions[m, 1] - positions[i, 1] + positions[k, 1] - positions[j, 1])
        j_det = x_xi * y_eta - x_eta * y_xi
        out[e] = (x_xi * x_xi + y_xi * y_xi + x_eta * x_eta + y_eta * y_eta) / (j_det * j_det)


@kernel
def jacobian_determinants(positions, connectivity, derivatives, out):
    """Fill determinants (q, B) of the cells' maps at points with the derivatives (q, a, 2) of the shape functions."""
    for g in range(derivatives.shape[0]):
        for c in range(connectivity.shape[1]):
            x_xi, x_eta, y_xi, y_eta = 0.0, 0.0, 0.0, 0.0
            for a in range(connectivity.shape[0]):
                x, y = positions[connectivity[a, c], 0], positions[connectivity[a, c], 1]
                x_xi += derivatives[g, a, 0] * x
                x_eta += derivatives[g, a, 1] * x
                y_xi += derivatives[g, a, 0] * y
                y_eta += derivatives[g, a, 1] * y
            out[g, c] = x_xi * y_eta - x_eta * y_xi
