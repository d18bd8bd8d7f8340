"""Checks of contact algorithms."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from contactlab.api import ContactAlgorithm, ContactMethod, ContactView, GapConditions, Pieces, SurfacePositions
from contactlab.kernels.contact.search import REACH, near_segments
from contactlab.testing import contact_derivatives, contact_inputs
from contactlab.testing.assertions import Check, Expected, NotApplicable, agree, identical, require, tell, untouched
from contactlab.testing.surfaces import (
    HIGH,
    LOW,
    Chains,
    conditions,
    consistent_loads,
    curved,
    dense,
    flat,
    pair_of,
    rotation,
    rows_of_pair,
)

ROUND_OFF = 1e-12  # rows go through the inverse of T, whose condition is below ten


def some_conditions(algorithm: ContactMethod) -> None:
    """Surfaces that touch give a condition for most slave nodes, in a well-formed sparse pattern."""
    at = flat()
    found = conditions(algorithm, at)
    k, z = len(found.gap), len(found.node)
    require(k >= len(at.slave.nodes) - 2, f"{k} conditions for {len(at.slave.nodes)} covered slave nodes")
    require(found.start[0] == 0 and found.start[-1] == z, "start: not the row pointers of the entries")
    require(np.all(np.diff(found.start) > 0), "start: a condition has no entries")
    require(found.node.min() >= 0 and found.node.max() < len(at.nodes), "node: outside the global numbers")
    require(len(np.unique(found.owner)) == k, "owner: two conditions belong to the same slot")
    require(np.all(found.measure > 0.0), "measure: a condition has no length")


def forces_cancel(algorithm: ContactMethod) -> None:
    """Each condition pushes both surfaces equally: its weights sum to zero."""
    for at in (flat(), flat(full=False), curved()):
        found = conditions(algorithm, at)
        total = dense(found, found.normal_weight, len(at.nodes)).sum(axis=1)
        agree(total, np.zeros_like(total), ROUND_OFF, "resultant of a condition")


def moments_cancel_on_a_flat(algorithm: ContactMethod) -> None:
    """A normal force on flat surfaces has no moment, at any gap."""
    for lift in (0.0, 0.1):
        at = flat().lifted((0.0, lift)).turned(0.4)
        found = conditions(algorithm, at)
        weights = dense(found, found.normal_weight, len(at.nodes))
        moment = (at.nodes[:, 0] * weights[..., 1] - at.nodes[:, 1] * weights[..., 0]).sum(axis=1)
        agree(moment, np.zeros_like(moment), 10.0 * ROUND_OFF, f"moment of a condition at gap {lift}")


def weights_belong_to_the_gap(algorithm: ContactMethod) -> None:
    """The gap is the sum of weights times positions, on curved surfaces too."""
    for at in (flat().lifted((0.0, 0.03)), curved()):
        found = conditions(algorithm, at)
        weighted = (dense(found, found.normal_weight, len(at.nodes)) * at.nodes).sum(axis=(1, 2))
        agree(found.gap, weighted, ROUND_OFF, "gap against its weights")


def weights_are_the_derivative(algorithm: ContactMethod) -> None:
    """Weights of flush surfaces are the derivative of the gaps by every node's position."""
    at, step = flat().turned(0.3), 1e-6
    found = conditions(algorithm, at)
    weights = dense(found, found.normal_weight, len(at.nodes))
    for node in range(len(at.nodes)):
        for i in range(2):
            shift = np.zeros_like(at.nodes)
            shift[node, i] = step
            high, low = (conditions(algorithm, at.moved(at.nodes + s * shift)).gap for s in (1.0, -1.0))
            # turning normals and changing weights act on a gap of zero: what is left is of second order
            agree((high - low) / (2.0 * step), weights[:, node, i], 1e-5, f"d(gap)/d(position {i} of node {node})")


