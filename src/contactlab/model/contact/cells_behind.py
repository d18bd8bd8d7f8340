"""Cells behind contact surfaces: their stiffness, and lengths over masses."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from contactlab.api import Floats, Ints, Surface
from contactlab.model.bodies.body import Body


class EdgesBehind(NamedTuple):
    """Edges of a surface that are sides of cells of one body, f of them.

    body  number of the body
    edge  (f,) row of `Surface.edges`
    cell  (f,) cell of the body
    side  (f,) row of `Element.edges`
    """

    body: int
    edge: Ints
    cell: Ints
    side: Ints


def edges_behind(surface: Surface, bodies: tuple[Body, ...]) -> Iterator[EdgesBehind]:
    """Find the cell behind each edge of a surface; edges of rigid surfaces have none."""
    ends = np.sort(surface.nodes[surface.edges[:, :2]], axis=1).astype(np.int64)
    for number, body in enumerate(bodies):
        near = np.flatnonzero((ends[:, 0] >= body.first) & (ends[:, 0] < body.first + body.count))
        if not len(near):
            continue
        sides = np.array([edge[:2] for edge in body.element.edges])
        own = np.sort(body.cells[:, sides], axis=2).astype(np.int64)
        size = body.first + body.count
        keys = (own[..., 0] * size + own[..., 1]).ravel()
        wanted = ends[near, 0] * size + ends[near, 1]
        order = np.argsort(keys)
        place = np.minimum(np.searchsorted(keys, wanted, sorter=order), len(keys) - 1)
        found = order[place]
        hit = keys[found] == wanted
        cell, side = np.divmod(found[hit], len(sides))
        yield EdgesBehind(number, near[hit].astype(np.int32), cell.astype(np.int32), side.astype(np.int32))


def stiffness_behind(surface: Surface, bodies: tuple[Body, ...], positions: Floats) -> Floats:
    """Return the dilatational modulus over the depth of the cells behind the nodes of a surface (m,) [MPa/mm].

    The depth of a cell is its area over the length of its edge; inf for nodes of rigid surfaces.
    """
    total, count = np.zeros(len(surface.nodes)), np.zeros(len(surface.nodes))
    for behind in edges_behind(surface, bodies):
        body, edges = bodies[behind.body], surface.edges[behind.edge]
        x, y = positions[body.cells[behind.cell, :4]].transpose(2, 0, 1)
        area = 0.5 * np.abs((x * np.roll(y, -1, 1) - y * np.roll(x, -1, 1)).sum(axis=1))
        start, end = positions[surface.nodes[edges[:, :2]]].transpose(1, 0, 2)
        stiffness = body.dilatational_modulus * np.hypot(*(end - start).T) / area
        np.add.at(total, edges, stiffness[:, None])
        np.add.at(count, edges, 1.0)
    return np.asarray(np.divide(total, count, out=np.full(len(total), np.inf), where=count > 0.0))


def in_series(slave: Floats, master: Floats) -> Floats:
    """Return the stiffness (m,) [MPa/mm] of the cells on both sides of the slave's nodes; the master's is its mean."""
    return np.asarray(1.0 / (1.0 / slave + (1.0 / master).mean()))


def length_over_mass(slave: Surface, master: Surface, positions: Floats, mass: Floats) -> tuple[float, float, float]:
    """Return the largest length over mass [mm/t] of a node of each side, the master's also per segment length [1/t].

    An end of a chain has half of the length and of the mass of a node within it. Rigid surfaces without mass have 0.
    """
    found: list[float] = []
    for side in (slave, master):
        ends = positions[side.nodes[side.segments]]
        lengths, own = np.hypot(*(ends[:, 1] - ends[:, 0]).T)[:, None], mass[side.nodes]
        share, segment = np.zeros(len(own)), np.zeros(len(own))
        np.add.at(share, side.segments, 0.5 * lengths)
        np.maximum.at(segment, side.segments, lengths)
        density = np.divide(share, own, out=np.zeros(len(own)), where=own > 0.0)
        found += [float(density.max()), float((density / segment).max())]
    return found[0], found[2], found[3]
