# kind element cls Enhanced
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import BlockKernels, Element, Quadrature, Shape


@dataclass(frozen=True)
class Enhanced(Element):
    """Q1 whose strains at the points are half their mean over the cell, as enhanced modes would make them."""

    exact: ClassVar[bool] = False
    nodes = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    edges = ((0, 1), (1, 2), (2, 3), (3, 0))
    degree: ClassVar[int] = 1
    lumping = "row-sum"

    def shape(self, points):
        x, y = points[:, :1], points[:, 1:]
        a, b = self.nodes.T
        value = 0.25 * (1.0 + a * x) * (1.0 + b * y)
        return Shape(value, np.stack([0.25 * a * (1.0 + b * y), 0.25 * b * (1.0 + a * x)], axis=-1))

    def quadrature(self):
        g = 1.0 / np.sqrt(3.0)
        return Quadrature(np.array([[-g, -g], [g, -g], [g, g], [-g, g]]), np.ones(4))

    def edge_shape(self, s):
        return np.stack([0.5 - 0.5 * s, 0.5 + 0.5 * s], axis=1), np.tile([-0.5, 0.5], (len(s), 1))

    def tables(self, geometry, conn):
        """B (q, a, 2, n), mixed with its mean over the cell, and weights times determinants (q, n)."""
        local, rule = self.shape(self.quadrature().points).gradient, self.quadrature()
        jacobian = np.einsum("qaj,ani->qnij", local, geometry[conn])
        area = np.linalg.det(jacobian) * rule.weights[:, None]
        b = np.einsum("qaj,qnji->qain", local, np.linalg.inv(jacobian))
        mean = (b * area[:, None, None]).sum(axis=0) / area.sum(axis=0)
        return 0.5 * b + 0.5 * mean, area

    def block_kernels(self, kinematics):
        def gradient(geometry, field, conn, out, scratch):
            b, _ = self.tables(geometry, conn)
            out[:] = np.einsum("ani,qajn->ijqn", field[conn], b).reshape(4, -1)

        def force(geometry, conn, stress, out, scratch):
            b, area = self.tables(geometry, conn)
            xx, yy, _, xy = stress.reshape(4, *area.shape)
            tensor = np.stack([np.stack([xx, xy]), np.stack([xy, yy])])
            np.add.at(out, conn, np.einsum("ijqn,qajn,qn->ani", tensor, b, area))

        return BlockKernels(gradient, force)
