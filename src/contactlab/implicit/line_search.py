"""How much of Newton's correction is taken: less where cells fold, surfaces pass through, or statuses go in circles."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats
from contactlab.implicit.scales import Scales
from contactlab.implicit.trial import Trial

DEEPEST = 1.0  # segment lengths that a correction may push a surface into the other
CAREFUL = (1.0, 0.5, 0.25, 0.125)  # fractions tried once statuses go round in circles
SHORTEST = 1.0 / 64.0  # of a correction: below it the step is given up
FEW_CELLS = 50.0  # segments across the model where no condition tells their length
MOST_PIECES = 64  # of a correction at whose ends conditions are asked, too


class LineSearch:
    """Takes corrections of one trial; remembers the patterns of statuses that a step has come to."""

    def __init__(self, trial: Trial, scales: Scales) -> None:
        self.trial, self.scales = trial, scales
        self.seen: set[bytes] = set()
        self.circling = False

    def forget(self) -> None:
        """Begin a step: no pattern of statuses has been seen."""
        self.seen.clear()
        self.circling = False

    def take(self, dt: float, du: Floats, dy: Floats, given: Floats) -> tuple[str, float, int]:
        """Correct the trial once; returns what limited the correction, the fraction taken, and status changes.

        du     (N, 2) [mm] correction of the displacements
        dy     (r, k) [N] correction of the multipliers
        given  (2N,) [mm] what prescribed degrees of freedom move by if all of it is taken
        """
        response = self.trial.response
        before = response.status.copy()
        note, length = self._careful(dt, du, dy, given) if self.circling else self._move(dt, du, dy, given)
        changed = int(np.count_nonzero(response.status != before))
        if changed:
            pattern = response.status.tobytes()
            self.circling = self.circling or pattern in self.seen
            self.seen.add(pattern)
        return note, length, changed

    def _careful(self, dt: float, du: Floats, dy: Floats, given: Floats) -> tuple[str, float]:
        """Statuses go round in circles: of some fractions of the correction take the one that leaves least to do."""
        u, y = self.trial.u, self.trial.multipliers
        start, y_start, found = u.copy(), y.copy(), []
        for part in CAREFUL:
            u[:], y[:] = start, y_start
            note, length = self._move(dt, part * du, part * dy, given if part == 1.0 else part * given)
            found.append((self._left_to_do(), part * length, part, note))
            if found[-1][0] < found[0][0] and found[-1] > min(found):
                break
        _, length, part, note = min(found)
        if part != found[-1][2]:
            u[:], y[:] = start, y_start
            self._move(dt, part * du, part * dy, given if part == 1.0 else part * given)
        return note or ("" if part == 1.0 else "statuses go round in circles"), length

    def _left_to_do(self) -> float:
        """Sum of squares [mm^2] of unbalanced forces and violated conditions, each over its stiffness."""
        trial = self.trial
        rest = float((trial.force**2 * self.scales.flexibility**2).sum())
        if trial.contact is not None:
            c = trial.contact.conditions
            rest += float((trial.response.residual[:, c.present] ** 2 / c.stiffness[c.present] ** 2).sum())
        return rest if np.isfinite(rest) else np.inf

    def _move(self, dt: float, du: Floats, dy: Floats, given: Floats) -> tuple[str, float]:
        """Take as much of a correction as keeps cells unfolded and surfaces from passing through each other."""
        trial, u, y = self.trial, self.trial.u, self.trial.multipliers
        start, y_start = u.copy(), y.copy()
        length, note = self._reach(start, du)
        shortest, work = SHORTEST * length, self._work(du, given)
        while length >= shortest > 0.0:
            u[:] = start + length * du
            if length == 1.0:
                u.reshape(-1)[trial.held] = (start.reshape(-1) + given)[trial.held]
            y[:] = y_start + length * dy
            trial.evaluate(dt)
            sense = not trial.equations.folded() and bool(np.isfinite(trial.force).all())
            if sense and (length <= 2.0 * shortest or abs(float(np.vdot(trial.force * self.scales.free, du))) <= work):
                return note, length
            length, note = 0.5 * length, "the energy of contact grows" if sense else "cells fold over"
        return note, 0.0

    def _work(self, du: Floats, given: Floats) -> float:
        """Largest work of unbalanced forces along a correction at its end: with potentials, that at its start.

        A correction that ends where the energy of potentials grows has gone too far. While supports move, or
        with conditions, there is no energy that would fall.
        """
        contact = self.trial.contact
        if contact is None or not contact.by_energy or np.any(given) or contact.conditions.present.any():
            return np.inf
        return abs(float(np.vdot(self.trial.force * self.scales.free, du)))

    def _reach(self, start: Floats, du: Floats) -> tuple[float, str]:
        """Fraction of a correction at which the first condition is pushed too deep, or a node through a surface."""
        contact = self.trial.contact
        if contact is None:
            return 1.0, ""
        conditions, place = contact.conditions, self.trial.equations.reference + start
        smallest = float(conditions.size[conditions.present].min(initial=np.inf))
        if not np.isfinite(smallest):
            smallest = self.scales.size / FEW_CELLS
        pieces = max(1, int(np.ceil(np.hypot(*du.T).max() / smallest)))
        length = contact.free_share(place, du, DEEPEST)
        if pieces <= MOST_PIECES:
            length = min(length, self._watched(place, du, pieces))
        return length, "surfaces would pass through each other" if length < 1.0 else ""

    def _watched(self, place: Floats, du: Floats, pieces: int) -> float:
        """Fraction of a correction at which a condition sees a surface too deep in the other; 1 if none does."""
        contact = self.trial.contact
        assert contact is not None
        conditions, length = contact.conditions, 1.0
        force = conditions.force.copy()
        for piece in range(1, pieces + 1):
            contact.evaluate(place + piece / pieces * du)
            depth = np.divide(
                -conditions.gap, conditions.size, out=np.zeros_like(conditions.gap), where=conditions.present
            )
            if depth.max() > DEEPEST:
                length = (piece - 1 if depth.max() > 2.0 * DEEPEST and piece > 1 else piece) / pieces
                break
        conditions.force[:] = force
        return length
