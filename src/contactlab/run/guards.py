"""All checks of one run that stop it once its numbers mean nothing: with the step, the place, and what to try."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from contactlab.api import Floats, Step
from contactlab.errors import NotFiniteError
from contactlab.model.model import Model
from contactlab.results.sample import Sample
from contactlab.run.contact_guard import ContactGuard
from contactlab.run.energy_guard import EnergyGuard
from contactlab.run.judgement import judge
from contactlab.run.motion_guard import MotionGuard
from contactlab.run.stopping import shorter_steps

EVERY = 50  # steps between checks of the whole model
SELDOM = 4 * EVERY  # steps between checks of the stored energy, which costs the laws another pass


class Guards:
    """Checks one run: `after_step` is called every step, `check` every `EVERY` steps and at every frame."""

    def __init__(self, model: Model, step: float | None = None) -> None:
        """`step` [s] is the length that the scene fixes, if it does: only then advice is to change that."""
        self.model, self.work = model, model.state["work"]
        shorter = shorter_steps(model.explicit, step)
        self.motion, self.contact = MotionGuard(model, shorter), ContactGuard(model, shorter)
        self.energy = EnergyGuard(model, shorter, self.motion.wave_speed)

    def after_step(self, step: Step) -> None:
        """Stop at the first step without a number, and when contact was not solved or flickered for many steps."""
        if not math.isfinite(self.work[0]):
            self.motion.check_finite()
            raise NotFiniteError("failed", f"step {self.model.state.step}: the work of the stresses is not a number")
        self.contact.after_step(step.residual)

    def check(self) -> None:
        """Raise SimulationFailure("diverged") at the first sign that the numbers mean nothing any more."""
        self.check_positions()
        step = self.model.state.step
        if step % EVERY or step % SELDOM == 0:  # at every frame between the checks, and in every fourth check
            self.energy.check()

    def check_positions(self) -> None:
        """The part of `check` that one step alone decides: numbers, speeds, cells and surfaces at its end."""
        self.motion.check_finite()
        self.contact.check_numbers()
        self.motion.check_speed()
        self.motion.check_cells()
        self.contact.look()

    def step_made_energy(self) -> bool:
        """Return whether the last step is too long by its energy: it is cut if possible."""
        return self.energy.step_made_energy()

    def at_the_end(self) -> None:
        """Check for the last time: unexplained energy of short duration gives a warning, much more stops the run."""
        self.check()
        self.energy.check(last=True)

    def judge(self, sample: Sample | None, largest_force: float, largest_work: float) -> None:
        """Add what a finished run says of itself by its last sample; see `contactlab.run.judgement`."""
        judge(self.model, sample, self.contact.closed, largest_force, largest_work)

    def saved(self) -> dict[str, Floats]:
        """Everything that changes during the run, as arrays of a checkpoint."""
        contact, energy = self.contact, self.energy
        pushed = energy.pushed, energy.rate, energy.counted, energy.unexplained, energy.spent
        chatter = contact.flickering, contact.rattling, contact.largest
        numbers = (contact.loose, self.motion.input_speed, *chatter, energy.largest, *pushed, *energy.since)
        return {"guards": np.array(numbers, np.float64), "guards.pressed": contact.pressed + 2.0 * contact.closed}

    def restore(self, memory: Mapping[str, Floats]) -> None:
        """Go back to where `memory` was saved."""
        contact, energy = self.contact, self.energy
        loose, self.motion.input_speed, flickering, *more = memory["guards"].tolist()
        contact.rattling, contact.largest, energy.largest, *more = more
        energy.pushed, energy.rate, energy.counted, energy.unexplained, energy.spent, *since = more
        energy.since[:] = since
        contact.loose, contact.flickering = int(loose), int(flickering)
        contact.pressed[:] = memory["guards.pressed"] % 2.0 == 1.0
        contact.closed[:] = memory["guards.pressed"] >= 2.0
        contact.before[:] = self.model.position
