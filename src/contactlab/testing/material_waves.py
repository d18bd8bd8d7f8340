"""Wave speeds at strained points, compared with the bound of the material."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats, Material
from contactlab.api.differences import tangent_by_differences
from contactlab.model.bodies.straight_path import StraightPath
from contactlab.testing import points
from contactlab.testing.assertions import Check, NotApplicable, require

DIRECTIONS = 24  # of waves within half a turn
ERROR = 1e-6  # of differences, as part of a modulus

MOTIONS = 16  # directions in which particles move, within half a turn: one lies within 1 % of the fastest
PUSH, ONE_SIDED = 1e-6, 1e-4  # size of a step to one side, and what that leaves of second order, as part of a modulus


def stiffening_bounds_the_waves(law: Material) -> None:
    """No wave in a strained or stressed point is faster than `stiffening` gives, or explicit steps are too long."""
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
        raise NotApplicable("waves of small strains do not differ from waves at rest")
    if law.kinematics == "finite" and law.own_history():
        return *_loaded(law), ONE_SIDED
    gradient, stress, moduli = _strained(law) if law.kinematics == "finite" else _stressed(law)
    # the largest eigenvalue (P,) of the acoustic tensors of all directions
    normals = _directions(DIRECTIONS)
    acoustic = np.einsum("pijkl,nj,nl->npik", moduli, normals, normals)
    largest = np.linalg.eigvalsh(0.5 * (acoustic + acoustic.transpose(0, 1, 3, 2)))[..., -1]
    return gradient, stress, np.asarray(largest.max(axis=0)), ERROR


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


POINTS, STRAIN = 40, 0.06
STEPS = 8.0  # usual steps that the path takes
COARSE, FINE, EXACT = 8, 16, 128  # steps
ORDER = 1.6  # at least; first order gives 1


def flow_is_of_second_order(law: Material) -> None:
    """A law that declares `implicit_euler` follows a path that turns with an error of second order in its steps.

    It is called as in load steps, at points between start and end of each, from extrapolated histories.
    """
    if not law.implicit_euler:
        raise NotApplicable("the law does not say that its history advances by implicit Euler steps")
    require(law.kinematics != "rate", 'implicit_euler: a law of "rate" kinematics sees no whole deformation')
    require(law.history_size > 0, "implicit_euler: the law has no history")
    exact = _follow(law, EXACT)
    coarse, fine = (float(np.sqrt(((_follow(law, steps) - exact) ** 2).mean())) for steps in (COARSE, FINE))
    order = float(np.log2(coarse / fine)) if fine > 0.0 else np.inf
    require(
        order > ORDER or coarse < 1e-9 * points.modulus(law),
        f"stress after {COARSE} and {FINE} steps differs from that after {EXACT} by {coarse:.2e} and {fine:.2e}: order "
        f"{order:.2f}, at least {ORDER} with implicit Euler steps of a history that does not turn with the body",
    )


def _follow(law: Material, steps: int) -> Floats:
    """Stress (4, P) at the end of the path."""
    path, history = StraightPath(law), points.no_history(law, POINTS)
    stress, new = np.empty((4, POINTS)), np.empty_like(history)
    for number in range(steps):
        path.start = _gradient(law, number / steps)
        path.stress(_gradient(law, (number + 1) / steps), history, STEPS * points.usual_step(law) / steps, stress, new)
        history[:] = new
    return stress


def _gradient(law: Material, time: float) -> Floats:
    """Random deformations that begin along one direction, and turn into another; 0 <= time <= 1."""
    random = np.random.default_rng(3)
    first, second = (random.uniform(-STRAIN, STRAIN, (4, POINTS)) for _ in range(2))
    moved: Floats = np.sin(2.0 * time) * first + (1.0 - np.cos(2.0 * time)) * second
    if law.kinematics == "small":
        return moved
    return points.rows_of(np.asarray(np.linalg.inv(np.eye(2) + points.matrices(moved)), np.float64))


CHECKS: tuple[Check, ...] = (flow_is_of_second_order,)
