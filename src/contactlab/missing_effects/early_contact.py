"""Potentials that press across gaps: bodies act as if they were larger by the distance that is kept."""

from __future__ import annotations

import numpy as np

from contactlab.api import WORK, RunWarning, Step
from contactlab.missing_effects.missing_effect import Detectors, needed, per_cent
from contactlab.model.model import Model
from contactlab.results.invariants import NO_STRAIN
from contactlab.results.strain_scale import energy_of_strain
from contactlab.scene.scene import Scene

EARLY = 0.02  # of the largest energy: what drives or yields under a load is off by half of that
INTERNAL = WORK.index("internal")


def early_detectors(scene: Scene, model: Model) -> Detectors:
    """A detector for all contacts together, as distances in series add up, where some keep one."""
    if model.contact is not None and any(pair.clearance > 0.0 for pair in model.contact.pairs):
        yield EarlyContact(model)


class EarlyContact:
    """`worst`: largest sum of forces times the gaps across which they act [mJ], its contact, and largest energy [mJ].

    That energy is strain energy, by the work of the stresses, and kinetic energy. Gaps by which surfaces that touched
    were opened before the run do not count.
    """

    def __init__(self, model: Model) -> None:
        self.model, self.pairs, self.worst = model, model.contact.pairs, np.zeros(3)  # type: ignore[union-attr]

    def update(self) -> None:
        """Take in the forces and gaps of this moment."""
        state = self.model.state
        works = np.zeros(len(self.pairs))
        for number, pair in enumerate(self.pairs):
            forces = state["multipliers"][0, pair.own]
            pressed = forces > 0.0
            if pair.clearance > 0.0:
                works[number] = forces[pressed] @ np.maximum(pair.gaps[pressed, 0] - pair.opened, 0.0)
        if works.sum() > self.worst[0]:
            self.worst[:2] = works.sum(), works.argmax()
        energy = abs(float(state["work"][INTERNAL]))
        energy += self.model.kinetic_energy() if "velocity" in state else 0.0
        self.worst[2] = max(self.worst[2], energy)

    def follow(self, step: Step, dt: float) -> None:
        """Take in the state after an accepted step: impacts may begin and end between frames."""
        self.update()

    def warning(self) -> RunWarning | None:
        """Advise a smaller distance; None if it takes little energy."""
        work, number, energy = (float(value) for value in self.worst)
        share = work / max(energy, energy_of_strain(self.model, NO_STRAIN))
        if share <= EARLY:
            return None
        pair = self.pairs[int(number)]
        return needed(
            "early-contact", share, EARLY, f"{pair.name}.algorithm",
            f"{pair.name}: forces act across gaps, as if the bodies were larger: closing the gaps would take "
            f"{per_cent(share)} of the largest strain and kinetic energy (limit {per_cent(EARLY)})",
            "take a smaller dhat, finer cells, or an algorithm that closes gaps (mortar-p1)",
        )  # fmt: skip
