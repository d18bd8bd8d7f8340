"""Points to try a material on: gradients of the kind that its `kinematics` needs, and histories that occurred."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats, Material
from contactlab.testing.scales import scale_of

DT = 1e-6  # s; a law of rate form sees it, its stress over a step must not depend on it alone

YIELDING = 0.08  # of the steps that made a history: usual laws have yielded by then

NEEDED = {"x": 0.3, "y": 0.7, "time": 1e-3, "cell_size": 0.2}
FIELD = 0.01
"""Needs of laws, in mm and s, and any field of the scene."""

IDENTITY = np.array([[1.0], [0.0], [0.0], [1.0]])


def at_rest(law: Material, count: int) -> Floats:
    """The gradient (4, P) of an undeformed body: identity for "finite", else zero."""
    return np.repeat(IDENTITY if law.kinematics == "finite" else 0.0 * IDENTITY, count, axis=1)


def gradients(law: Material, count: int, size: float, seed: int = 1) -> Floats:
    """Random gradients (4, P) at most `size` away from rest in each component."""
    return at_rest(law, count) + np.random.default_rng(seed).uniform(-size, size, (4, count))


def no_history(law: Material, count: int) -> Floats:
    """The history (h, P) at the start, and what the law needs, the same at all points."""
    history = np.zeros((law.history_size, count))
    for row, name in list(enumerate(law.history_names))[law.own_history() :]:
        history[row] = NEEDED.get(name, FIELD)
    return history


def some_history(law: Material, count: int) -> Floats:
    """A history (h, P) that the law itself made in three random steps."""
    history = no_history(law, count)
    for seed in range(3):
        _, history = respond(law, gradients(law, count, YIELDING, 100 + seed), history)
    return history


def usual_step(law: Material) -> float:
    """Length [s] of steps in which the law acts: its own time, if it declares one."""
    return scale_of(law, "time_scale", DT)


def elastic_step(law: Material) -> float:
    """Length [s] of steps in which nothing flows or relaxes."""
    return 0.0 if law.rate_dependent else DT


def respond(law: Material, gradient: Floats, history: Floats, dt: float | None = None) -> tuple[Floats, Floats]:
    """Compute stress (4, P) and new history (h, P) after a step of the usual length, or of `dt`."""
    stress, new = np.full((4, gradient.shape[1]), np.nan), np.full_like(history, np.nan)
    dt = usual_step(law) if dt is None else dt
    own = law.own_history()
    new[own:] = history[own:]
    law.stress(np.ascontiguousarray(gradient), np.ascontiguousarray(history), dt, stress, new)
    return stress, new


def matrices(rows: Floats) -> Floats:
    """Gradient rows xx, xy, yx, yy (4, P) as matrices (P, 2, 2)."""
    return np.ascontiguousarray(rows.T).reshape(-1, 2, 2)


def rows_of(matrix: Floats) -> Floats:
    """Matrices (P, 2, 2) as gradient rows (4, P)."""
    return np.ascontiguousarray(matrix.reshape(-1, 4).T)


def tensors(stress: Floats) -> Floats:
    """Stress rows xx, yy, zz, xy (4, P) as in-plane matrices (P, 2, 2)."""
    xx, yy, _, xy = stress
    return np.stack([xx, xy, xy, yy], axis=-1).reshape(-1, 2, 2)


def deformation(law: Material, gradient: Floats) -> Floats:
    """F (P, 2, 2) for "finite", du/dX for "small"."""
    return np.asarray(np.linalg.inv(matrices(gradient))) if law.kinematics == "finite" else matrices(gradient)


def conjugate(law: Material, gradient: Floats, stress: Floats) -> Floats:
    """First Piola stress P = J sigma F^-T (P, 2, 2) for "finite", sigma for "small"."""
    if law.kinematics == "small":
        return tensors(stress)
    inverse = matrices(gradient)
    return np.asarray((tensors(stress) @ inverse.transpose(0, 2, 1)) / np.linalg.det(inverse)[:, None, None])


def stress_of_work(law: Material, gradient: Floats) -> Floats:
    """Stress conjugate to F for "finite" laws, and to the strain for "small" laws, reached from rest."""
    return conjugate(law, gradient, respond(law, gradient, no_history(law, gradient.shape[1]), elastic_step(law))[0])


def rotations(count: int, seed: int = 5) -> Floats:
    """Rotation matrices (P, 2, 2) by any angle."""
    angle = np.random.default_rng(seed).uniform(-np.pi, np.pi, count)
    return np.stack([np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)], axis=-1).reshape(-1, 2, 2)


def modulus(law: Material) -> float:
    """Modulus density c_p^2 [MPa], by which stresses are scaled."""
    return float(law.density * law.wave_speeds()[0] ** 2)
