"""Overlap of a slave and a master segment along the continuous field of averaged slave normals.

The slave segment is x(xi) = a + xi (b - a), the normal there n(xi) = n_a + xi (n_b - n_a), xi in
[0, 1]; the master segment is y(eta) = c + eta (d - c). A point y is seen from x(xi) where
(x(xi) - y) x n(xi) = 0, a quadratic in xi.
"""

from __future__ import annotations

import numpy as np

from contactlab.api.compiled.kernel import point


@point
def slave_parameter(ax, ay, ex, ey, nx, ny, mx, my, px, py):
    """xi of the slave point that sees (px, py): the root that continues the flat case; nan if none.

    (ax, ay) start, (ex, ey) edge vector, (nx, ny) normal at the start, (mx, my) its change to the end.
    """
    rx, ry = ax - px, ay - py
    constant = rx * ny - ry * nx
    linear = (ex * ny - ey * nx) + (rx * my - ry * mx)
    square = ex * my - ey * mx
    root = linear * linear - 4.0 * square * constant
    if root < 0.0:
        return np.nan
    return -2.0 * constant / (linear + np.copysign(np.sqrt(root), linear))


@point
def master_parameter(xi, ax, ay, ex, ey, nx, ny, mx, my, cx, cy, fx, fy):
    """eta where the normal at x(xi) meets the master segment (start c, edge vector f)."""
    px, py = ax + xi * ex, ay + xi * ey
    qx, qy = nx + xi * mx, ny + xi * my
    return -((cx - px) * qy - (cy - py) * qx) / (fx * qy - fy * qx)


@point
def opening(xi, eta, ax, ay, ex, ey, nx, ny, mx, my, cx, cy, fx, fy):
    """Gap [mm] between x(xi) and y(eta) along the slave normal, positive when open."""
    qx, qy = nx + xi * mx, ny + xi * my
    dx = cx + eta * fx - ax - xi * ex
    dy = cy + eta * fy - ay - xi * ey
    return (dx * qx + dy * qy) / np.sqrt(qx * qx + qy * qy)
