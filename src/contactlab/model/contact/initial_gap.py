"""Overlaps and small gaps of the meshes before the run, and their treatment by a contact."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from contactlab.api import Floats, Surface
from contactlab.api.arrays import Flags
from contactlab.contact.pair import ContactPair, initial_gaps, start_distances
from contactlab.contact.start_gaps import FacetOverlap, FittedFacets, RampedOverlap
from contactlab.errors import SceneError, Where, below
from contactlab.kernels.contact.pair import FAR
from contactlab.kernels.contact.penetration import depths, with_midpoints
from contactlab.meshing.curves import distances_to_curve, facet_depths
from contactlab.meshing.mesh import inverted_cells
from contactlab.model.bodies.body import Body, RigidSurface, positions_of
from contactlab.model.contact.checks import check_overlap, overlap_error
from contactlab.model.loading.ramps import smooth

ROUND = 1e-6  # segment lengths: pushing this out in one step costs a millionth of the wave speed
SETTLED = 1e-12  # segment lengths left after an adjustment
ROUND_OFF = 8.0 * float(np.finfo(float).eps)  # of the largest coordinate: what positions far from the origin resolve
ROUNDS = 60
FEWEST_STEPS = 100
CURVED = 0.05  # of the depth of facets: error of a parabola through three nodes of a curve


def adjusted_bodies(
    bodies: tuple[Body, ...], rigid: tuple[RigidSurface, ...], plans: tuple[Any, ...]
) -> tuple[Body, ...]:
    """Return the bodies with slave nodes moved onto their masters, for contacts that request it.

    A node moves along its normal until its own gap constraint is zero; the moved mesh is the undeformed mesh,
    so nothing is strained.
    """
    asked = [plan for plan in plans if plan.start.overlap == "adjust"]
    if not asked:
        return bodies
    positions = positions_of(bodies, rigid)
    for plan in asked:
        _check_reach(plan, positions)
        check_overlap(plan.slave, plan.master, bodies, positions, True, plan.where)
        _adjust(plan, positions)
    return tuple(moved_body(body, positions, asked[0].where) for body in bodies)


def _check_reach(plan: Any, positions: Floats) -> None:
    """Raise SceneError for a gap that is wider than the model: nothing in it could stay open."""
    size = float(np.hypot(*np.ptp(positions, axis=0)))
    if plan.start.gap > size:
        raise SceneError(
            "the gap to be closed is wider than the model",
            where=below(below(plan.where, "start"), "gap"), got=plan.start.gap, allowed=f"up to {size:.4g} mm",
        )  # fmt: skip


def _adjust(plan: Any, positions: Floats) -> None:
    """Move slave nodes in `positions` until overlaps, and gaps up to the declared one, are gone."""
    pair = plan.pair(positions, 0, np.zeros(len(positions), np.bool_))
    chosen: Flags | None = None
    settled = max(SETTLED * pair.size, ROUND_OFF * float(np.abs(positions).max()))
    for _ in range(ROUNDS):
        gaps = initial_gaps(pair, positions)
        if chosen is None:
            chosen = gaps <= plan.start.gap
        error = np.where(chosen & (gaps < FAR), gaps, 0.0)
        if np.abs(error).max(initial=0.0) <= settled:
            return
        m = len(pair.slave.nodes)
        for slot in range(pair.slots // m):
            own = slice(slot * m, (slot + 1) * m)
            positions[pair.slave.nodes] -= error[own, None] * pair.normals[own]
    raise SceneError(
        "the slave's nodes cannot be moved onto the master",
        where=below(plan.where, "start"),
        got=f"{np.abs(error).max():.3g} mm left after {ROUNDS} rounds",
        allowed="surfaces that can be fitted",
        hint='mend the mesh, or write start = { overlap = "ramp" }',
    )


def moved_body(body: Body, positions: Floats, where: Where) -> Body:
    """Return the body with its nodes at `positions` (N, 2) of the model; SceneError if a cell turns over."""
    nodes = np.ascontiguousarray(positions[body.first : body.first + body.count])
    moved = replace(body, mesh=replace(body.mesh, nodes=nodes))
    folded = inverted_cells(moved.mesh, body.element)
    if len(folded):
        raise SceneError(
            f"moving the slave's nodes onto the master inverts {len(folded)} cells of {body.name}",
            where=below(where, "start"),
            got=f"cell {folded[0]} first",
            allowed="overlaps that leave every cell its area",
            hint='move the body with shift, or write start = { overlap = "ramp" }',
        )
    return moved


def refuse_overlap(plan: Any, pair: Any, bodies: tuple[Body, ...], positions: Floats) -> None:
    """Raise SceneError for an overlap without a treatment in the contact.

    Both must show it: the shapes, and the algorithm that would push it out. A weighted gap alone may be slightly
    negative without overlap, a shape alone if curved surfaces have different chords. If both do, and
    no node lies within the curve of the other side, facets of curves that fit overlap: distances of the curves count.
    """
    treated = plan.start.overlap == "ramp" or plan.start.gap == "zero"
    check_overlap(plan.slave, plan.master, bodies, positions, treated, plan.where)
    slack = ROUND * pair.size
    if treated or initial_gaps(pair, positions).min() >= -slack:
        return
    sides = (pair.at.slave, plan.slave, plan.sides[1]), (pair.at.master, plan.master, plan.sides[0])
    for (points, own, inside), (other, chain, _) in (sides, sides[::-1]):
        points = with_midpoints(points, own.segments)
        depth = depths(points, other, chain.segments, pair.size)
        worst = int(np.argmax(depth))
        if depth[worst] > slack:
            if pair.by_energy or not _curves_fit(pair, positions):
                raise overlap_error(float(depth[worst]), points[worst], inside, False, plan.where)
            pair.start_gaps = FittedFacets(_made_by_facets(pair, positions))
            return


def _made_by_facets(pair: ContactPair, positions: Floats) -> Floats:
    """Return distances (k,) [mm] by facets between fitting curves, whose clearance is known at the nodes."""
    slave, master = pair.slave, pair.master
    clearance = distances_to_curve(positions[slave.nodes], master, positions, positions)
    clearance[clearance < _uncertain(pair, master, positions)] = 0.0
    most = sum(float(facet_depths(side, positions).max()) for side in (slave, master))
    gaps = start_distances(pair, positions)
    made = np.clip(gaps - np.tile(clearance, pair.rows_per_node), -most, most)
    return np.where(gaps < FAR, made, 0.0)


def _curves_fit(pair: ContactPair, positions: Floats) -> bool:
    """Return whether no node of both sides lies within the curve of the other: facets alone overlap."""
    for own, other in ((pair.slave, pair.master), (pair.master, pair.slave)):
        deepest = float(distances_to_curve(positions[own.nodes], other, positions, positions).min())
        if deepest < -_uncertain(pair, other, positions):
            return False
    return True


def _uncertain(pair: ContactPair, other: Surface, positions: Floats) -> float:
    """Return the uncertainty [mm] of the distance to the curve of a side."""
    return ROUND * pair.size + CURVED * float(facet_depths(other, positions).max())


def ramped_overlap(pair: ContactPair, time: Floats, duration: float, positions: Floats) -> RampedOverlap:
    """Return overlaps at `positions` that count after `duration` [s]; `time` begins with the time of the gaps [s]."""
    return RampedOverlap(start_distances(pair, positions), time, smooth(duration))


def facet_overlap(pair: ContactPair, time: Floats, duration: float, positions: Floats) -> FacetOverlap | None:
    """Return weak overlaps at `positions` without overlapping nodes, which count after `duration` [s]; None without."""
    gaps = start_distances(pair, positions)
    return FacetOverlap(gaps, time, smooth(duration)) if gaps.min() < -ROUND * pair.size else None


def check_ramp_steps(plans: tuple[Any, ...], ramp_time: float, step: float) -> None:
    """Raise SceneError if an overlap would be pushed out in too few steps, as an impact."""
    for plan in plans:
        duration = plan.start.duration or ramp_time
        if plan.start.overlap == "ramp" and duration < FEWEST_STEPS * step:
            raise SceneError(
                f"the overlap is pushed out within {duration / step:.0f} steps",
                where=below(below(plan.where, "start"), "duration"),
                got=duration,
                allowed=f"at least {FEWEST_STEPS} steps, {FEWEST_STEPS * step:.3g} s",
            )
