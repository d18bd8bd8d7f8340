"""What lies behind contact surfaces: stiffness of cells, and lengths over masses."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats, Surface
from contactlab.model.bodies.body import Body


def stiffness_behind(surface: Surface, bodies: tuple[Body, ...], positions: Floats) -> Floats:
    """Dilatational modulus over the depth of the cells behind the nodes of a surface (m,) [MPa/mm].

    The depth of a cell is its area over the length of its edge; inf for nodes of rigid surfaces.
    """
    behind: dict[tuple[int, int], float] = {}
    own = set(surface.nodes.tolist())
    for body in bodies:
        corners = body.cells[:, :4]
        if own.isdisjoint(range(body.first, body.first + body.count)):
            continue
        x, y = positions[corners, 0], positions[corners, 1]
        area = 0.5 * np.abs((x * np.roll(y, -1, 1) - y * np.roll(x, -1, 1)).sum(axis=1))
        for k in range(4):
            start, end = corners[:, k], corners[:, (k + 1) % 4]
            length = np.hypot(*(positions[end] - positions[start]).T)
            for a, b, one in zip(start.tolist(), end.tolist(), (length / area).tolist(), strict=True):
                if a in own and b in own:
                    behind[min(a, b), max(a, b)] = body.dilatational_modulus * one
    total, count = np.zeros(len(surface.nodes)), np.zeros(len(surface.nodes))
    for edge in surface.edges:
        a, b = sorted(surface.nodes[edge[:2]].tolist())
        found = behind.get((a, b))
        if found is not None:
            total[edge] += found
            count[edge] += 1.0
    return np.asarray(np.divide(total, count, out=np.full(len(total), np.inf), where=count > 0.0))


def in_series(slave: Floats, master: Floats) -> Floats:
    """Stiffness (m,) [MPa/mm] of the cells on both sides of the slave's nodes; the master's is its mean."""
    return np.asarray(1.0 / (1.0 / slave + (1.0 / master).mean()))


def length_over_mass(surface: Surface, positions: Floats, mass: Floats) -> float:
    """Largest length of surface over mass [mm/t] of a node; 0 for rigid surfaces, whose nodes have no mass."""
    x = positions[surface.nodes[surface.segments]]
    half = 0.5 * np.hypot(*(x[:, 1] - x[:, 0]).T)
    length = np.zeros(len(surface.nodes))
    np.add.at(length, surface.segments, half[:, None])
    own = mass[surface.nodes]
    return float(np.divide(length, own, out=np.zeros(len(own)), where=own > 0.0).max())
