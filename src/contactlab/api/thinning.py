"""Choice of the steps that stay in a record of bounded size; used by everything that keeps rows of steps."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

RECENT = 10_000  # steps before the last one that are never thinned, or half a record that has room for fewer than twice
LEFT = 0.75  # largest share of a record that thinning leaves


class Thinning(NamedTuple):
    """The steps up to `until` that are kept: each `stride`th, and of the steps with a changed contact state, each
    `changes`th."""

    until: int = 0
    stride: int = 1
    changes: int = 1

    def keeps(self, steps: np.ndarray, changed: np.ndarray) -> np.ndarray:
        """Return which steps (n,) stay; `changed` (n,) is True if a contact state changed in the step."""
        return np.asarray((steps > self.until) | (steps % self.stride == 0) | (changed & (steps % self.changes == 0)))

    def as_data(self) -> dict[str, int]:
        """Return the data for the summary of a run."""
        return dict(self._asdict())

    def __str__(self) -> str:
        rare = f" and every {self.changes}th in which a contact state changed" if self.changes > 1 else ""
        return f"every {self.stride}th of the steps up to {self.until} is kept{rare}"


def recent_steps(most: int) -> int:
    """Return the number of the last steps that are never thinned in a record of `most` rows."""
    return min(RECENT, most // 2)


def thinned(rows: Iterable[tuple[np.ndarray, np.ndarray]], last: int, most: int, before: Thinning) -> Thinning:
    """Return the next thinning of a record that is full: it has `most` rows, up to step `last`.

    The stride doubles until a quarter of the room is free. Steps with changes are thinned, too, if they fill the room.

    rows  blocks of steps (n,) and booleans (n,) for a changed contact state, in any number
    """
    until, stride, changes = last - recent_steps(most), before.stride, before.changes
    recent, tally = 0, np.zeros((2, 64), np.int64)  # older steps by their largest divisor 2^k, and steps with changes
    for steps, changed in rows:
        older = steps <= until
        # the largest k for which 2^k divides each step; 63 of step 0
        divisor = steps[older] & -steps[older]
        power = np.where(divisor > 0, np.frexp(divisor.astype(float))[1] - 1, 63)
        recent += int(np.count_nonzero(~older))
        tally += [np.bincount(power, minlength=64), np.bincount(power[changed[older]], minlength=64)]
    while True:
        even, rare = stride.bit_length() - 1, changes.bit_length() - 1
        kept = int(tally[0, even:].sum() + tally[1, rare:even].sum())
        if recent + kept <= LEFT * most:
            return Thinning(until, stride, changes)
        if tally[0, even:].sum() > most // 16:
            stride *= 2
        else:
            changes *= 2
