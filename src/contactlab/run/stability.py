"""Stability of the equilibrium that statics found.

An equilibrium is stable if its tangent has positive eigenvalues on the motions that supports and closed contacts leave.
With a row for each closed condition the matrix [[K, -C^T], [-H, -B]], B the softness of pressure laws and 0 otherwise,
has then as many negative pivots as conditions, and each further one is a motion by which the bodies leave the
equilibrium (Wriggers 2008, chapter 7). Past the load of a column's buckling the straight column is such a state, and
Newton's method finds it as willingly as any other.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import block_array, csc_array, csr_array, diags_array, vstack
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigs

from contactlab.api import Floats, Ints, Response, RunWarning
from contactlab.api.arrays import Flags
from contactlab.implicit.factor import Factor, SingularSystem
from contactlab.model.implicit_model import ImplicitModel
from contactlab.model.model import Model

SINGULAR = 1e-9  # of a matrix whose entries are of size 1: the sign of a smaller pivot is round-off
SYMMETRIC = 1e-9  # alike: pivots of a less symmetric matrix give the parity only
SPARE = 2  # motions more than sought, so that one that leaves is seen beside softer ones that do not
DENSE = 24  # degrees of freedom below which Arnoldi's method has no room
ACCURATE = 1e-8  # of a softness: well below `REAL`
REAL = 1e-6  # a softness with more of an imaginary part belongs to a motion that turns, not to one that leaves
HARD = 0.01  # over the largest nodal stiffness: smaller softness, of motions that conditions hold, is round-off
EVEN = 2  # motions sought where an even number may leave
HELD = 1e-4  # of a row of conditions: less of it on free nodes is how the length of a segment changes, not a gap
NEUTRAL = 1e-3  # facets leave 2e-4 with five pressed nodes; a column 0.3 % above its buckling load has as much


class Linearised(NamedTuple):
    """The matrix [[K, -C^T], [-H, -B]] of free degrees of freedom and closed conditions.

    matrix      (CSC)
    free        (2N,) whether a degree of freedom is in it
    conditions  (c,) int32 which condition a further row belongs to; -1 for slip, which friction holds
    """

    matrix: Any
    free: Flags
    conditions: Ints


def unstable(model: Model, mesh: str = "") -> Iterator[RunWarning]:
    """Warn of a present equilibrium that is not stable; `mesh` names a coarser one that stands for the model's."""
    assert isinstance(model, ImplicitModel)  # explicit steps leave such a state by themselves
    leaving = unstable_motions(model)
    if leaving:
        yield RunWarning(
            "unstable-equilibrium", float(leaving), 0.0, "integrator",
            f"the equilibrium at the end{mesh} is unstable: bodies would leave it by buckling or snap-through, and its "
            "forces cannot be measured; give the bodies a small imperfection (a load or a support that leans) "
            "and set integrator.steps, or use implicit-dynamics",
        )  # fmt: skip


def unstable_motions(model: ImplicitModel) -> int:
    """Independent motions that lead away from the equilibrium, at least; 0 if it is stable, or unknown.

    With friction and follower loads the matrix is not symmetric: an odd number is returned as 1, and an even number is
    what an iteration finds.
    Nodes that friction holds or lets slide count as held: a motion found is then unstable all the more without it.
    Motions that only the turning of contact normals makes unstable do not count: each corner of a rigid polygon that
    presses a node has one, however smooth the surface that it stands for.
    """
    if len(np.unique(model.prescribed.dof)) == model.reference.size:
        return 0  # nothing is free to move
    contact = model.contact
    if contact is not None and contact.friction and any(pair.half for pair in contact.pairs):
        return 0  # both half passes hold the same slips: with a row for each there is no inverse
    factors = _factorised(linearised(model))
    leaving = _negative_directions(factors)
    if factors is not None and leaving and contact is not None:
        fixed = _negative_directions(_factorised(linearised(model, normals_turn=False)))
        leaving = min(leaving - _neutral_motions(model, factors, leaving), fixed)
    return leaving