def closest_points_are_closest(algorithm: ContactMethod) -> None:
    """Gaps of closest points change with the weights alone, on curved surfaces too: normals and feet do not count."""
    if not getattr(algorithm, "closest_points", False):
        raise NotApplicable("the algorithm does not declare closest_points")
    at, step, rng = curved(), 1e-6, np.random.default_rng(2)
    found = conditions(algorithm, at)
    weights = dense(found, found.normal_weight, len(at.nodes))
    for _ in range(4):
        along = rng.uniform(-1.0, 1.0, at.nodes.shape)
        high, low = (conditions(algorithm, at.moved(at.nodes + s * step * along)).gap for s in (1.0, -1.0))
        # differences leave 1e-10, and gaps along another normal the tangent of the angle between both
        agree((high - low) / (2.0 * step), (weights * along).sum(axis=(1, 2)), 1e-6, "gaps that change, and weights")


def gap_is_positive_when_open(algorithm: ContactMethod) -> None:
    """The gap of parallel surfaces is their distance, negative when they overlap."""
    for lift in (0.05, -0.05):
        found = conditions(algorithm, flat().lifted((0.0, lift)))
        agree(found.gap, np.full(len(found.gap), lift), ROUND_OFF, "gap of parallel surfaces")


def normals_point_to_the_slave(algorithm: ContactMethod) -> None:
    """Normals are unit vectors away from the master: the slave's weights of a condition sum to one of them."""
    for at in (flat().turned(2.0), curved()):
        found = conditions(algorithm, at)
        normal = dense(found, found.normal_weight, len(at.nodes))[:, at.slave.nodes].sum(axis=1)
        agree(np.hypot(*normal.T), np.ones(len(normal)), ROUND_OFF, "length of the normal")
    up = conditions(algorithm, flat())
    agree(
        dense(up, up.normal_weight, len(flat().nodes))[:, flat().slave.nodes].sum(axis=1),
        np.tile([0.0, 1.0], (len(up.gap), 1)),
        ROUND_OFF,
        "normal of a slave that lies above",
    )


def tangents_run_along_the_slave(algorithm: ContactMethod) -> None:
    """Tangent weights are the normal weights turned to run along the slave; none are made without friction."""
    at = curved()
    found = conditions(algorithm, at, tangent=True)
    normal = dense(found, found.normal_weight, len(at.nodes))
    tangent = dense(found, found.tangent_weight, len(at.nodes))
    agree(tangent, np.stack([normal[..., 1], -normal[..., 0]], axis=-1), ROUND_OFF, "tangent weights")
    require(conditions(algorithm, at).tangent_weight.shape == (0, 2), "tangent weights are not empty without friction")


def measures_sum_to_the_cover(algorithm: ContactMethod) -> None:
    """The lengths that belong to the conditions sum to the covered length of the slave."""
    agree(conditions(algorithm, flat()).measure.sum(), HIGH - LOW, ROUND_OFF, "sum of measures on full cover")


def multipliers_are_biorthogonal(algorithm: ContactMethod) -> None:
    """The coupling T of multipliers is diagonal, on partly covered segments too, if the part declares so."""
    if not isinstance(algorithm, ContactAlgorithm):
        raise NotApplicable("finished gap conditions have no coupling")
    worst = max(_coupled(algorithm, at) for at in (flat(), flat(full=False), curved(), flat(full=False, order=2)))
    if algorithm.biorthogonal:
        require(worst <= ROUND_OFF, f"hats of neighbours: {worst:.1e} of the largest entry of T, allowed {ROUND_OFF}")
    elif worst > ROUND_OFF:
        raise NotApplicable("biorthogonal is False: multipliers are coupled")
    elif _pieces(algorithm, flat())[0].T.shape[1] > 1:
        tell("T is diagonal; declare biorthogonal = True")


def _coupled(algorithm: ContactAlgorithm, at: Chains) -> float:
    """Largest entry of T off its diagonal, over the largest of all."""
    out, count, _ = _pieces(algorithm, at)
    T, of = np.zeros((len(out.normal),) * 2), out.multiplier[:count]
    np.add.at(T, (of[:, :, None], of[:, None]), out.T[:count])
    return float(np.abs(T - np.diag(T.diagonal())).max() / np.abs(T).max())


