"""Means in time of the forces of a run, over all of its steps: contact forces ring from one step to the next."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from contactlab.api import Floats, Memory, StepView, Watch

MEANS = "means"
"""Name of these means in `Record.watched`."""


@dataclass(frozen=True)
class MeanForces(Watch):
    """Finds `reaction` (2,) of all supports, and `contact` (contacts, 2) on each slave, means in time [N]."""

    def begin(self, view: StepView) -> Memory:
        """Return impulses [N s] of zero."""
        return {"reaction": np.zeros(2), "contact": np.zeros((view.contacts, 2)), "time": np.zeros(1)}

    def step(self, view: StepView, memory: Memory) -> None:
        """Add the impulses of a step."""
        force = view.field("contact_force")
        memory["time"] += view.dt
        memory["reaction"] += view.dt * view.field("reaction").sum(axis=0)
        for number in range(view.contacts):
            memory["contact"][number] += view.dt * force[view.slave(number)].sum(axis=0)

    def end(self, memory: Mapping[str, Floats]) -> Mapping[str, Floats]:
        """Return impulses over the time; zeros of a run without steps."""
        time = float(memory["time"][0]) or 1.0
        return {name: memory[name] / time for name in ("reaction", "contact")}
