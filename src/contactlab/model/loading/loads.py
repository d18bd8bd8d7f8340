"""Loads on edge sets: pressure and shear, follower or not, and dead tractions."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from contactlab.api import Floats, Ints, RunWarning
from contactlab.errors import below
from contactlab.kernels.edge_loads import edge_forces
from contactlab.model.bodies.body import Body
from contactlab.model.loading.edge_integrals import Edges, Points, uniform, varying
from contactlab.model.loading.edge_sets import edge_set
from contactlab.model.loading.ramps import Course, Ramp, RampTime, courses_of
from contactlab.scene.scene import Scene

Load = Callable[[float, Floats], None]
"""Adds nodal forces (N, 2) [N] at a time [s]."""


def build_loads(
    scene: Scene,
    bodies: tuple[Body, ...],
    reference: Floats,
    position: Floats,
    run: RampTime,
    told: list[RunWarning],
) -> tuple[Load, ...]:
    """Return a call for each of the scene's loads. Each call reads `position` (N, 2)."""
    loads = []
    for number, spec in enumerate(scene.loads):
        where = scene.where(f"loads.{number}")
        body, edges = edge_set(bodies, spec.on, below(where, "on"))
        along = Edges(body.element, edges, reference)
        points = uniform(len(edges))
        if spec.profile is not None:
            points = varying(spec.profile, along, scene.registry, below(where, "profile"), told)
        table = _EdgeTable(along, points)
        if spec.pressure is not None or spec.shear is not None:
            courses = courses_of(spec, ("pressure", "shear"), scene.registry, where)
            loads.append(_along_edges(table, reference, position if spec.follower else None, courses, run))
        if spec.tx is not None or spec.ty is not None:
            courses = courses_of(spec, ("tx", "ty"), scene.registry, where)
            lengths, units = np.zeros(len(reference)), [np.zeros_like(reference), np.zeros_like(reference)]
            np.add.at(lengths, table.edges, table.length)
            for component, unit in enumerate(units):
                unit[:, component] = lengths
            loads.append(_fixed(units, [course.to for course in courses], [course.bind(run) for course in courses]))
    return tuple(loads)


class _EdgeTable:
    """Edges (e, b) with the integrals of their load.

    share   (e, b, b) of factor, trace function of a node, and derivative of another node's
    length  (e, b) [mm] undeformed length of each node, times the factor
    """

    def __init__(self, along: Edges, points: Points) -> None:
        self.edges = np.ascontiguousarray(along.edges)
        shape, derivative = along.trace(points)
        weighted = points.weight[:, None] * shape
        count, nodes = self.edges.shape
        self.share, self.length = np.zeros((count, nodes, nodes)), np.zeros((count, nodes))
        np.add.at(self.share, points.edge, weighted[:, :, None] * derivative[:, None, :])
        np.add.at(self.length, points.edge, weighted * along.speed(points.edge, points.at)[:, None])

    def add(self, positions: Floats, pressure: float, shear: float, out: Floats) -> None:
        """Add the forces of a pressure and a shear on the edges at `positions`."""
        edge_forces(positions, self.edges, self.share, pressure, shear, out)


class FollowerLoad:
    """Pressure and shear on the edges at `position`. A `Load`."""

    def __init__(
        self, table: _EdgeTable, position: Floats, sizes: tuple[float, float], ramps: tuple[Ramp, Ramp]
    ) -> None:
        self.table, self.position, self.sizes, self.ramps = table, position, sizes, ramps

    def __call__(self, time: float, out: Floats) -> None:
        """Add the nodal forces (N, 2) [N] at a time [s]."""
        self.table.add(self.position, *self.values(time), out)

    def values(self, time: float) -> tuple[float, float]:
        """Return pressure and shear [MPa] at a time [s]."""
        return self.sizes[0] * self.ramps[0](time), self.sizes[1] * self.ramps[1](time)

    def derivatives(self) -> tuple[Ints, Ints, Floats, Floats]:
        """Return derivatives of the nodal forces by positions: rows and columns (degrees of freedom), values per MPa of
        pressure and of shear."""
        t = self.table
        # forces are shape_a times the tangent sum_b derivative_b x_b, turned by a right angle for the pressure
        share = t.share
        row, column = (2 * np.broadcast_to(nodes, share.shape) for nodes in (t.edges[:, :, None], t.edges[:, None, :]))
        zero = np.zeros_like(share)
        rows, columns = np.stack([row, row, row + 1, row + 1]), np.stack([column, column + 1, column, column + 1])
        pressure, shear = np.stack([zero, -share, share, zero]), np.stack([share, zero, zero, share])
        return rows.ravel(), columns.ravel(), pressure.ravel(), shear.ravel()


def _along_edges(
    table: _EdgeTable, reference: Floats, position: Floats | None, courses: list[Course], run: RampTime
) -> Load:
    """Return pressure and shear; on the undeformed edges without `position`."""
    (p, pressure), (q, shear) = ((course.to, course.bind(run)) for course in courses)
    if position is not None:
        return FollowerLoad(table, position, (p, q), (pressure, shear))
    units = [np.zeros_like(reference), np.zeros_like(reference)]
    table.add(reference, 1.0, 0.0, units[0])
    table.add(reference, 0.0, 1.0, units[1])
    return _fixed(units, [p, q], [pressure, shear])


def _fixed(units: list[Floats], values: list[float], ramps: list[Ramp]) -> Load:
    """Return forces of fixed directions: `units` (N, 2) each, of which only the loaded nodes are touched."""
    nodes = np.flatnonzero(np.any([unit.any(axis=1) for unit in units], axis=0))
    first, second = (np.ascontiguousarray(value * unit[nodes]) for value, unit in zip(values, units, strict=True))

    def push(time: float, out: Floats) -> None:
        out[nodes] += ramps[0](time) * first + ramps[1](time) * second

    return push
