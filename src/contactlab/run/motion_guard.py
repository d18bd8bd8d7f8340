"""Stops a run whose nodes have no finite positions, move too fast, or fold cells over."""

from __future__ import annotations

import math

import numpy as np

from contactlab.api import Floats
from contactlab.errors import NotFiniteError
from contactlab.kernels.checks import smallest_jacobian
from contactlab.model.bodies.body import BodyForces
from contactlab.model.model import Model
from contactlab.run.stopping import node_name, stop, sudden_motion


class MotionGuard:
    """Checks velocities, displacements, forces and cells of one run.

    input_speed  [mm/s] fastest motion that the scene puts in so far
    wave_speed   [mm/s] of the fastest law
    """

    def __init__(self, model: Model, shorter: str) -> None:
        self.model, self.shorter = model, shorter
        speeds = np.hypot(*model.state["velocity"].T) if "velocity" in model.state else np.zeros(1)
        self.input_speed = float(speeds.max(initial=0.0))
        self.driven = model.prescribed.dof  # by component: a node held in one is free in the other
        self.wave_speed = max(body.material.wave_speeds()[0] for body in model.bodies)
        self.derivatives = [_derivatives(forces) for forces in model.forces]

    def check_finite(self) -> None:
        """Raise NotFiniteError at the first node whose velocity, displacement or force is not finite."""
        state = self.model.state
        for name in ("velocity", "displacement", "internal_force"):
            if name not in state or math.isfinite(state[name].sum()):
                continue
            values = state[name]
            bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
            if len(bad):
                raise NotFiniteError(
                    "diverged",
                    f"step {state.step}: {node_name(self.model, int(bad[0]))} has the {name.replace('_', ' ')} "
                    f"({values[bad[0], 0]:g}, {values[bad[0], 1]:g}), the first of {len(bad)} nodes where it is not "
                    f"finite; {sudden_motion(self.model) or f'try {self.shorter}, and check the material there'}",
                )

    def check_speed(self) -> None:
        """Stop if a node moves faster than sound and ten times as fast as any prescribed motion."""
        if "velocity" not in self.model.state:
            return
        velocity = self.model.state["velocity"]
        speed = np.hypot(*velocity.T)
        # prescribed motions of supports and rigid surfaces count
        told = float(np.abs(velocity.ravel()[self.driven]).max(initial=0.0))
        self.input_speed = max(self.input_speed, told)
        limit = max(10.0 * self.input_speed, self.wave_speed)
        worst = int(np.argmax(speed))
        if not speed[worst] <= limit:
            stop(
                self.model,
                f"{node_name(self.model, worst)} moves at {speed[worst]:.3g} (limit {limit:.3g}, ten times the fastest "
                "input, or the speed of sound)",
                f"the step is too long or contact forces are unbounded: try {self.shorter}",
            )

    def check_cells(self) -> None:
        """Stop if a cell is inverted: det F is not positive at one of its points."""
        for forces, derivatives in zip(self.model.forces, self.derivatives, strict=True):
            begin = 0
            for block in forces.blocks:
                jacobian, cell, point = smallest_jacobian(forces.geometry, block.connectivity, derivatives)
                if not jacobian > 0.0:
                    own = block.connectivity[:, cell : cell + 1]
                    undeformed = smallest_jacobian(self.model.reference, own, derivatives[point : point + 1])[0]
                    stop(
                        self.model,
                        f"cell {begin + cell} of body {forces.body.name} is inverted, det F = "
                        f"{jacobian / undeformed:.3g}",
                        "try a finer mesh there, a slower load or the other side as slave",
                    )
                begin += block.connectivity.shape[1]


def _derivatives(forces: BodyForces) -> Floats:
    """Derivatives (q, a, 2) of the shape functions of a body's element at its quadrature points."""
    element = forces.body.element
    return np.ascontiguousarray(element.shape(element.quadrature().points).gradient)