def patch_test(algorithm: ContactMethod) -> None:
    """A uniform pressure is transmitted between meshes that do not match, if the part declares so."""
    cases = {"full cover": flat(), "partial cover": flat(full=False), "finer master": flat(edges=(4, 11))}
    worst = {name: _patch_error(algorithm, at) for name, at in cases.items()}
    if algorithm.passes_patch_test:
        for name, error in worst.items():
            require(error < 1e-11, f"patch test, {name}: nodal forces off by {error:.1e} of the load, allowed 1e-11")
    elif max(worst.values()) <= 1e-6:
        tell("the patch test is passed; declare passes_patch_test = True")
    else:
        off = ", ".join(f"{name}: {error:.1e}" for name, error in worst.items())
        raise Expected(f"nodal forces off by ({off}) of the load; passes_patch_test is False")


def patch_test_on_quadratic_edges(algorithm: ContactMethod) -> None:
    """Run the patch test with three nodes per edge."""
    if not algorithm.passes_patch_test:
        raise NotApplicable("the part declares that it fails the patch test")
    for full in (True, False):
        error = _patch_error(algorithm, flat(full, order=2))
        require(error < 1e-11, f"patch test on quadratic edges: off by {error:.1e} of the load, allowed 1e-11")


def _patch_error(algorithm: ContactMethod, at: Chains) -> float:
    """Distance between the nodal forces of a unit pressure and the best that non-negative multipliers give."""
    found = conditions(algorithm, at)
    weights = dense(found, found.normal_weight, len(at.nodes))
    wanted = consistent_loads(at, at.slave, LOW, HIGH) - consistent_loads(at, at.master, LOW, HIGH)
    rows = weights[..., 1].T
    forces = np.linalg.lstsq(rows, wanted, rcond=None)[0]
    missed = np.linalg.norm(rows @ forces - wanted) + np.linalg.norm(np.minimum(forces, 0.0))
    return float(missed / np.linalg.norm(wanted))


def nothing_when_apart(algorithm: ContactMethod) -> None:
    """Surfaces beyond the search distance, above or to the side, have no conditions."""
    at = flat()
    for away in ((0.0, 10.0 * at.spacing), (20.0, 0.0), (20.0, 10.0)):
        count = len(conditions(algorithm, at.lifted(away)).gap)
        require(count == 0, f"{count} conditions between surfaces that are {away} apart")


def only_facing_surfaces(algorithm: ContactMethod) -> None:
    """Surfaces that face the same way, like the two sides of a sheet, are not in contact."""
    at = flat()
    m = len(at.slave.nodes)
    # the master is a copy of the slave, a little above: the slave looks away from it
    copy = replace(at.slave, nodes=(at.slave.nodes + m).astype(np.int32))
    line = at.nodes[at.slave.nodes]
    sheet = Chains(np.concatenate([line, line + np.array([0.0, 0.01])]), at.slave, copy)
    count = len(conditions(algorithm, sheet).gap)
    require(count == 0, f"{count} conditions between surfaces that face the same way")


def rigid_motion_leaves_gaps(algorithm: ContactMethod) -> None:
    """Turning and shifting both surfaces together changes no gap, and turns the weights."""
    for at in (flat().lifted((0.0, 0.02)), curved()):
        before, after = conditions(algorithm, at), conditions(algorithm, at.turned(1.1, (3.0, -2.0)))
        require(
            len(before.gap) == len(after.gap),
            f"{len(before.gap)} conditions become {len(after.gap)} after a rigid motion",
        )
        agree(after.gap, before.gap, 10.0 * ROUND_OFF, "gaps after a rigid motion")
        agree(after.measure, before.measure, 10.0 * ROUND_OFF, "measures after a rigid motion")
        turned = dense(before, before.normal_weight, len(at.nodes)) @ rotation(1.1).T
        agree(dense(after, after.normal_weight, len(at.nodes)), turned, 10.0 * ROUND_OFF, "weights")


