"""Duration of impacts in implicit dynamics, compared with the step length of the scene."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from contactlab.api import WORK, Floats, RunWarning, Step
from contactlab.model.model import Model

FEW = 5  # wished steps in the contact of an impact
SPRUNG = 10  # on springs: the largest force is 5 % above the means over steps that are seen
FRONT = 40  # of steps that are not cut: the midpoint rule then loses 5 % of the speed behind a sharp front
LOST = 0.01  # of the energy of motion before it: a contact that takes more is an impact, if steps are not cut
STOPPED = 0.9  # of this energy: what springs take for a time in an impact, and give back
BEGUN, KINETIC, WORKED, CUT, SHORTEST, EVER, LEAST = range(7)


class ContactTimes:
    """Follows contact from the first force to the last one.

    numbers  begin of the present contact [s] (NaN: none), kinetic energy and work of contact [mJ] before it, whether
             steps were cut in it, the shortest impact so far [s], whether energy was kept in any, by steps that were
             cut or by springs, and the least kinetic energy [mJ] in the present contact
    """

    def __init__(self, model: Model, wished: float) -> None:
        self.model, self.wished = model, wished
        assert model.contact is not None
        self.springs = not model.contact.enforcement.exact
        self.numbers: Floats = np.array([np.nan, model.kinetic_energy(), 0.0, 0.0, np.inf, 0.0, np.inf])

    @property
    def memory(self) -> dict[str, Floats]:
        """Arrays that change during the run, by name."""
        return {"contact_times": self.numbers}

    def follow(self, step: Step, dt: float, jumped: bool) -> None:
        """Look at the state after an accepted step of length dt [s]."""
        state, n = self.model.state, self.numbers
        n[CUT] = n[CUT] or step.longest is not None
        if state["contact_force"].any():
            if np.isnan(n[BEGUN]):
                n[BEGUN] = state.time - dt
            n[LEAST] = min(n[LEAST], self.model.kinetic_energy())
            return
        work = float(state["work"][WORK.index("contact")])
        if not np.isnan(n[BEGUN]):
            lost = not n[CUT] and n[WORKED] - work > LOST * n[KINETIC] > 0.0
            kept = n[CUT] or (self.springs and not lost and n[LEAST] < STOPPED * n[KINETIC])
            n[EVER] = n[EVER] or kept
            if kept or lost:
                n[SHORTEST] = min(n[SHORTEST], state.time - dt - n[BEGUN])
            n[BEGUN], n[LEAST] = np.nan, np.inf
        n[KINETIC], n[WORKED], n[CUT] = self.model.kinetic_energy(), work, 0.0

    def warnings(self, key: str, now: float) -> Iterator[RunWarning]:
        """Warn of the shortest impact, if few wished steps make it; `key` is where the scene says how long they are."""
        lasted, kept = float(self.numbers[SHORTEST]), bool(self.numbers[EVER])
        limit, number = (SPRUNG if self.springs else FEW) if kept else FRONT, lasted / self.wished
        if number >= limit:
            return
        if kept and self.springs:
            done = "forces are means over steps, below their peaks;"
        elif kept:
            done = "steps were cut to follow it, but steps between impacts are too long for the vibrations after it;"
        else:
            cut = "" if self.springs or "impact" in self.model.state else " set integrator.impacts = true, or"
            done = f"the speed of rebound depends on the step;{cut}"
        yield RunWarning(
            "few-steps-in-contact", number, limit, key,
            f"an impact lasts {lasted:.3g} s, {number:.2g} steps of {self.wished:.3g} s (at least {limit}): "
            f"{done} take steps of {lasted / limit:.2g} s",
        )  # fmt: skip
