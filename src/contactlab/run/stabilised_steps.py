"""Steps of statics with viscous forces, made if plain steps fail at all lengths, and their influence."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from contactlab.api import WORK, Floats, RunWarning
from contactlab.errors import SimulationFailure
from contactlab.model.implicit_model import ImplicitModel

JUMP = 0.25  # of the wished step: what jumps in a stabilised step does so under about the load that it jumps at
CUTS = 1  # of a stabilised step before the run is given up
PLAIN = 4  # a plain trial follows the first stabilised step in a row and every fourth: most others would fail
MUCH = 0.05  # of what friction and plastic flow dissipate: more of it in stabilised steps is warned of
LITTLE = 0.01  # of the work: what dissipates less hardly changes the answer
COUNT, JUMPED, IN_A_ROW, NEXT, BEFORE = range(5)


class StabilisedSteps:
    """Counts stabilised steps and what is dissipated in them.

    numbers  stabilised steps of the run, what friction and plastic flow took in them [mJ], steps in a row without a
             plain one between, whether the next step is stabilised, and what was dissipated before it [mJ]
    replaces  why the plain step failed that the next one stands for; None if the next is plain
    """

    def __init__(self, model: ImplicitModel) -> None:
        self.model, self.numbers = model, np.zeros(5)
        self.replaces: SimulationFailure | None = None

    @property
    def count(self) -> int:
        """Stabilised steps so far."""
        return int(self.numbers[COUNT])

    @property
    def in_a_row(self) -> int:
        """Stabilised steps since the last plain one."""
        return int(self.numbers[IN_A_ROW])

    def choose(self, replaces: SimulationFailure | None) -> None:
        """Let the next step be stabilised, to replace a failed step, or plain."""
        self.replaces, self.numbers[BEFORE] = replaces, self.dissipation()
        self.model.stabilised = replaces is not None

    def follow(self) -> None:
        """Look at an accepted step, and choose whether the next one is stabilised, too."""
        n = self.numbers
        if self.replaces is None:
            n[IN_A_ROW] = 0
            return
        n[COUNT] += 1
        n[IN_A_ROW] += 1
        n[JUMPED] += self.dissipation() - n[BEFORE]
        self.choose(self.replaces if self.in_a_row > 1 and self.in_a_row % PLAIN else None)

    def plain_instead(self) -> bool:
        """Let the next step be plain after a stabilised one failed; False if a plain one failed just before it."""
        if not self.in_a_row:
            return False
        self.numbers[IN_A_ROW] = 0
        self.choose(None)
        return True

    def dissipation(self) -> float:
        """Work [mJ] that friction and plastic flow have taken so far: what of an end in balance depends on the way."""
        flow = sum(forces.dissipated_energy() for forces in self.model.forces)
        return float(self.model.state["work"][WORK.index("slip")]) + flow

    def dissipates_little(self) -> bool:
        """Return whether the end hardly depends on the path that led to it."""
        return self.dissipation() <= LITTLE * float(np.abs(self.model.state["work"]).max())

    def summary(self) -> dict[str, float]:
        """Stabilised steps, the work [mJ] of their viscous forces, and its share of all work; empty without any."""
        if not self.count:
            return {}
        work = self.model.state["work"]
        took, largest = float(work[WORK.index("numerical")]), float(np.abs(work).max())
        return {"steps": self.count, "work": took, "share": took / max(largest, 1e-300)}

    def warnings(self) -> Iterator[RunWarning]:
        """Warn if what depends on the way of jumps is much of the answer."""
        jumped, total = self.numbers[JUMPED], self.dissipation()
        if self.count and jumped > MUCH * total and not self.dissipates_little():
            yield RunWarning(
                "stabilised", jumped / total, MUCH, "integrator.steps",
                f"{jumped / total:.1%} of the dissipation by friction and plastic flow is from {self.count} stabilised "
                f"load steps (limit {MUCH:.0%}): bodies jumped there along a path set by viscous forces, and results "
                "that depend on the path are not exact; take more integrator.steps, or implicit-dynamics, which "
                "follows the jump",
            )  # fmt: skip

    def saved(self) -> Floats:
        """Numbers that change during the run, (5,)."""
        self.numbers[NEXT] = self.replaces is not None
        return self.numbers.copy()

    def restore(self, numbers: Floats) -> None:
        """Go back to where `numbers` were saved."""
        self.numbers[:] = numbers
        # a stabilised step that fails again is tried without stabilisation: this reason is never shown
        self.replaces = SimulationFailure("not-converged", "stabilised before") if numbers[NEXT] else None
        self.model.stabilised = self.replaces is not None
