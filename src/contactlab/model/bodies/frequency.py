"""Lowest natural frequency excited by the loading; sets the duration of quasi-static runs.

NumPy solves small systems: importing SciPy's solvers takes longer than the solution.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from contactlab.api import Floats, Ints
from contactlab.model.bodies.body import NO_JOINTS, Body, Joints
from contactlab.model.bodies.stiffness import cell_stiffness
from contactlab.model.model_size import SMALL

ROUND = 1e-12  # of the mean stiffness over mass: rigid motions keep round-off of the moduli
STIFF = 100.0  # of the largest nodal stiffness: springs of joints then give a hundredth as much as a cell


def lowest_frequency(
    bodies: Sequence[Body], positions: Floats, mass: Floats, fixed: Ints, directions: Floats, joints: Joints
) -> float:
    """Return the circular frequency [1/s] of the lowest mode excited by pushing along `directions` (d, 2).

    Bodies tied by joints vibrate together, as contact will make them. If this leaves some of them adrift
    (a body that could roll or slide), each counts alone. inf if every degree of freedom is held.
    """
    found: list[float] = []
    for group in _tied_together(bodies, joints):
        together = _frequency(group, positions, mass, fixed, directions, joints)
        alone = (_alone(body, positions, mass, fixed, directions) for body in group)
        found.append(min(alone) if together is None else together)
    return min(found)


def _alone(body: Body, positions: Floats, mass: Floats, fixed: Ints, directions: Floats) -> float:
    """Return the frequency of a body alone; a body adrift on its supports is stretched evenly."""
    found = _frequency([body], positions, mass, fixed, directions, NO_JOINTS)
    if found is not None:
        return found
    own = _free([body], fixed)
    nodal = np.repeat(mass, 2)[own]
    # an even stretch about the centre of mass: compression by neighbours of a body that nothing else holds
    x = positions.reshape(-1)[own]
    centre = [(x * nodal)[own % 2 == c].sum() / max(nodal[own % 2 == c].sum(), 1e-300) for c in range(2)]
    return _rayleigh(_stiffness([body], positions)[own][:, own], nodal, [np.asarray(x - np.asarray(centre)[own % 2])])


def _frequency(
    bodies: Sequence[Body], positions: Floats, mass: Floats, fixed: Ints, directions: Floats, joints: Joints
) -> float | None:
    """Apply Rayleigh's method to bodies tied by joints; None if they are adrift.

    The deflection u under its own inertia forces in a direction gives w^2 = u K u / u M u, a few per cent above the
    mode's frequency. `fixed` dofs (2 * node + component) are held.
    """
    own = _free(bodies, fixed)
    if not len(own):
        return float("inf")
    nodal = np.repeat(mass, 2)[own]
    stiffness = _stiffness(bodies, positions)
    stiffness += _springs(bodies, joints, STIFF * stiffness.diagonal().max(), stiffness.shape[0])
    reduced = stiffness[own][:, own]
    if _adrift(bodies, reduced, positions, nodal, own):
        return None
    return _rayleigh(reduced, nodal, _solved(reduced, [nodal * direction[own % 2] for direction in directions]))


def _rayleigh(stiffness: Any, nodal: Floats, shapes: Sequence[Floats]) -> float:
    squares = [(u @ (stiffness @ u)) / (u @ (nodal * u)) for u in shapes if np.any(u)]
    return float(np.sqrt(min(squares))) if squares else float("inf")


def _free(bodies: Sequence[Body], fixed: Ints) -> Ints:
    """Return degrees of freedom of the bodies that nothing holds, ascending."""
    nodes = np.unique(np.concatenate([body.cells.ravel() for body in bodies]))
    return np.asarray(np.setdiff1d((2 * nodes[:, None] + np.arange(2)).ravel(), fixed))


def _stiffness(bodies: Sequence[Body], positions: Floats) -> Any:
    rows, columns, values = [], [], []
    for body in bodies:
        n, a = body.cells.shape
        dof = (2 * body.cells[:, :, None] + np.arange(2)).reshape(n, 2 * a)
        rows.append(np.repeat(dof, 2 * a, axis=1).ravel())
        columns.append(np.tile(dof, (1, 2 * a)).ravel())
        values.append(cell_stiffness(body, positions).ravel())
    size = 2 * len(positions)
    return _summed(np.concatenate(rows), np.concatenate(columns), np.concatenate(values), (size, size))


def _summed(rows: Any, columns: Any, values: Floats, shape: tuple[int, int]) -> Any:
    """Return a matrix from its entries, with duplicates summed: dense if small, else sparse by columns."""
    if max(shape) <= SMALL:
        place = rows.astype(np.int64) * shape[1] + columns
        return np.bincount(place, values, shape[0] * shape[1]).reshape(shape)
    from scipy.sparse import coo_matrix

    return coo_matrix((values, (rows, columns)), shape=shape).tocsc()


def _solved(stiffness: Any, forces: Sequence[Floats]) -> list[Floats]:
    """Return displacements under each of the forces."""
    if isinstance(stiffness, np.ndarray):
        return list(np.linalg.solve(stiffness, np.stack(forces, axis=1)).T)
    from scipy.sparse.linalg import splu

    return list(map(splu(stiffness.tocsc()).solve, forces))


def _springs(bodies: Sequence[Body], joints: Joints, stiffness: float, size: int) -> Any:
    """Return stiff springs in both directions at the joints of these bodies."""
    mine = np.isin(joints.node, _nodes(bodies)) | np.isin(joints.ends, _nodes(bodies)).any(axis=1)
    node, ends, share = joints.node[mine], joints.ends[mine], joints.share[mine]
    count = len(node)
    nodes = np.stack([node, ends[:, 0], ends[:, 1]], axis=1)
    weights = np.stack([np.ones(count), share - 1.0, -share], axis=1)
    both = np.concatenate([2 * nodes, 2 * nodes + 1])
    rows = np.repeat(np.arange(2 * count), 3)
    ties = _summed(rows, both.ravel(), np.tile(weights, (2, 1)).ravel(), (2 * count, size))
    ties = ties * np.sqrt(stiffness)
    return ties.T @ ties


def _nodes(bodies: Sequence[Body]) -> Ints:
    return np.concatenate([np.arange(body.first, body.first + body.count) for body in bodies])


def _tied_together(bodies: Sequence[Body], joints: Joints) -> list[list[Body]]:
    """Return groups of bodies connected by joints; rigid surfaces, which hold on to nothing, connect none."""
    first = np.array([body.first for body in bodies])
    last = np.array([body.first + body.count for body in bodies])
    of = [np.searchsorted(first, nodes, side="right") - 1 for nodes in (joints.node, joints.ends[:, 0])]
    real = (joints.node < last[of[0]]) & (joints.ends[:, 0] < last[of[1]])
    label = np.arange(len(bodies))
    for one, other in np.unique(np.stack([of[0][real], of[1][real]], axis=1), axis=0):
        label[label == label[other]] = label[one]
    return [[body for body, own in zip(bodies, label, strict=True) if own == k] for k in np.unique(label)]


def _adrift(bodies: Sequence[Body], stiffness: Any, positions: Floats, nodal: Floats, own: Ints) -> bool:
    """Return whether supports and joints leave some rigid motion of the bodies, which costs no energy."""
    modes = []
    for body in bodies:
        mine = (own >= 2 * body.first) & (own < 2 * (body.first + body.count))
        if not mine.any():
            continue
        x = positions - positions[own[mine] // 2].mean(axis=0)
        turn = np.stack([-x[:, 1], x[:, 0]], axis=1).reshape(-1)[own]
        modes += [mine * (own % 2 == 0), mine * (own % 2 == 1), mine * turn / np.abs(turn[mine]).max()]
    shapes = np.stack([mode for mode in modes if np.any(mode)], axis=1).astype(np.float64)
    energy, inertia = shapes.T @ (stiffness @ shapes), shapes.T @ (nodal[:, None] * shapes)
    # a support that holds any of them strains its cells: far above round-off of the stiffest ones
    rigid = ROUND * stiffness.diagonal().sum() / nodal.sum()
    half = np.linalg.inv(np.linalg.cholesky(inertia))
    return bool(np.linalg.eigvalsh(half @ energy @ half.T)[0] < rigid)
