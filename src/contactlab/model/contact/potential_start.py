"""Setup of contacts by potentials before a run: a fitting scene, stiffness of cells behind, and open surfaces."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from contactlab.api import ExplicitIntegrator, Floats, FrictionLaw, Integrator, Potential, State
from contactlab.api.compiled.chains import nodal_normals, segment_normals
from contactlab.contact.closest import closest_points, first_crossing
from contactlab.errors import PartError, SceneError, Where, below
from contactlab.kernels.contact.search import near_segments
from contactlab.meshing.mesh import cell_measures
from contactlab.model.bodies.body import Body, RigidSurface, positions_of
from contactlab.model.contact.cells_behind import stiffness_behind
from contactlab.model.contact.initial_gap import moved_body, refuse_overlap
from contactlab.model.contact.systems import ContactPlan

ROUNDS = 60
SETTLED = 1e-9  # of the clearance: round-off of positions


def refuse_potential(
    potential: Potential, spec: Any, integrator: Integrator, friction: FrictionLaw | None, where: Where
) -> None:
    """Raise PartError or SceneError for a contact that cannot use a potential."""
    if isinstance(integrator, ExplicitIntegrator):
        raise PartError(
            "this contact algorithm is a potential: its forces depend on the positions that they lead to, so that an "
            "explicit step has no use for it",
            where=below(where, "algorithm"), got=spec.algorithm,
            allowed="with an implicit integrator: newton or implicit-dynamics",
            hint="take a mortar here, or change integrator.use",
        )  # fmt: skip
    if friction is not None and potential.rubs and friction.varies:
        raise PartError(
            "this friction law changes during a run, and friction of a potential needs constants",
            where=below(where, "friction"), got=spec.friction, allowed="a law without needs and memory, as coulomb",
            hint="take a mortar for this law",
        )  # fmt: skip
    if friction is not None and potential.rubs and friction.bound().adhesion and not potential.adheres:
        raise PartError(
            "this contact algorithm knows friction by a coefficient alone", where=below(where, "friction"),
            got=spec.friction, allowed="a law without adhesion, as coulomb", hint="take a mortar for this law",
        )  # fmt: skip
    if friction is not None and not potential.rubs:
        raise PartError(
            "this contact algorithm has no friction", where=below(where, "friction"), got=spec.friction,
            allowed="not written", hint="take the friction out, or another algorithm",
        )  # fmt: skip
    if spec.enforcement and spec.enforcement["use"] != integrator.default_enforcement:
        raise PartError(
            "this contact algorithm is a potential: its pressure follows from its own energy, and it has no use for "
            "another rule of the pressure",
            where=below(where, "enforcement"), got=spec.enforcement, allowed="not written",
            hint="take the enforcement out, or a mortar for it",
        )  # fmt: skip
    if spec.corner is not None:
        raise SceneError(
            "a potential has no normals at nodes that a corner could split", where=below(where, "corner"),
            got=spec.corner, allowed="not written", hint="take the key out, or a mortar for it",
        )  # fmt: skip
    for key, value in (("overlap", "ramp"), ("gap", "zero")):
        if getattr(spec.start, key) == value:
            raise SceneError(
                "a potential counts distances as they are", where=below(below(where, "start"), key), got=value,
                allowed='not written, or overlap = "adjust"', hint="move a body with shift, or take another algorithm",
            )  # fmt: skip


def what_lies_behind(plan: ContactPlan, bodies: tuple[Body, ...], positions: Floats) -> tuple[Floats, Floats]:
    """Return the dilatational modulus (N,) [MPa] of each node's body, and modulus over the depth of its cells.

    Both are inf on rigid surfaces; the second, [MPa/mm], belongs to the contact's own nodes.
    """
    modulus, stiffness = np.full((2, len(positions)), np.inf)
    for body in bodies:
        modulus[body.first : body.first + body.count] = body.dilatational_modulus
    for side in (plan.slave, plan.master):
        stiffness[side.nodes] = stiffness_behind(side, bodies, positions)
    return modulus, stiffness


def opened(
    bodies: tuple[Body, ...], rigid: tuple[RigidSurface, ...], plans: tuple[ContactPlan, ...]
) -> tuple[tuple[ContactPlan, ...], tuple[Body, ...]]:
    """Return the contacts and bodies with slave nodes moved if a potential needs more room than the scene has."""
    positions, found = positions_of(bodies, rigid), []
    for plan in plans:
        amount = _open(plan, bodies, positions) if isinstance(plan.algorithm, Potential) else 0.0
        found.append(replace(plan, opened=amount) if amount > 0.0 else plan)
    if not any(plan.opened for plan in found):
        return plans, bodies
    return tuple(found), tuple(_as_heavy(moved_body(body, positions, plans[0].where), body) for body in bodies)


def _as_heavy(moved: Body, body: Body) -> Body:
    """Return the moved body with its old mass."""
    now, before = (float(cell_measures(each.mesh, each.element).sum()) for each in (moved, body))
    density = body.material.density * before / now
    return moved if now == before else replace(moved, material=replace(body.material, density=density))  # type: ignore[type-var]


def _open(plan: ContactPlan, bodies: tuple[Body, ...], positions: Floats) -> float:
    """Move slave nodes in `positions` into their body until surfaces are apart. Return the largest motion [mm].

    All move first by the largest missing distance, so that the gap keeps its shape.
    """
    behind = what_lies_behind(plan, bodies, positions)
    pair: Any = plan.pair(positions, 0, np.zeros(len(positions), np.bool_), behind)
    clearance = float(pair.potential.clearance(pair.view))
    if not clearance > 0.0:
        return 0.0
    refuse_overlap(plan, pair, bodies, positions)
    slave, master, before = plan.slave, plan.master, positions[plan.slave.nodes].copy()
    for turn in range(ROUNDS):
        x, y = positions[slave.nodes], positions[master.nodes]
        move = np.zeros_like(x)
        lacks = np.zeros(len(x))
        for own, other, at, there in ((slave, master, x, y), (master, slave, y, x)):
            near = near_segments(at, own.segments, there, other.segments, clearance)
            feet = closest_points(at, own, there, other, near)
            lack = np.where(np.abs(feet.distance) < clearance, clearance - feet.distance, 0.0)
            for row in np.flatnonzero(lack > SETTLED * clearance):
                nodes = [feet.node[row]] if own is slave else other.segments[feet.segment[row]]
                away = feet.direction[row] if own is slave else -feet.direction[row]
                for node in nodes:
                    if lack[row] > lacks[node]:
                        lacks[node], move[node] = lack[row], lack[row] * away
        if not lacks.any():
            return float(np.hypot(*(x - before).T).max())
        if turn == 0:
            across, lengths = np.zeros((len(slave.segments), 2)), np.zeros(len(slave.segments))
            segment_normals(x, slave.segments, across, lengths)
            nodal_normals(slave.node_segments, across, lengths, move)
            move *= -lacks.max()
        positions[slave.nodes] += move
    raise SceneError(
        "surfaces cannot be opened for this contact algorithm", where=plan.where,
        got=f"{lacks.max():.3g} mm too close after {ROUNDS} rounds", allowed=f"a distance of {clearance:.3g} mm",
        hint="leave a gap between the bodies with shift",
    )  # fmt: skip


def begin_open(plan: ContactPlan, pair: Any, positions: Floats, state: State) -> None:
    """Raise SceneError if surfaces intersect that must not; give the pair its opening and its friction in the state."""
    from contactlab.contact.potential_pair import Opened

    if pair.potential.clearance(pair.view) > 0.0:
        place = first_crossing(positions, plan.slave, plan.master)
        if place is not None:
            raise SceneError(
                "slave and master intersect before the run", where=plan.where,
                got=f"an intersection at ({place[0]:.6g}, {place[1]:.6g})", allowed="surfaces that touch or have a gap",
                hint='move a body with shift, or write start = { overlap = "adjust" }',
            )  # fmt: skip
    if plan.opened > 0.0:
        pair.start_gaps, pair.opened = Opened(pair.slots, plan.opened), plan.opened
    if pair.friction is not None:
        pair.kept = state[f"friction.{plan.name}"]
