"""Gap rows without geometry, and their direct solution."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import nnls

from contactlab.api import Enforcement, ExplicitEnforcement, Floats, Rows, Solve
from contactlab.testing.assertions import NotApplicable


def rows_from(
    normal: Floats,
    gap: ArrayLike,
    *,
    tangent: Floats | None = None,
    slip: ArrayLike | None = None,
    coefficient: ArrayLike = 0.0,
    adhesion: ArrayLike = 0.0,
    cap: ArrayLike = 0.0,
    measure: ArrayLike = 1.0,
    slots: ArrayLike | None = None,
) -> Rows:
    """Rows with dense weights `normal` (k, N, 2), at most one entry per node and row; zero weights are left out."""
    k = len(normal)
    used = [np.flatnonzero(np.any(row != 0.0, axis=1)) for row in normal]
    start = np.concatenate([[0], np.cumsum([len(u) for u in used])]).astype(np.int32)
    node = np.concatenate([np.zeros(0, int), *used]).astype(np.int32)
    row = np.repeat(np.arange(k), np.diff(start))
    rubs = tangent is not None
    bound = np.zeros((3, k if rubs else 0))
    bound[0], bound[1], bound[2] = coefficient, adhesion, cap
    return Rows(
        count=k,
        start=start,
        node=node,
        normal_weight=np.ascontiguousarray(normal[row, node]).reshape(-1, 2),
        tangent_weight=np.ascontiguousarray(tangent[row, node]) if tangent is not None else np.zeros((0, 2)),
        gap=np.array(gap, float),
        slip=np.array(slip, float) if slip is not None else np.zeros(0),
        measure=np.broadcast_to(measure, k).astype(float),
        size=np.ones(k),
        slot=np.arange(k, dtype=np.int32) if slots is None else np.asarray(slots, np.int32),
        offset=np.zeros(k),
        bound=bound,
        work=np.zeros((4, k)),
    )


def coupled_normals(count: int, seed: int) -> Floats:
    """Weights (k, k + 3, 2): each row mostly its own node, and three random others that rows share."""
    rng = np.random.default_rng(seed)
    weights = np.zeros((count, count + 3, 2))
    for k in range(count):
        others = rng.choice([n for n in range(count + 3) if n != k], 3, replace=False)
        angle = rng.uniform(0.0, 2.0 * np.pi)
        weights[k, k] = np.cos(angle), np.sin(angle)
        weights[k, others] = 0.3 * rng.normal(size=(3, 2))
    return weights


def turned(normal: Floats) -> Floats:
    """Tangent weights of normal ones: turned by -90 degrees."""
    return np.stack([normal[..., 1], -normal[..., 0]], axis=-1)


def operator(weights: Floats, compliance: Floats) -> Floats:
    """The contact operator A = G C G^T (k, k)."""
    flat = weights.reshape(len(weights), -1)
    return np.asarray((flat * compliance.ravel()) @ flat.T)


def direct_forces(matrix: Floats, gap: Floats) -> Floats:
    """y >= 0 with A y + gap >= 0 and y (A y + gap) = 0, by the active sets of Lawson & Hanson (1974).

    With A = L L^T these are the optimality conditions of min |L^T y + L^-1 gap| over y >= 0.
    """
    factor = np.linalg.cholesky(matrix)
    return np.asarray(nnls(factor.T, -np.linalg.solve(factor, gap), maxiter=50 * len(gap))[0])


def solved(
    enforcement: Enforcement, rows: Rows, compliance: Floats, multipliers: Floats, force: Floats | None = None
) -> tuple[Solve, Floats]:
    """The result of an enforcement and the forces (N, 2); multipliers are left in their array."""
    if not isinstance(enforcement, ExplicitEnforcement):
        raise NotApplicable("the enforcement is not for explicit integrators")
    out = np.full(compliance.shape, 7.0) if force is None else force  # garbage that has to be overwritten
    done: Any = enforcement.solve(rows, compliance, multipliers, out)
    return done, out
