"""One node on an obstacle with coupled stiffness: more than one equilibrium where friction is strong (Klarbring)."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest
from contactlab_statics.active_set import ActiveSet
from scipy.sparse import csc_array, csr_array

from contactlab.api import Conditions, ContactDerivatives, Floats, Ints, State
from contactlab.implicit.iteration import NewtonIteration
from contactlab.testing.oscillator import Ramp

STIFFNESS = np.array([[1.0, 0.5], [0.5, 1.0]])  # tangential, normal
LOAD = np.array([[2.8, 1.0]])
SOLUTIONS = {"stick": (0.0, 0.0), "slip": (0.4, 0.0), "open": (3.0 + 1.0 / 15.0, -0.5 - 1.0 / 30.0)}
"""u_t, u_n with mu = 3. Slip: (k_tt - mu k_tn) u_t = f_t - mu f_n; open: K u = f."""


class Obstacle:
    """u_n <= 0; slip is counted from u_t = 0."""

    def __init__(self, mu: float, multipliers: Floats) -> None:
        self.enforcement = ActiveSet()
        one = np.ones(1)
        self.conditions = Conditions(
            present=np.ones(1, np.bool_),
            gap=np.zeros(1),
            slip=np.zeros(1),
            force=multipliers,
            anchor=np.zeros((2, 1)),
            measure=one,
            size=one,
            bound=np.array([[mu], [0.0], [np.inf]]),
            stiffness=one.copy(),
        )

    by_energy = False
    acts = False

    def settled(self) -> bool:
        return True

    def evaluate(self, position: Floats) -> None:
        self.conditions.gap[0], self.conditions.slip[0] = -position[0, 1], position[0, 0]

    def forces(self, normal: Floats, tangential: Floats) -> None:
        normal[0], tangential[0] = (0.0, -self.conditions.force[0, 0]), (self.conditions.force[1, 0], 0.0)

    def free_share(self, position: Floats, motion: Floats, depth: float) -> float:
        """All of it: conditions see surfaces from anywhere."""
        return 1.0

    def scale(self, flexibility: Floats) -> None:
        self.conditions.stiffness[:] = 1.0 / flexibility[0, 1]

    def linearise(self, chosen: Ints) -> ContactDerivatives:
        normal, tangent = (csr_array(np.array([row])[: len(chosen)]) for row in ([0.0, -1.0], [1.0, 0.0]))
        return ContactDerivatives(normal, tangent, normal, tangent, csr_array((2, 2)))


class OneNode:
    """Implements what the iteration sees of a model, and its balance."""

    def __init__(self, mu: float, start: tuple[float, float]) -> None:
        self.state = State({"displacement": (1, 2), "internal_force": (1, 2), "multipliers": (2, 1)})
        self.state["displacement"][0] = start
        self.reference, self.position = np.zeros((1, 2)), np.zeros((1, 2))
        self.prescribed = Ramp(np.zeros(0, np.int32), np.zeros(0))
        self.contact = Obstacle(mu, self.state["multipliers"])
        self.normal, self.tangential = np.zeros((1, 2)), np.zeros((1, 2))

    def of_stresses(self, diagonal: Floats) -> Floats:
        return diagonal

    def internal_force(self, dt: float) -> None:
        self.position[:] = self.state["displacement"]
        self.state["internal_force"][:] = self.state["displacement"] @ STIFFNESS

    def update_stresses(self, dt: float) -> None:
        self.internal_force(dt)

    def estimate(self, time: float) -> None:
        """Nothing is known of where a step ends."""

    def iterated(self) -> None:
        """Nobody records it."""

    def folded(self) -> bool:
        return False

    def unbalanced(self, out: Floats) -> tuple[Floats, ...]:
        self.contact.forces(self.normal, self.tangential)
        out[:] = LOAD - self.state["internal_force"] + self.normal + self.tangential
        return LOAD, self.state["internal_force"], self.normal

    def stiffness(self, dt: float) -> Any:
        return csc_array(STIFFNESS)


def solve(mu: float, start: tuple[float, float]) -> tuple[str, tuple[float, float]]:
    """Reason of failure, and the displacement where the iteration ends."""
    model = OneNode(mu, start)
    equations: Any = model
    outcome = NewtonIteration(equations, model.state, equations, 1e-12, 50).run(1.0, np.zeros(0))
    u = model.state["displacement"][0]
    return outcome.reason, (float(u[0]), float(u[1]))


# within the segment length of 1 that a correction may push through the obstacle
STARTS = list(product((-2.0, -0.3, 0.0, 0.5, 3.0), (-1.0, -0.1, 0.0, 0.4)))


def test_strong_friction_ends_at_one_of_three_equilibria() -> None:
    """mu = 3 > k_tt/|k_tn|: from each start one of the three, to round-off; more than one of them is seen."""
    seen = set()
    for start in STARTS:
        reason, u = solve(3.0, start)
        assert not reason, (start, reason)
        names = [name for name, exact in SOLUTIONS.items() if np.allclose(u, exact, rtol=0.0, atol=1e-12)]
        assert len(names) == 1, (start, u)
        seen |= set(names)
    assert len(seen) >= 2


@pytest.mark.parametrize("start", STARTS, ids=str)
def test_moderate_friction_has_one_equilibrium(start: tuple[float, float]) -> None:
    """mu = 1.5: slip with u_t = (f_t - mu f_n)/(k_tt - mu k_tn) = 1.3/0.25 would lift it off: it is open."""
    reason, u = solve(1.5, start)
    assert not reason
    assert u == pytest.approx(SOLUTIONS["open"], abs=1e-12)
