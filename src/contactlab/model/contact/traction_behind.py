"""Normal tractions of contact surfaces by the stresses of the cells behind them, and their derivatives by the nodes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import coo_array

from contactlab.api import Element, Floats, ImplicitIntegrator, Integrator, Ints
from contactlab.contact.pair import ContactPair
from contactlab.errors import PartError, SceneError, Where, below
from contactlab.model.bodies.body import Block, Body, BodyForces
from contactlab.model.bodies.tangent import KIND, follows_tables, two_point_modulus
from contactlab.model.contact.cells_behind import edges_behind
from contactlab.model.contact.systems import ContactPlan
from contactlab.model.loading.edge_sets import edge_set
from contactlab.scene.scene import Scene

Entries = tuple[Ints, Ints, Floats]
"""Rows, columns and values (e,) of a matrix."""
ALL = slice(None)


def refuse_integrator(integrator: Integrator, spec: Any, where: Where) -> None:
    """Raise PartError if steps cannot use a law that needs the traction of the slave."""
    if isinstance(integrator, ImplicitIntegrator) and not integrator.inertia:
        return
    raise PartError(
        "this enforcement follows the stress of the slave's cells, and this integrator looks for no balance of it: in "
        "steps in time pressures would answer stresses of an earlier moment, and feed on themselves",
        where=below(where, "enforcement"), got=spec, allowed="with an integrator of statics: newton",
        hint="take a mortar with its usual enforcement here, or a pressure law of the gap alone",
    )  # fmt: skip


def refuse_slave(plan: ContactPlan, bodies: tuple[Body, ...]) -> None:
    """Raise PartError for a slave whose stresses have no known derivative."""
    for behind in edges_behind(plan.slave, bodies):
        body = bodies[behind.body]
        if not follows_tables(body):
            others = (bodies[edges.body] for edges in edges_behind(plan.master, bodies))
            swap = ", or swap slave and master" if all(map(follows_tables, others)) else ""
            raise PartError(
                "the enforcement needs the stress of the cells behind the slave and its derivative, which this element "
                "does not give: its forces do not follow from its tables",
                where=plan.where, got=f"{type(body.element).__name__} in {body.name}",
                allowed="elements that are their tables: q1, q2", hint=f"take q1 or q2 there{swap}",
            )  # fmt: skip


def refuse_loads(plans: tuple[ContactPlan, ...], scene: Scene, bodies: tuple[Body, ...]) -> None:
    """Raise SceneError for a load on a slave: the stress behind it would belong to load and contact together."""
    for number, load in enumerate(scene.loads):
        if load.pressure is None and load.tx is None and load.ty is None:
            continue
        where = below(scene.where(f"loads.{number}"), "on")
        loaded = {frozenset(edge) for edge in edge_set(bodies, load.on, where)[1][:, :2].tolist()}
        for plan in plans:
            slave = {frozenset(edge) for edge in plan.slave.nodes[plan.slave.edges[:, :2]].tolist()}
            if loaded & slave:
                raise SceneError(
                    f"the enforcement of {plan.label} takes the stress behind the slave for the contact's, and a load "
                    "acts on the slave as well",
                    where=where, got=load.on, allowed="loads away from the slave",
                    hint="swap slave and master, or take another enforcement",
                )  # fmt: skip


class TractionBehind:
    """Normal traction at slave nodes, per slot of the model: the mean of n . sigma n over the hat of the node.

    Stresses at the quadrature points are continued to the edge as polynomials. The edge gets the stress in
    the geometry of the law, as in internal forces, over the present length and along the present normal; so a uniform
    pressure is reproduced to round-off for all kinematics. Tension is positive.

    slots  k, all multipliers of the model
    """

    def __init__(
        self, pairs: Sequence[ContactPair], forces: tuple[BodyForces, ...], position: Floats, slots: int
    ) -> None:
        self.shape = slots, position.size
        self.strips = [strip for pair in pairs for strip in _strips(pair, forces, position)]

    def values(self, own: slice = ALL) -> Floats:
        """Return tractions (k,) [MPa] of the last update of stresses, or those of a part of the slots."""
        force, length = np.zeros(self.shape[0]), np.zeros(self.shape[0])
        for strip in self.strips:
            strip.add_to(force, length)
        return np.divide(force, length, out=np.zeros_like(force), where=length > 0.0)[own]

    def derivative(self) -> Any:
        """Return derivatives (k, 2N) [MPa/mm] of `values`, sparse."""
        force, length = np.zeros(self.shape[0]), np.zeros(self.shape[0])
        for strip in self.strips:
            strip.add_to(force, length)
        over = np.divide(1.0, length, out=np.zeros_like(length), where=length > 0.0)
        parts = [part for strip in self.strips for part in strip.derivatives(force * over)]
        row, column, value = (np.concatenate(part) for part in zip(*parts, strict=True))
        return coo_array((over[row] * value, (row, column)), shape=self.shape).tocsr()


@dataclass
class _Strip:
    """Cells of one block behind one surface: f edges with p points, b nodes per edge, a per cell, q points per cell.

    number    of the block in `forces`
    slot      (f, b) of the nodes along the edge
    nodes     (f, b) global numbers of these nodes
    cells     (f,) columns of the block's connectivity
    continued (f, p, q) from quadrature points to edge points
    hat       (p, b) values of the hats times weights, along (p, b) derivatives of the trace
    gradients (q, a, 2) of the shape functions by reference coordinates
    """

    forces: BodyForces
    number: int
    position: Floats
    slot: Ints
    nodes: Ints
    cells: Ints
    continued: Floats
    hat: Floats
    along: Floats
    gradients: Floats

    @property
    def block(self) -> Block:
        """The block with the stress of the last update, valid until another block is asked for."""
        return self.forces.renewed(self.number)

    def add_to(self, force: Floats, length: Floats) -> None:
        """Add normal force and length of each slot (k,)."""
        stress, moved, shape = self._at_edges()
        size = np.hypot(moved[..., 0], moved[..., 1])
        pushed = np.einsum("fpi,fpij,fpj->fp", _right(moved), stress, _right(shape)) / size
        np.add.at(force, self.slot, pushed @ self.hat)
        np.add.at(length, self.slot, size @ self.hat)

    def derivatives(self, traction: Floats) -> Iterator[Entries]:
        """Yield derivatives of normal forces less derivatives of lengths times the `traction` (k,)."""
        stress, moved, shape = self._at_edges()
        size = np.hypot(moved[..., 0], moved[..., 1])[..., None]
        normal, out = _right(moved) / size, _right(shape)
        change = np.einsum("fpi,ijfpak,fpj->fpak", normal, self._stress_derivatives(), out, optimize=True)
        cells = self.block.connectivity.T[self.cells]
        yield self._entries(np.einsum("pb,fpak->fbak", self.hat, change), cells)
        pushed = np.einsum("fpij,fpj->fpi", stress, out)
        across = pushed - normal * np.einsum("fpi,fpi->fp", normal, pushed)[..., None]
        turn = _left(across) / size
        if self.forces.body.material.kinematics != "small":
            turn = turn + _left(np.einsum("fpij,fpj->fpi", stress, normal))
        own = np.einsum("pb,fpi->fbpi", self.hat, turn)
        own -= traction[self.slot][:, :, None, None] * np.einsum("pb,fpi->fbpi", self.hat, moved / size)
        yield self._entries(np.einsum("fbpi,pa->fbai", own, self.along), self.nodes)

    def _entries(self, values: Floats, columns: Ints) -> Entries:
        """Return entries from derivatives (f, b, c, 2) of the slots by the nodes `columns` (f, c)."""
        row = np.broadcast_to(self.slot[:, :, None, None], values.shape)
        column = np.broadcast_to((2 * columns[..., None] + np.arange(2))[:, None], values.shape)
        return row.ravel(), column.ravel(), values.ravel()

    def _at_edges(self) -> tuple[Floats, Floats, Floats]:
        """Return stresses (f, p, 2, 2), and derivatives (f, p, 2) along the edge of positions and law geometry."""
        points = self.block.stress.reshape(4, self.continued.shape[2], -1)[:, :, self.cells]
        s = np.einsum("fpq,cqf->cfp", self.continued, points)
        stress = np.stack([s[0], s[3], s[3], s[1]], axis=-1).reshape(*s.shape[1:], 2, 2)
        moved, shape = (
            np.einsum("pb,fbi->fpi", self.along, where[self.nodes]) for where in (self.position, self.forces.geometry)
        )
        return stress, moved, shape

    def _stress_derivatives(self) -> Floats:
        """Return derivatives of stresses at edges by the nodes of cells, (2, 2, f, p, a, 2)."""
        block = self.block
        points = block.stress.shape[1]
        tangent, modulus = np.zeros((4, 4, points)), np.zeros((4, 4, points))
        block.law.tangent(block.gradient, block.history, self.forces.dt, tangent)
        # without the stress, which brings the change of the geometry: this is known here
        kind = KIND[self.forces.body.material.kinematics]
        two_point_modulus(kind, block.gradient, np.zeros_like(block.stress), tangent, modulus)
        own = modulus.reshape(2, 2, 2, 2, self.continued.shape[2], -1)[..., self.cells]
        cells = self.forces.geometry[block.connectivity.T[self.cells]]
        jacobian = np.einsum("fai,qad->fqid", cells, self.gradients)
        gradients = np.einsum("qad,fqdi->fqai", self.gradients, np.linalg.inv(jacobian))
        by_node = np.einsum("ijklqf,fqal->ijfqak", own, gradients, optimize=True)
        return np.asarray(np.einsum("fpq,ijfqak->ijfpak", self.continued, by_node, optimize=True))


def _right(along: Floats) -> Floats:
    """Return vectors (..., 2) turned by -90 degrees: outward normals of edges with the body on their left."""
    return np.stack([along[..., 1], -along[..., 0]], axis=-1)


def _left(across: Floats) -> Floats:
    """Return the transpose of `_right`."""
    return np.stack([-across[..., 1], across[..., 0]], axis=-1)


def _strips(pair: ContactPair, forces: tuple[BodyForces, ...], position: Floats) -> Iterator[_Strip]:
    surface = pair.slave
    for behind in edges_behind(surface, tuple(one.body for one in forces)):
        one = forces[behind.body]
        element, first = one.body.element, 0
        hat, along, continued = _tables(element)
        gradients = np.ascontiguousarray(element.shape(element.quadrature().points).gradient)
        local = np.array([_in_order(edge) for edge in element.edges])
        for number, block in enumerate(one.blocks):
            count = block.connectivity.shape[1]
            own = np.flatnonzero((behind.cell >= first) & (behind.cell < first + count))
            cells, side = behind.cell[own] - first, behind.side[own]
            first += count
            if not len(own):
                continue
            nodes = block.connectivity[local[side], cells[:, None]]
            # positions in `Surface.nodes` of the nodes along edges; a corner node belongs to two chains
            given = surface.edges[behind.edge[own]]
            given = np.concatenate([given[:, :1], given[:, 2:], given[:, 1:2]], axis=1)
            turned = surface.nodes[given[:, 0]] != nodes[:, 0]
            places = np.where(turned[:, None], given[:, ::-1], given)
            for row in range(pair.rows_per_node):
                slot = pair.first_slot + row * len(surface.nodes) + places
                yield _Strip(one, number, position, slot, nodes, cells, continued[side], hat, along, gradients)


def _in_order(edge: Sequence[int]) -> list[int]:
    """Return nodes of a side from its start to its end."""
    return [edge[0], *edge[2:], edge[1]]


def _tables(element: Element) -> tuple[Floats, Floats, Floats]:
    """Return weighted hats (p, b), trace derivatives (p, b), and continuation (sides, p, q), nodes along the edge."""
    places, weights = np.polynomial.legendre.leggauss(element.degree + 1)
    ends = np.linspace(-1.0, 1.0, len(element.edges[0]))
    half = 0.5 * (ends[1] - ends[0])
    s = np.concatenate([low + half * (places + 1.0) for low in ends[:-1]])
    hat = np.stack([np.interp(s, ends, one) for one in np.eye(len(ends))], axis=1)
    hat *= np.tile(half * weights, len(ends) - 1)[:, None]
    order = _in_order(range(len(ends)))
    along = element.edge_shape(s)[1][:, order]
    points = element.quadrature().points
    fitted = np.linalg.pinv(_monomials(points, len(points)))
    start, end = (element.nodes[[edge[i] for edge in element.edges]][:, None] for i in range(2))
    at = 0.5 * (1.0 - s[:, None]) * start + 0.5 * (1.0 + s[:, None]) * end
    continued = np.stack([_monomials(side, len(points)) @ fitted for side in at])
    return hat, np.ascontiguousarray(along), continued


def _monomials(points: Floats, known: int) -> Floats:
    """Return products of powers of both coordinates (s, n), as many as `known` values can fix."""
    most = int(np.sqrt(known + 0.5))
    return np.stack([points[:, 0] ** i * points[:, 1] ** j for i in range(most) for j in range(most)], axis=1)
