"""Check of materials whose history advances by implicit Euler steps: load steps integrate them to second order."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats, Material
from contactlab.model.bodies.straight_path import StraightPath
from contactlab.testing import points
from contactlab.testing.assertions import Check, NotApplicable, require

POINTS, STRAIN = 40, 0.06
STEPS = 8.0  # usual steps that the path takes
COARSE, FINE, EXACT = 8, 16, 128  # steps
ORDER = 1.6  # at least; first order gives 1


def flow_is_of_second_order(law: Material) -> None:
    """A law that declares `implicit_euler` follows a path that turns with an error of second order in its steps.

    It is asked as load steps ask it, at points between start and end of each, from extrapolated histories.
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
