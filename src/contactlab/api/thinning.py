"""Which steps of a run stay in a record of bounded size; used by everything that keeps rows of steps."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

RECENT = 10_000  # steps before the last one that are never thinned, or half a record that has room for fewer than twice
LEFT = 0.75  # share of a record that may be left when it was thinned


class Thinning(NamedTuple):
    """The steps up to `until` that are kept: each `stride`th, and of those in which a contact state changed, each
    `changes`th."""

    until: int = 0
    stride: int = 1
    changes: int = 1

    def keeps(self, steps: np.ndarray, changed: np.ndarray) -> np.ndarray:
        """Which steps (n,) stay, `changed` (n,) in which of them a state changed."""
        return np.asarray((steps > self.until) | (steps % self.stride == 0) | (changed & (steps % self.changes == 0)))

    def as_data(self) -> dict[str, int]:
        """For the summary of a run."""
        return dict(self._asdict())

    def __str__(self) -> str:
        rare = f" and every {self.changes}th in which a contact state changed" if self.changes > 1 else ""
        return f"every {self.stride}th of the steps up to {self.until} is kept{rare}"


def recent_steps(most: int) -> int:
    """Number of the last steps that are never thinned in a record of `most` rows."""
    return min(RECENT, most // 2)


def thinned(steps: np.ndarray, changed: np.ndarray, most: int, before: Thinning) -> Thinning:
    """The next thinning of a record that is full: it has `most` rows, of these steps in their order.

    The stride doubles until a quarter of the room is free. State changes are thinned, too, where they take the room.
    """
    until, stride, changes = int(steps[-1]) - recent_steps(most), before.stride, before.changes
    older = steps <= until
    steps, changed, recent = steps[older], changed[older], int(np.count_nonzero(~older))
    while True:
        even = int(np.count_nonzero(steps % stride == 0))
        kept = int(np.count_nonzero(Thinning(until, stride, changes).keeps(steps, changed)))
        if recent + kept <= LEFT * most:
            return Thinning(until, stride, changes)
        if even > most // 16:
            stride *= 2
        else:
            changes *= 2
