"""Estimate of the error that an algorithm makes which fails the patch test: its forces reach wrong nodes.

The traction that has the work of the slave's forces, in the functions of its edges, also works on the motions of the
master's edges, as in a mortar. In statics the equations at the end say how far bodies move by the difference from the
forces that the algorithm gives the master. For a potential the traction is force over length, and the forces of both
sides are compared with its consistent nodal forces: on quadratic edges they differ.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil
from typing import Any, NamedTuple, cast

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.linalg import splu

from contactlab.api import Floats, Ints, RunWarning, Surface
from contactlab.contact.pair import ContactPair
from contactlab.formulas.segment_kernels import trace
from contactlab.implicit.factor import Factor, SingularSystem
from contactlab.meshing.curves import nearest_segments
from contactlab.model.implicit_model import ImplicitModel
from contactlab.run.coordinates import coordinates
from contactlab.run.stability import linearised

HIGH = 0.01  # of the largest displacement
UNEVEN = 0.04  # of the pressure, in L2: Hertz contacts with eight segments, whose errors the mesh rules, have 0.032
MATCH = 0.01  # of the forces: less does not reach other nodes
POINTS = 8  # on the shorter of two segments: the midpoint rule is right to 1 % of a force there
COVERED = 0.01  # of what a node stands for: with less of it facing the master, it carries nothing


class Effect(NamedTuple):
    """Effect of the forces of a pair that reach wrong nodes.

    node      of the model, that moves furthest
    moved     its way over the largest displacement
    pressure  change of the pressure in L2 over its norm
    """

    node: int
    moved: float
    pressure: float


def patch_errors(model: ImplicitModel, pairs: list[ContactPair]) -> Iterator[RunWarning]:
    """Warn of pairs whose forces would move nodes or change pressures if they acted on the master as a pressure."""
    for pair, effect in _effects(model, pairs):
        told = [f"pressures by about {effect.pressure:.1%} in L2 (limit {UNEVEN:.0%})"] * (effect.pressure > UNEVEN)
        value, limit = effect.pressure, UNEVEN
        if effect.moved > HIGH:
            place = coordinates(model, model.position[effect.node])
            told = [
                f"the way of the node at {place} by about {effect.moved:.1%} of the largest (limit {HIGH:.0%})",
                *told,
            ]
            value, limit = effect.moved, HIGH
        if told:
            yield RunWarning(
                "patch-test", float(f"{value:.4g}"), limit, f"{pair.name}.algorithm",
                f"{pair.name}: the algorithm fails the patch test: its nodal forces are not consistent with a "
                f"pressure, which changes {' and '.join(told)}; take an algorithm that passes it, such as a "
                "mortar, or put the nodes of both sides opposite each other",
            )  # fmt: skip


def _effects(model: ImplicitModel, pairs: list[ContactPair]) -> Iterator[tuple[ContactPair, Effect]]:
    """Pairs with nodes that do not face each other, and what the equations at the end say of them."""
    assert model.contact is not None
    wrong = [(pair, force) for pair in pairs if (force := _wrong_forces(model, pair)) is not None]
    if not wrong:
        return
    equations, force = linearised(model), model.contact.conditions.force[0]
    n, at = int(np.count_nonzero(equations.free)), equations.conditions
    try:
        factor = Factor(equations.matrix)
    except SingularSystem:
        return  # a motion that nothing resists
    largest = max(float(np.abs(model.state["displacement"]).max()), np.finfo(float).tiny)
    for pair, off in wrong:
        change = factor.once(np.concatenate([off.ravel()[equations.free], np.zeros(len(at))]))
        motion, added = np.zeros(model.reference.size), np.zeros(len(force))
        motion[equations.free], added[at[at >= 0]] = change[:n], change[n:][at >= 0]
        way = np.hypot(*motion.reshape(-1, 2).T)
        root = np.sqrt(np.where(pair.cover > 0.0, pair.cover, np.inf))
        size = float(np.linalg.norm(force[pair.own] / root)) or np.inf
        share = float(np.linalg.norm(added[pair.own] / root)) / size  # 0 of potentials, which have no conditions
        yield pair, Effect(int(way.argmax()), float(way.max()) / largest, share)


def _wrong_forces(model: ImplicitModel, pair: ContactPair) -> Floats | None:
    """Return consistent forces of the traction minus forces of the algorithm (N, 2) [N]; None if they agree."""
    slave, master = pair.slave, pair.master
    given, wrong = _given_forces(model, pair), np.zeros_like(model.reference)
    if not given[slave.nodes].any():
        return None
    mass, passed, covered = _operators(model, pair, given[slave.nodes])
    ends = np.repeat(slave.lengths(model.position[slave.nodes]), 2)
    whole = np.bincount(slave.segments.ravel(), ends, len(slave.nodes)) / 3.0
    carries = np.flatnonzero(mass.diagonal() > COVERED * whole)
    if not len(carries):
        return None
    sides = [(master.nodes, -passed[carries].T)]
    if pair.by_energy:
        traction = given[slave.nodes[carries]] / np.where(covered > 0.0, covered, np.inf)[carries, None]
        sides.append((slave.nodes, mass[carries].T))
    else:
        try:
            traction = splu(mass[carries][:, carries].tocsc()).solve(given[slave.nodes[carries]])
        except RuntimeError:
            return None  # too little of some node faces the master
    for nodes, integrals in sides:
        right = integrals @ traction
        wrong[nodes] = _without_resultant(right - given[nodes], np.hypot(*right.T), model.position[nodes])
    wrong.ravel()[model.prescribed.dof] = 0.0
    return wrong if np.abs(wrong).sum() > MATCH * np.abs(given[master.nodes]).sum() else None


def _operators(model: ImplicitModel, pair: ContactPair, nodal: Floats) -> tuple[Any, Any, Floats]:
    """Integrals [mm] of products of the slave's functions, and with the master's (CSR), where both sides face.

    The third array has the length [mm] of each slave node (m,) there, half of each of its segments.
    nodal  (m, 2) [N] forces on the slave: segments without any are left out
    """
    slave, master, place = pair.slave, pair.master, model.position[pair.slave.nodes]
    length = slave.lengths(place)
    shortest = float(master.lengths(model.position[master.nodes]).min())
    pressed = np.asarray(nodal[slave.edges].any(axis=(1, 2)))[slave.segment_edge[:, 0]]
    found, covered = list[tuple[tuple[Ints, Floats], tuple[Ints, Floats], Floats]](), np.zeros(len(slave.nodes))
    for segment in np.flatnonzero(pressed).tolist():
        count = POINTS * ceil(length[segment] / min(shortest, length[segment]))
        along = (np.arange(count) + 0.5) / count
        begin, end = place[slave.segments[segment]]
        nearest, share = nearest_segments(begin + along[:, None] * (end - begin), master, model.position)
        before, after = master.node_segments[master.segments[nearest], [0, 1]].T  # -1 where a chain begins or ends
        faces = ((share >= 0.0) | (before >= 0)) & ((share <= 1.0) | (after >= 0))
        own = _trace(slave, np.full(count, segment, np.int32)[faces], along[faces])
        other = _trace(master, nearest[faces], np.clip(share[faces], 0.0, 1.0))
        found.append((own, other, np.full(len(own[0]), length[segment] / count)))
        far = along[faces].sum() / count
        covered[slave.segments[segment]] += length[segment] * np.array([faces.mean() - far, far])
    one, two = (
        (np.concatenate([part[side][0] for part in found]), np.concatenate([part[side][1] for part in found]))
        for side in (0, 1)
    )
    weight = np.concatenate([part[2] for part in found])
    return (
        _products(one, one, weight, (len(slave.nodes), len(slave.nodes))),
        _products(one, two, weight, (len(slave.nodes), len(master.nodes))),
        covered,
    )


def _products(one: tuple[Ints, Floats], other: tuple[Ints, Floats], weight: Floats, shape: tuple[int, int]) -> Any:
    """Sum of weights (n,) times products of functions, as nodes (n, b) and values (n, b) at the same points (CSR)."""
    value = weight[:, None, None] * one[1][:, :, None] * other[1][:, None, :]
    row, column = (np.broadcast_to(index, value.shape) for index in (one[0][:, :, None], other[0][:, None, :]))
    return coo_array((value.ravel(), (row.ravel(), column.ravel())), shape=shape).tocsr()


def _without_resultant(force: Floats, weight: Floats, place: Floats) -> Floats:
    """Forces (m, 2) less a field of rigid motion times `weight` (m,) that takes their resultant and torque with it.

    What a rim covers in part, and gaps below facets, change these: they are judged elsewhere, and would move bodies.
    """
    if not weight.any():
        return np.zeros_like(force)
    away = place - np.average(place, axis=0, weights=weight)
    turn = np.stack([-away[:, 1], away[:, 0]], axis=1)
    spread = float(weight @ (turn**2).sum(axis=1)) or np.inf
    rigid = force.sum(axis=0) / weight.sum() + float((force * turn).sum()) / spread * turn
    return np.asarray(force - weight[:, None] * rigid)


def _given_forces(model: ImplicitModel, pair: ContactPair) -> Floats:
    """Nodal forces (N, 2) [N] of one pair on both sides."""
    assert model.contact is not None
    if pair.by_energy:
        forces, potential = np.zeros_like(model.reference), cast("Any", pair)  # a class that other scenes do not import
        potential.add_forces(forces, forces)
        return forces
    conditions = model.contact.conditions
    own = np.arange(len(conditions.force[0]))[pair.own]
    pressed = own[conditions.present[own] & (conditions.force[0, own] > 0.0)].astype(np.int32)
    change = model.contact.linearise(pressed)
    forces = conditions.force[0, pressed] @ change.normal
    if change.tangent is not None:
        forces = forces + conditions.force[1, pressed] @ change.tangent
    return np.asarray(forces).reshape(-1, 2)


def _trace(surface: Surface, segments: Ints, share: Floats) -> tuple[Ints, Floats]:
    """Nodes (n, b) of the edges of segments, and their functions (n, b) at a share (n,) of each segment."""
    edge, half = surface.segment_edge[segments].T
    count = surface.edges.shape[1]
    values = [trace.py_func(count, half, share, i) for i in range(count)]  # type: ignore[attr-defined]
    return surface.edges[edge], np.stack(values, axis=1)
