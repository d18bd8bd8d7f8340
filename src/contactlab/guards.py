"""Divergence detectors: they stop a run with the place, the value and what to try."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from contactlab.api import Floats, Step
from contactlab.errors import SimulationFailure
from contactlab.model.model import Model

EVERY = 50  # steps between looks at the whole model
LOOSE = 1e-6  # natural residual of a contact solve that counts as not converged
PATIENCE = 50  # consecutive steps with a loose residual before the run is stopped


class Guards:
    """Watches one run. `after_step` is called every step, `look` every `EVERY` steps."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.loose = 0
        speeds = np.hypot(*model.state["velocity"].T) if "velocity" in model.state else np.zeros(1)
        self.input_speed = float(speeds.max(initial=0.0))
        self.wave_speed = max(body.material.wave_speeds()[0] for body in model.bodies)
        self.pairs = model.contact.pairs if model.contact is not None else ()

    def memory(self) -> dict[str, Floats]:
        """Everything that changes while the run goes on."""
        return {"guards": np.array([self.loose, self.input_speed])}

    def restore(self, memory: Mapping[str, Floats]) -> None:
        """Back to where `memory` was taken."""
        self.loose, self.input_speed = int(memory["guards"][0]), float(memory["guards"][1])

    def after_step(self, step: Step) -> None:
        """Count steps whose contact solve did not converge."""
        self.loose = self.loose + 1 if step.residual > LOOSE else 0
        if self.loose >= PATIENCE:
            raise SimulationFailure(
                "not-converged",
                f"step {self.model.state.step}: the contact solve left a residual of {step.residual:.1e} segment "
                f"lengths in {PATIENCE} consecutive steps; make the lighter or finer side the slave, or allow "
                "more sweeps",
            )

    def look(self) -> None:
        """Raise SimulationFailure("diverged") at the first sign that the numbers mean nothing any more."""
        self._finite()
        self._speed()
        self._folded()
        self._penetration()

    def _stop(self, what: str, hint: str) -> None:
        raise SimulationFailure("diverged", f"step {self.model.state.step}: {what}; {hint}")

    def _body_of(self, node: int) -> str:
        for body in self.model.bodies:
            if body.first <= node < body.first + body.count:
                return f"node {node - body.first} of body {body.name}"
        return f"node {node}"

    def _finite(self) -> None:
        u = self.model.state["displacement"]
        bad = np.flatnonzero(~np.isfinite(u).all(axis=1))
        if len(bad):
            self._stop(f"{self._body_of(int(bad[0]))} has a non-finite displacement", "try a smaller time step")

    def _speed(self) -> None:
        if "velocity" not in self.model.state:
            return
        speed = np.hypot(*self.model.state["velocity"].T)
        limit = max(10.0 * self.input_speed, self.wave_speed)
        worst = int(np.argmax(speed))
        if not speed[worst] <= limit:
            self._stop(
                f"{self._body_of(worst)} moves at {speed[worst]:.3g}, above {limit:.3g}",
                "the step is too long or contact pushes without limit: try a smaller time.fraction",
            )

    def _folded(self) -> None:
        for forces in self.model.forces:
            points, begin = forces.body.element.quadrature().points, 0
            for block in forces.blocks:
                worst = forces.determinants(block, points).min(axis=0)
                if worst.min() <= 0.0:
                    cell = begin + int(np.argmin(worst))
                    self._stop(
                        f"cell {cell} of body {forces.body.name} is folded over (det F <= 0)",
                        "try a finer mesh there, a slower load or the other side as slave",
                    )
                begin += len(worst)

    def _penetration(self) -> None:
        for pair in self.pairs:
            gaps = pair.gaps[:, 0]
            # only conditions that the enforcement was asked to hold count: gaps are those before correction
            deep = np.flatnonzero(gaps < -0.5 * pair.size)
            if len(deep):
                node = pair.slave.nodes[deep[0] % len(pair.slave.nodes)]
                self._stop(
                    f"{pair.name}: {self._body_of(int(node))} lies {-gaps[deep[0]]:.3g} mm deep, more than half a "
                    "segment",
                    "try a smaller time step or the other side as slave",
                )