class _Factors(NamedTuple):
    """Factors of equations whose rows and columns are multiplied alike by `scale`, which changes no sign."""

    equations: Linearised
    lu: Any
    matrix: Any
    scale: Floats

    @property
    def free(self) -> int:
        """Number of free degrees of freedom, the first rows."""
        return int(np.count_nonzero(self.equations.free))

    def solve(self, right: Floats) -> Floats:
        """Solve with the matrix that was not scaled for one right-hand side (n,)."""
        return np.asarray(self.scale * self.lu.solve(self.scale * right))


def _factorised(equations: Linearised) -> _Factors | None:
    """Factorise; None if the matrix is singular."""
    scaled, scale = _scaled(equations.matrix)
    try:
        lu = Factor(scaled).lu
    except SingularSystem:
        return None
    return None if (np.abs(lu.U.diagonal()) <= SINGULAR).any() else _Factors(equations, lu, scaled, scale)


def _neutral_motions(model: ImplicitModel, factors: _Factors, leaving: int) -> int:
    """Count the `leaving` motions that only facets make unstable, such as round bodies rolling between smooth plates.

    A motion u is neutral if its stiffness is small compared with the stiffness of forces that turn with it,
    sum(p) |u|^2 / L, L the size of what moves, |u|^2 the mean over its nodes.
    """
    assert model.contact is not None
    soft, shape = _softest(factors, leaving)
    moved = np.zeros((model.reference.size, len(soft)))
    moved[factors.equations.free] = np.abs(shape)
    square = (moved.reshape(-1, 2, len(soft)) ** 2).sum(axis=1)
    square /= square.sum(axis=0)  # (N, m)
    place = model.position.reshape(-1, 2)
    spread = (square * ((place[:, None] - square.T @ place) ** 2).sum(axis=2)).sum(axis=0)
    pressed = np.maximum(model.contact.conditions.force[0], 0.0).sum()
    turning = pressed * (square**2).sum(axis=0) / np.sqrt(spread)
    return int(np.count_nonzero((soft.real < 0.0) & (-NEUTRAL * turning * soft.real > 1.0)))


def _softest(factors: _Factors, number: int) -> tuple[Any, Any]:
    """Softness (m,) [mm/N] of the softest motions of free degrees of freedom, and these motions (n, m), both complex.

    Found by Arnoldi's method (Lehoucq, Sorensen & Yang 1998), with a few motions more than the `number` sought.
    """
    free, right = factors.free, np.zeros(len(factors.scale))

    def moved(force: Floats) -> Floats:
        right[:free] = force.ravel()
        return factors.solve(right)[:free]

    if free < max(DENSE, number + SPARE + 2):
        soft, shape = np.linalg.eig(np.stack([moved(force) for force in np.eye(free)], axis=1))
        return soft, shape
    start = np.random.default_rng(0).standard_normal(free)
    try:
        flexibility = LinearOperator((free, free), matvec=moved, dtype=np.float64)
        soft, shape = eigs(flexibility, number + SPARE, v0=start, tol=ACCURATE)
    except ArpackNoConvergence as error:
        soft, shape = error.eigenvalues, error.eigenvectors
    return soft, shape


def _negative_directions(factors: _Factors | None) -> int:
    """Negative pivots beyond the conditions; by their parity if rows were exchanged, as in a matrix without symmetry.

    Where the parity is even those that leave are counted among the softest motions. 0 of a singular matrix.
    """
    if factors is None:
        return 0
    equations, lu, matrix, _ = factors
    conditions = len(equations.conditions)
    negative = int(np.count_nonzero(lu.U.diagonal() < 0.0))
    # rows exchanged as columns were: signs of pivots are those of eigenvalues
    if np.array_equal(lu.perm_r, lu.perm_c) and abs(matrix - matrix.T).max() <= SYMMETRIC:
        return max(0, negative - conditions)
    if (negative + _parity(lu.perm_r) + _parity(lu.perm_c) + conditions) % 2:
        return 1
    soft, _ = _softest(factors, EVEN)
    stiffest = np.abs(equations.matrix.diagonal()[: factors.free]).max(initial=1e-300)
    leaves = (soft.real * stiffest < -HARD) & (np.abs(soft.imag) < REAL * np.abs(soft))
    return int(np.count_nonzero(leaves))