def slip_is_objective(algorithm: ContactMethod) -> None:
    """Slip is the sliding of the slave along the master: none in a rigid rotation, the distance in a translation."""
    start = flat(edges=(6, 5))
    agree(_slip(algorithm, start, start.lifted((0.01, 0.0))), 0.01, ROUND_OFF, "slip of a slave that slides by 0.01")
    open_pair = start.lifted((0.0, 0.05))
    agree(_slip(algorithm, open_pair, open_pair.turned(0.2)), 0.0, ROUND_OFF, "slip of an open pair turned rigidly")


def _slip(algorithm: ContactMethod, before: Chains, after: Chains) -> float:
    """The slip of largest size between two positions."""
    pair, memory = pair_of(algorithm, after, friction=True)
    pair.compute_start_normals(before.nodes, memory)
    rows = rows_of_pair(pair, before, friction=True)
    slip = rows.slip[: rows.count]
    return float(slip[np.argmax(np.abs(slip))])


def pieces_keep_their_bounds(algorithm: ContactMethod) -> None:
    """Pieces fit the declared capacity and widths, and each transmits what it takes: sum D = sum M."""
    if not hasattr(algorithm, "pieces"):
        raise NotApplicable("finished gap conditions have no pieces")
    for at in (flat(), flat(full=False), curved()):
        out, count, capacity = _pieces(algorithm, at)
        require(0 < count <= capacity, f"{count} pieces, capacity promised {capacity}")
        m = len(at.slave.nodes)
        for name, index, limit in (
            ("slave", out.slave, m),
            ("multiplier", out.multiplier, m * algorithm.rows_per_node),
            ("master", out.master, len(at.master.nodes)),
        ):
            inside = (index[:count] >= 0) & (index[:count] < limit)
            require(np.all(inside), f"pieces: {name} outside 0 ... {limit - 1}")
        agree(out.D[:count].sum(axis=1), out.M[:count].sum(axis=1), ROUND_OFF, "column sums of D and M of a piece")


def _pieces(algorithm: Any, at: Chains) -> tuple[Pieces, int, int]:
    sides = SurfacePositions(at.nodes[at.slave.nodes], at.nodes[at.master.nodes])
    reach = REACH * at.spacing
    near = near_segments(sides.slave, at.slave.segments, sides.master, at.master.segments, 2.0 * reach)
    capacity = algorithm.capacity(at.slave, near)
    m = len(at.slave.nodes)
    # far more room than promised: a broken promise must be detected, and compiled code checks no bounds
    room = capacity + 4 * len(near.master) + 4 * m
    out = Pieces.allocate(room, algorithm.widths(at.slave, at.master), m * algorithm.rows_per_node)
    memory = np.zeros((algorithm.memory_size, m))
    with untouched(slave_positions=sides.slave, master_positions=sides.master, near=near.master):
        count = algorithm.pieces(ContactView(at.slave, at.master, sides, near, reach, memory), out)
    return out, count, capacity


def same_answer_twice(algorithm: ContactMethod) -> None:
    """The same positions give the same conditions after any other calls, to the last bit."""
    at = curved()
    first = conditions(algorithm, at)
    conditions(algorithm, flat())
    second = conditions(algorithm, at)
    for name in GapConditions.__dataclass_fields__:
        identical(getattr(second, name), getattr(first, name), name)


CHECKS: tuple[Check, ...] = (
    pieces_keep_their_bounds,
    some_conditions,
    forces_cancel,
    moments_cancel_on_a_flat,
    weights_belong_to_the_gap,
    weights_are_the_derivative,
    closest_points_are_closest,
    gap_is_positive_when_open,
    normals_point_to_the_slave,
    tangents_run_along_the_slave,
    measures_sum_to_the_cover,
    multipliers_are_biorthogonal,
    patch_test,
    patch_test_on_quadratic_edges,
    nothing_when_apart,
    only_facing_surfaces,
    rigid_motion_leaves_gaps,
    slip_is_objective,
    same_answer_twice,
    *contact_inputs.CHECKS,
    *contact_derivatives.CHECKS,
)
