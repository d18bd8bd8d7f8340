"""Block kernels made from an element's tables: any number of nodes and points.

All sums over nodes come before the loop over cells, so that the inner loops run along contiguous
rows and vectorise (see the layouts of `contactlab.api.arrays`).
"""

from __future__ import annotations

import numpy as np

from contactlab.api.arrays import Floats, Ints
from contactlab.api.compiled.kernel import kernel
from contactlab.api.element import BlockKernels, Element
from contactlab.api.material import Kinematics


@kernel
def _gather(geometry, field, connectivity, scratch):
    nodes, cells = connectivity.shape
    for a in range(nodes):
        for c in range(cells):
            node = connectivity[a, c]
            scratch[a, c] = geometry[node, 0]
            scratch[nodes + a, c] = geometry[node, 1]
            scratch[2 * nodes + a, c] = field[node, 0]
            scratch[3 * nodes + a, c] = field[node, 1]


@kernel
def _parent_gradient(derivative, values, along_xi, along_eta):
    """Compute rows d/dxi and d/deta of a field given by its nodal rows, at one point with `derivative` (a, 2)."""
    for c in range(along_xi.size):
        along_xi[c] = derivative[0, 0] * values[0, c]
        along_eta[c] = derivative[0, 1] * values[0, c]
    for a in range(1, derivative.shape[0]):
        for c in range(along_xi.size):
            along_xi[c] += derivative[a, 0] * values[a, c]
            along_eta[c] += derivative[a, 1] * values[a, c]


@kernel
def table_gradient(geometry, field, connectivity, derivatives, out, scratch):
    """Compute d(field)/d(geometry) (4, P) at every point, from the derivatives (q, a, 2) of the shape functions."""
    nodes, cells = connectivity.shape
    _gather(geometry, field, connectivity, scratch)
    work = scratch[4 * nodes :]
    for g in range(derivatives.shape[0]):
        begin, end = g * cells, (g + 1) * cells
        _parent_gradient(derivatives[g], scratch[:nodes], work[0], work[1])
        _parent_gradient(derivatives[g], scratch[nodes : 2 * nodes], work[2], work[3])
        _parent_gradient(derivatives[g], scratch[2 * nodes : 3 * nodes], out[0, begin:end], out[1, begin:end])
        _parent_gradient(derivatives[g], scratch[3 * nodes : 4 * nodes], out[2, begin:end], out[3, begin:end])
        for c in range(cells):
            p = begin + c
            x_xi, x_eta, y_xi, y_eta = work[0, c], work[1, c], work[2, c], work[3, c]
            inverse = 1.0 / (x_xi * y_eta - x_eta * y_xi)
            u_xi, u_eta, v_xi, v_eta = out[0, p], out[1, p], out[2, p], out[3, p]
            out[0, p] = (u_xi * y_eta - u_eta * y_xi) * inverse
            out[1, p] = (u_eta * x_xi - u_xi * x_eta) * inverse
            out[2, p] = (v_xi * y_eta - v_eta * y_xi) * inverse
            out[3, p] = (v_eta * x_xi - v_xi * x_eta) * inverse


@kernel
def table_force(geometry, connectivity, derivatives, weights, stress, force, scratch):
    """Add the nodal forces of `stress` (4, P); the gathered geometry is still in `scratch`."""
    nodes, cells = connectivity.shape
    work = scratch[4 * nodes :]
    total = scratch[2 * nodes : 4 * nodes]
    total[:] = 0.0
    for g in range(derivatives.shape[0]):
        _parent_gradient(derivatives[g], scratch[:nodes], work[0], work[1])
        _parent_gradient(derivatives[g], scratch[nodes : 2 * nodes], work[2], work[3])
        for c in range(cells):
            p = g * cells + c
            x_xi, x_eta, y_xi, y_eta = work[0, c], work[1, c], work[2, c], work[3, c]
            xx, yy, xy = weights[g] * stress[0, p], weights[g] * stress[1, p], weights[g] * stress[3, p]
            work[0, c] = xx * y_eta - xy * x_eta
            work[1, c] = xy * x_xi - xx * y_xi
            work[2, c] = xy * y_eta - yy * x_eta
            work[3, c] = yy * x_xi - xy * y_xi
        for a in range(nodes):
            for c in range(cells):
                total[a, c] += derivatives[g, a, 0] * work[0, c] + derivatives[g, a, 1] * work[1, c]
                total[nodes + a, c] += derivatives[g, a, 0] * work[2, c] + derivatives[g, a, 1] * work[3, c]
    for a in range(nodes):
        for c in range(cells):
            node = connectivity[a, c]
            force[node, 0] += total[a, c]
            force[node, 1] += total[nodes + a, c]


@kernel
def midpoint(gradient):
    """Refer the increment gradient d(du)/dx at the end of the step to its middle: G (I - G/2)^-1."""
    for p in range(gradient.shape[1]):
        xx, xy, yx, yy = gradient[0, p], gradient[1, p], gradient[2, p], gradient[3, p]
        a, b, c, d = 1.0 - 0.5 * xx, -0.5 * xy, -0.5 * yx, 1.0 - 0.5 * yy
        inverse = 1.0 / (a * d - b * c)
        gradient[0, p] = (xx * d - xy * c) * inverse
        gradient[1, p] = (xy * a - xx * b) * inverse
        gradient[2, p] = (yx * d - yy * c) * inverse
        gradient[3, p] = (yy * a - yx * b) * inverse


def table_kernels(element: Element) -> BlockKernels:
    """Return the generic kernels of any element, bound to its tables."""
    rule = element.quadrature()
    derivatives: Floats = np.ascontiguousarray(element.shape(rule.points).gradient)
    weights: Floats = np.ascontiguousarray(rule.weights)

    def gradient(geometry: Floats, field: Floats, connectivity: Ints, out: Floats, scratch: Floats) -> None:
        table_gradient(geometry, field, connectivity, derivatives, out, scratch)

    def force(geometry: Floats, connectivity: Ints, stress: Floats, force: Floats, scratch: Floats) -> None:
        table_force(geometry, connectivity, derivatives, weights, stress, force, scratch)

    return BlockKernels(gradient, force)


def element_kernels(element: Element, kinematics: Kinematics = "small") -> BlockKernels:
    """Return the element's own kernels for laws of these kinematics, or the generic kernels."""
    return element.block_kernels(kinematics) or table_kernels(element)
