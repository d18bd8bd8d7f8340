"""Where two segments see each other, along the continuous field of averaged slave normals.

The slave segment is x(xi) = a + xi e, the normal there n(xi) = n + xi m, xi in [0, 1]; the master segment is
y(eta) = c + eta (d - c). A point y is seen from x(xi) where (x(xi) - y) x n(xi) = 0, a quadratic in xi.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlab.api.compiled.kernel import point


class SlaveSegment(NamedTuple):
    """A slave segment: start a, edge vector e, outward normal n at the start and its change m to the end."""

    ax: float
    ay: float
    ex: float
    ey: float
    nx: float
    ny: float
    mx: float
    my: float


class MasterSegment(NamedTuple):
    """A master segment from c to d."""

    cx: float
    cy: float
    dx: float
    dy: float


@point
def slave_segment(s, at, segments, inward):
    """Segment s of the slave at positions (m, 2), with the inward normals (m, 2) of its nodes."""
    i, j = segments[s, 0], segments[s, 1]
    ax, ay, nx, ny = at[i, 0], at[i, 1], -inward[i, 0], -inward[i, 1]
    return SlaveSegment(ax, ay, at[j, 0] - ax, at[j, 1] - ay, nx, ny, -inward[j, 0] - nx, -inward[j, 1] - ny)


@point
def master_segment(m, at, segments):
    """Segment m of the master at positions (l, 2)."""
    return segment_between(segments[m, 0], segments[m, 1], at)


@point
def segment_between(i, j, at):
    """The master segment from node i to node j."""
    return MasterSegment(at[i, 0], at[i, 1], at[j, 0], at[j, 1])


@point
def edge_vector(master):
    """d - c of a master segment."""
    return master.dx - master.cx, master.dy - master.cy


@point
def slave_parameter(slave, px, py):
    """xi of the slave point that sees (px, py): the root that continues the flat case; nan if none."""
    return parameter_beside(slave, 0, px, py)


@point
def parameter_beside(slave, side, px, py):
    """`slave_parameter` of a point that is not seen from within: side = -1 before the start, 1 beyond the end.

    Overlaps take of it only that it lies outside, so -2 or 2 stands for a root of that sign. 0: not known.
    """
    ax, ay, ex, ey, nx, ny, mx, my = slave
    rx, ry = ax - px, ay - py
    constant = rx * ny - ry * nx
    linear = (ex * ny - ey * nx) + (rx * my - ry * mx)
    square = ex * my - ey * mx
    root = linear * linear - 4.0 * square * constant
    if root < 0.0:
        return np.nan
    if side * constant * linear < 0.0:
        return 2.0 * side
    return -2.0 * constant / (linear + np.copysign(np.sqrt(root), linear))


@point
def master_parameter(xi, slave, master):
    """eta where the normal at x(xi) meets the master segment."""
    ax, ay, ex, ey, nx, ny, mx, my = slave
    fx, fy = edge_vector(master)
    px, py = ax + xi * ex, ay + xi * ey
    qx, qy = nx + xi * mx, ny + xi * my
    return -((master.cx - px) * qy - (master.cy - py) * qx) / (fx * qy - fy * qx)


@point
def opening(xi, eta, slave, master):
    """Gap [mm] between x(xi) and y(eta) along the slave normal, positive when open."""
    qx, qy = slave.nx + xi * slave.mx, slave.ny + xi * slave.my
    x, y = across(xi, eta, slave, master)
    return (x * qx + y * qy) / np.sqrt(qx * qx + qy * qy)


@point
def across(xi, eta, slave, master):
    """y(eta) - x(xi)."""
    fx, fy = edge_vector(master)
    return (
        master.cx + eta * fx - slave.ax - xi * slave.ex,
        master.cy + eta * fy - slave.ay - xi * slave.ey,
    )
