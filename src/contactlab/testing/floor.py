"""Rigid floors below single masses: the smallest contact problem for an integrator."""

from __future__ import annotations

from typing import Any

import numpy as np

from contactlab.api import Conditions, ContactDerivatives, Floats, ImplicitEnforcement, Ints, Solve, State


def floor_shapes(nodes: int, friction: bool) -> dict[str, tuple[int, ...]]:
    """Fields of the state that contact needs, for one condition per node."""
    rows = 2 if friction else 1
    return {"contact_force": (nodes, 2), "multipliers": (rows, nodes), "multipliers_before": (nodes,)}


class ExplicitFloor:
    """Exact contact forces for explicit steps. Implements `contactlab.api.ContactEquations`.

    level  (N,) height of the floor below each node [mm]; friction: Coulomb's coefficient, 0 for none
    """

    def __init__(self, level: Floats, friction: float, state: State) -> None:
        self.level, self.friction, self.multipliers = level, friction, state["multipliers"]
        self.slip = np.zeros(len(level))

    def solve(self, predicted: Floats, current: Floats, compliance: Floats, force: Floats) -> Solve:
        """Forces that hold the conditions at the corrected positions, node by node."""
        gap, along = predicted[:, 1] - self.level, predicted[:, 0] - current[:, 0]
        pressed = np.divide(-gap, compliance[:, 1], out=np.zeros_like(gap), where=(gap < 0.0) & (compliance[:, 1] > 0))
        rubbed = np.divide(-along, compliance[:, 0], out=np.zeros_like(gap), where=compliance[:, 0] > 0.0)
        rubbed = np.clip(rubbed, -self.friction * pressed, self.friction * pressed)
        self.slip = along + compliance[:, 0] * rubbed
        self.multipliers[0] = pressed
        self.multipliers[-1] = rubbed if self.friction else pressed
        force[:, 0], force[:, 1] = rubbed, pressed
        return Solve(1, 0.0, 0, float((compliance[:, 1] * pressed).max(initial=0.0)))

    def friction_work(self, mean_velocity: Floats, dt: float, compliance: Floats, force: Floats) -> tuple[float, float]:
        """Work of the last solve's tangential forces; see `contactlab.api.ContactEquations`."""
        return dt * float(force[:, 0] @ mean_velocity[:, 0]), -float(force[:, 0] @ self.slip)


class ImplicitFloor:
    """The same floor for implicit steps. Implements `contactlab.api.ImplicitContact`."""

    by_energy = False
    acts = True

    def __init__(self, level: Floats, friction: float, state: State, enforcement: ImplicitEnforcement) -> None:
        n, slots = len(level), len(level) if friction else 0
        self.level, self.enforcement = level, enforcement
        self.start = np.zeros(n)
        self.conditions = Conditions(
            present=np.ones(n, np.bool_),
            gap=np.zeros(n),
            slip=np.zeros(slots),
            force=state["multipliers"],
            anchor=np.zeros_like(state["multipliers"]),
            measure=np.ones(n),
            size=np.ones(n),
            bound=np.tile([[friction], [0.0], [np.inf]], slots),
            stiffness=np.ones(n),
        )

    def begin_step(self, position: Floats) -> None:
        """Begin a step at `position` (N, 2)."""
        self.start[:] = position[:, 0]
        self.conditions.anchor[:] = self.conditions.force

    def evaluate(self, position: Floats) -> None:
        """Compute gaps and slips at trial positions (N, 2)."""
        self.conditions.gap[:] = position[:, 1] - self.level
        if len(self.conditions.slip):
            self.conditions.slip[:] = position[:, 0] - self.start

    def settled(self) -> bool:
        """Return True: there is no potential."""
        return True

    def dissipation(self) -> float:
        """Return the energy that the slips of the conditions dissipate."""
        c = self.conditions
        return -float(c.force[1] @ c.slip) if len(c.slip) else 0.0

    def friction_along_the_way(self) -> tuple[float, float]:
        """Energy [mJ] of the slips, with no excess over the mean of both ends."""
        return self.dissipation(), 0.0

    def forces(self, normal: Floats, tangential: Floats) -> None:
        """Nodal forces (N, 2) of the trial multipliers; the second (0, 2) without friction."""
        normal[:], tangential[:] = 0.0, 0.0
        normal[:, 1] = self.conditions.force[0]
        if len(tangential):
            tangential[:, 0] = self.conditions.force[1]

    def free_share(self, position: Floats, motion: Floats, depth: float) -> float:
        """All of it: nothing lies behind a floor, and what is below it is seen from anywhere."""
        return 1.0

    def scale(self, flexibility: Floats) -> None:
        """Set stiffnesses of the conditions from flexibilities of single nodes (N, 2) [mm/N]."""
        held = flexibility[:, 1] == 0.0
        self.conditions.stiffness[:] = np.divide(1.0, flexibility[:, 1], out=np.full(len(held), np.inf), where=~held)
        self.conditions.present[:] = ~held

    def linearise(self, chosen: Ints) -> ContactDerivatives:
        """Derivatives of the conditions; directions are constant, as the floor is flat."""
        from scipy.sparse import csr_array

        size, one, rows = 2 * len(self.level), np.ones(len(chosen)), np.arange(len(chosen))
        normal = csr_array((one, (rows, 2 * chosen + 1)), (len(chosen), size))
        tangent = csr_array((one, (rows, 2 * chosen)), (len(chosen), size))
        along = tangent if len(self.conditions.slip) else None
        return ContactDerivatives(normal, along, normal, along, csr_array((size, size)))

    def directions(self, chosen: Ints) -> tuple[Any, Any]:
        """Return directions of the forces, which are constant."""
        found = self.linearise(chosen)
        return found.normal, found.tangent
