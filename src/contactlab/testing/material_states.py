"""Checks of materials beyond single stresses: isotropy, plane strain, work along a path, parallel blocks."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np

from contactlab.api import Floats, Material
from contactlab.testing import points
from contactlab.testing.assertions import Check, NotApplicable, agree, identical, require

POINTS, STRAIN = 40, 0.1


def _isotropic(law: Material) -> Material:
    if not law.isotropic:
        raise NotApplicable("the law has directions of its own: isotropic is False")
    return law


def isotropy(law: Material) -> None:
    """A body that is turned before it is strained has the same stress, in the plane and across it."""
    _isotropic(law)
    size = {"finite": STRAIN, "small": 0.01, "rate": 0.002}[law.kinematics]
    gradient, turn = points.matrices(points.gradients(law, POINTS, size)), points.rotations(POINTS)
    back = turn.transpose(0, 2, 1)
    if law.kinematics == "rate":  # without spin, which turns the stress as well
        gradient = 0.5 * (gradient + gradient.transpose(0, 2, 1))
    stress, _ = points.respond(law, points.rows_of(gradient), points.no_history(law, POINTS))
    if law.kinematics == "finite":  # X -> Q X: dX/dx becomes Q dX/dx
        turned, _ = points.respond(law, points.rows_of(turn @ gradient), points.no_history(law, POINTS))
        expected = points.tensors(stress)
    else:
        turned, _ = points.respond(law, points.rows_of(turn @ gradient @ back), points.no_history(law, POINTS))
        expected = turn @ points.tensors(stress) @ back
    within = 1e-12 * points.modulus(law)
    agree(points.tensors(turned), expected, within, "stress of a body that was turned before it was strained")
    agree(turned[2], stress[2], within, "stress across the plane of such a body")


def plane_strain(law: Material) -> None:
    """Across the plane a small strain is resisted by Lame's constant, as along the other axis: strain there is zero."""
    _isotropic(law)
    if law.needs:
        raise NotApplicable("assumes the same moduli at all places and times: the law declares needs")
    dilatational, shear = (law.density * c * c for c in law.wave_speeds())
    lame, size, strain = dilatational - 2.0 * shear, 1e-7, np.zeros((4, 2))
    strain[[0, 3], [0, 1]] = size
    sign = -1.0 if law.kinematics == "finite" else 1.0  # finite laws are given F^-1
    none, dt = points.no_history(law, 2), points.elastic_step(law)
    stress, _ = points.respond(law, points.at_rest(law, 2) + sign * strain, none, dt)
    if not law.stress_free:
        # differences of stresses leave their round-off over the strain, below what is of second order
        stress -= points.respond(law, points.at_rest(law, 2), none, dt)[0]
    # what is of second order in the strain
    within = 1e-5 * dilatational
    agree(stress[2] / size, [lame, lame], within, "stress across the plane over a strain along x and along y")
    agree(stress[[1, 0], [0, 1]] / size, [lame, lame], within, "stress along the other axis over that strain")


def across_is_across(law: Material) -> None:
    """Stresses along y and across the plane are equal under a strain along x that is held for some steps."""
    _isotropic(law)
    gradient, history = points.at_rest(law, 1), points.no_history(law, 1)
    gradient[0] += -0.02 if law.kinematics == "finite" else 0.02
    for step in range(4):
        stress, history = points.respond(law, gradient, history)
        within = 1e-9 * max(points.modulus(law), float(np.abs(stress).max()))
        agree(stress[2], stress[1], within, f"stress across the plane and along y, step {step + 1}, strained along x")
        if law.kinematics == "rate":
            gradient = points.at_rest(law, 1)


def work_is_stored_or_dissipated(law: Material) -> None:
    """The work of the stresses along a path of many small steps is the stored plus the dissipated energy."""
    if not law.has_energy:
        raise NotApplicable("the law declares no stored energy")
    if law.kinematics == "rate":
        raise NotApplicable("the energy of a rate law is not a function of the gradient")
    if not law.stress_free:
        raise NotApplicable("assumes that nothing is stored at rest: stress_free is False")
    # of laws with a time of their own: quicker than it, about as long, and longer
    for time in [2.0, 20.0] if law.time_scale else [0.0]:
        _work_along_a_path(law, time * points.usual_step(law))


def _work_along_a_path(law: Material, time: float) -> None:
    """The same for a path that takes so long [s]; 0 for laws without a time of their own."""
    steps, count = 800, 8
    way = points.gradients(law, count, 0.12, seed=6) - points.at_rest(law, count)
    history, work, before, least = points.no_history(law, count), np.zeros(count), None, np.zeros(count)
    for step in range(steps + 1):
        gradient = points.at_rest(law, count) + way * np.sin(1.5 * np.pi * step / steps)
        stress, history = points.respond(law, gradient, history, time / steps if time else None)
        now = points.deformation(law, gradient), points.conjugate(law, gradient, stress)
        if before is not None:
            work += 0.5 * ((now[1] + before[1]) * (now[0] - before[0])).sum(axis=(1, 2))
        before = now
        if step % 40 == 0:
            lost, volume = np.full(count, np.nan), np.ones(count)
            law.dissipation(gradient, history, lost)
            if law.kinematics == "finite":
                volume = np.linalg.det(points.deformation(law, gradient))
            back = float((least - lost * volume).max())
            text = f"dissipation falls by {back:.3e} mJ/mm3 along a path, allowed: no decrease"
            require(back <= 1e-9 * float(np.abs(least).max()) or back <= 0.0, text)
            least = lost * volume
    stored = np.full(count, np.nan)
    law.energy(gradient, history, stored)
    # trapezoidal work: an error of the square of a step, and of a step where yielding begins
    agree((stored + lost) * volume / work, np.ones(count), 0.01, "what is stored and dissipated over the work")


def arrays_change_in_place(law: Material) -> None:
    """Runs change gradients in place: the stress follows their present values."""
    gradient, history = points.gradients(law, POINTS, STRAIN), points.some_history(law, POINTS)
    expected = points.respond(law, gradient, history)
    moving, stress, new = points.at_rest(law, POINTS) + 0.0, np.empty((4, POINTS)), history.copy()
    law.stress(moving, history, points.usual_step(law), stress, new)
    moving[:] = gradient
    law.stress(moving, history, points.usual_step(law), stress, new)
    identical(stress, expected[0], "stress after the gradient has changed in place")
    identical(new, expected[1], "history after the gradient has changed in place")


def threads_do_not_disturb_each_other(law: Material) -> None:
    """Blocks processed in parallel give the same bits as alone."""
    blocks = [(points.gradients(law, 500, STRAIN, seed), points.some_history(law, 500)) for seed in range(4)]
    alone = [points.respond(law, *block) for block in blocks]

    def beside(number: int) -> tuple[Floats, Floats]:
        return points.respond(law, *blocks[number % 4])

    with ThreadPoolExecutor(4) as pool:
        for number, (stress, history) in enumerate(pool.map(beside, range(16))):
            identical(stress, alone[number % 4][0], "stress of a block in parallel with others")
            identical(history, alone[number % 4][1], "history of a block in parallel with others")


CHECKS: tuple[Check, ...] = (
    isotropy,
    plane_strain,
    across_is_across,
    work_is_stored_or_dissipated,
    arrays_change_in_place,
    threads_do_not_disturb_each_other,
)