def linearised(model: ImplicitModel, normals_turn: bool = True) -> Linearised:
    """The equations at the present state; without `normals_turn` for contact normals that stay as they are."""
    free = np.ones(model.reference.size, bool)
    free[model.prescribed.dof] = False
    contact = model.contact
    if contact is not None and contact.conditions.force[0].any() and not contact.conditions.present.any():
        contact.evaluate(model.position)  # a run that was resumed at its end has made no step
    stiffness = model.stiffness(model.state["clock"][2])
    model.add_load_stiffness(model.state.time, stiffness, 1.0, 0.0)
    if contact is None:
        return Linearised(csc_array(stiffness)[free][:, free], free, np.zeros(0, np.int32))
    pressed = np.flatnonzero(contact.conditions.present & (contact.conditions.force[0] > 0.0)).astype(np.int32)
    change = contact.linearise(pressed)
    matrix = (csc_array(stiffness) - change.force if normals_turn else csc_array(stiffness))[free][:, free]
    if not len(pressed):
        return Linearised(matrix, free, pressed)
    directions, gaps = (
        csr_array(vstack([part for part in parts if part is not None]))
        for parts in ((change.normal, change.tangent), (change.gap, change.slip))
    )
    size = abs(gaps).sum(axis=1)
    directions, gaps = directions[:, free], gaps[:, free]
    rubs = np.ones(gaps.shape[0], np.bool_)
    rubs[len(pressed) :] = contact.conditions.bound[:2, pressed[: gaps.shape[0] - len(pressed)]].any(axis=0)
    moving = np.flatnonzero(rubs & (abs(gaps).sum(axis=1) > HELD * size))  # what supports hold alone is no condition
    softness = np.zeros(gaps.shape[0])
    softness[: len(pressed)] = _softness(model)[pressed]
    conditions = np.where(moving < len(pressed), pressed[moving % len(pressed)], -1)
    parts = [[matrix, -directions[moving].T], [-gaps[moving], diags_array(-softness[moving])]]
    return Linearised(block_array(parts, format="csc"), free, conditions)


def _softness(model: ImplicitModel) -> Floats:
    """Change of the gap (k,) [mm/N] by which a force of each condition grows; 0 of exact multipliers."""
    assert model.contact is not None
    conditions, enforcement = model.contact.conditions, model.contact.enforcement
    response = Response.allocate(*conditions.force.shape)
    enforcement.respond(conditions, response)
    by_force, by_gap = response.by_force[0], response.by_gap[0]
    softens = (by_gap != 0.0) & (not enforcement.augments)
    return np.asarray(np.divide(by_force, by_gap, out=np.zeros_like(by_gap), where=softens))


def _scaled(matrix: Any) -> tuple[Any, Floats]:
    """Scale rows and columns alike, so that the diagonal is 1, or where it is 0 the largest entry; return the scale."""
    matrix.sum_duplicates()
    diagonal = np.abs(matrix.diagonal())
    first = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    row, column = matrix.indices, np.repeat(np.arange(len(first)), np.diff(matrix.indptr))
    largest = np.zeros(len(first))
    np.maximum.at(largest, column, np.abs(first[row] * matrix.data * first[column]))
    scale = first / np.where((diagonal == 0.0) & (largest > 0.0), largest, 1.0)
    scaled = matrix.copy()
    scaled.data = scale[row] * matrix.data * scale[column]
    scaled.eliminate_zeros()
    return scaled, scale


def _parity(order: Ints) -> int:
    """0 for an even permutation, 1 for an odd one: its length minus the number of its cycles."""
    n = len(order)
    graph = csc_array((np.ones(n, bool), (order, np.arange(n))), shape=(n, n))
    cycles = connected_components(graph, directed=False, return_labels=False)
    return int(n - cycles) % 2
