"""Wave speeds at strained points, compared with the bound of the material."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats, Material
from contactlab.api.differences import tangent_by_differences
from contactlab.testing import points
from contactlab.testing.assertions import NotApplicable, require

DIRECTIONS = 24  # of waves within half a turn
ERROR = 1e-6  # of differences, as part of a modulus

MOTIONS = 16  # directions in which particles move, within half a turn: one lies within 1 % of the fastest
PUSH, ONE_SIDED = 1e-6, 1e-4  # size of a step to one side, and what that leaves of second order, as part of a modulus


def stiffening_bounds_the_waves(law: Material) -> None:
    """No wave in a strained or stressed point is faster than `stiffening` says, or explicit steps would be too long."""
    gradient, stress, fastest, error = _waves(law)
    bound = np.full(len(fastest), np.nan)
    law.stiffening(gradient, stress, bound)
    fastest = fastest / points.modulus(law)
    allowed = bound * (1.0 + error)
    worst = int(np.argmax(fastest / allowed))
    seen = f"{fastest[worst]:.4f} of the modulus at rest"
    where = f"gradient {gradient[:, worst].round(3).tolist()} and stress {stress[:, worst].round(1).tolist()}"
    require(
        np.all(fastest <= allowed),
        f"stiffening: a wave has {seen} at {where}, the bound is {bound[worst]:.4f}",
    )


def _waves(law: Material) -> tuple[Floats, Floats, Floats, float]:
    """Gradients (4, P), stresses (4, P), the modulus (P,) of the fastest wave found there, and its error."""
    if law.kinematics == "small":
        raise NotApplicable("waves of a small strain are those at rest")
    if law.kinematics == "finite" and law.history_size:
        return *_loaded(law), ONE_SIDED
    gradient, stress, moduli = _strained(law) if law.kinematics == "finite" else _stressed(law)
    return gradient, stress, _fastest(moduli), ERROR


def _loaded(law: Material) -> tuple[Floats, Floats, Floats]:
    """The same for finite laws with a history, in states that they have reached, half of them a little unloaded.

    A wave along n whose particles move along u by e makes F' = (1 + e u n^T) F, and sees (sigma' - sigma) n on its
    plane. On a yield surface loading and unloading waves differ, so each sign of e counts for itself; what any one
    of them feels along its own motion is no more than the largest eigenvalue of its acoustic tensor.
    """
    count = 200
    reached, history = points.gradients(law, count, 0.3, seed=8), points.some_history(law, count)
    _, history = points.respond(law, reached, history)
    gradient = reached + np.random.default_rng(9).uniform(-0.001, 0.001, (4, count)) * (np.arange(count) % 2)
    stress, _ = points.respond(law, gradient, history)
    inverse, sigma, fastest = points.matrices(gradient), points.tensors(stress), np.full(count, -np.inf)
    for n in _directions(DIRECTIONS):
        for u in _directions(MOTIONS):
            for e in (PUSH, -PUSH):
                back = np.eye(2) - e * np.outer(u, n) / (1.0 + e * u @ n)  # (1 + e u n^T)^-1
                moved, _ = points.respond(law, points.rows_of(inverse @ back), history)
                felt = np.einsum("i,pij,j->p", u, points.tensors(moved) - sigma, n) / e
                np.maximum(fastest, felt, out=fastest)
    return gradient, stress, fastest


def _directions(count: int) -> Floats:
    """Unit vectors (count, 2) within half a turn."""
    angles = np.linspace(0.0, np.pi, count, endpoint=False)
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _strained(law: Material) -> tuple[Floats, Floats, Floats]:
    """Gradients (4, P), stresses (4, P) and spatial moduli (P, 2, 2, 2, 2) over J, from the stress for each of them."""
    gradient, step = points.gradients(law, 200, 0.3, seed=8), 1e-5
    stress, _ = points.respond(law, gradient, points.no_history(law, 200))
    base = points.deformation(law, gradient)
    derivative = np.empty((len(base), 2, 2, 2, 2))
    for k in range(2):
        for m in range(2):
            shift = np.zeros((2, 2))
            shift[k, m] = step
            sides = (points.rows_of(np.asarray(np.linalg.inv(base + sign * shift))) for sign in (1.0, -1.0))
            high, low = (points.stress_of_work(law, side) for side in sides)
            derivative[:, :, :, k, m] = (high - low) / (2.0 * step)
    # fixed mass on the current geometry
    spatial = np.einsum("pjJ,plL,piJkL->pijkl", base, base, derivative) / np.linalg.det(base)[:, None, None, None, None]
    return gradient, stress, spatial


def _stressed(law: Material) -> tuple[Floats, Floats, Floats]:
    """The same for steps without strain from stresses that the law has reached.

    The nominal stress of a motion from the present state changes by d(sigma) + tr(d) sigma - sigma grad(v)^T.
    """
    history, rest = points.some_history(law, 200), points.at_rest(law, 200)
    stress, _ = points.respond(law, rest, history)
    tangent = np.empty((4, 4, 200))
    tangent_by_differences(law, rest, history, points.DT, tangent)
    rows = tangent[[0, 3, 3, 1]].reshape(2, 2, 2, 2, 200)
    sigma, unit = points.tensors(stress), np.eye(2)
    carried = np.einsum("pij,kl->pijkl", sigma, unit) - np.einsum("pil,jk->pijkl", sigma, unit)
    return rest, stress, np.moveaxis(rows, -1, 0) + carried


def _fastest(moduli: Floats) -> Floats:
    """Largest eigenvalue (P,) of the acoustic tensors of all directions."""
    normals = _directions(DIRECTIONS)
    acoustic = np.einsum("pijkl,nj,nl->npik", moduli, normals, normals)
    largest = np.linalg.eigvalsh(0.5 * (acoustic + acoustic.transpose(0, 1, 3, 2)))[..., -1]
    return np.asarray(largest.max(axis=0))
