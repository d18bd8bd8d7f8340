"""Plan of the steps in a run's contact record, and of Newton's iterations whose states are stored.

Both are functions of a number alone, so that a resumed run takes the same steps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from contactlab.api.contact_steps import contact_record
from contactlab.api.frame import Layout

MEGABYTE = 1e6
SURE = 0.75  # of the rows of a budget are kept one by one, before some are left out


@dataclass(frozen=True)
class Window:
    """The steps `first`, `first + every`, ... up to `last` of the contact record."""

    first: int = 1
    last: float = math.inf
    every: int = 1

    @classmethod
    def of(cls, record: Any, layout: Layout) -> Window | None:
        """The window of the table `[record]`; None if nothing is recorded."""
        if not layout.contacts or not layout.budget:
            return None
        return cls(record.from_ or 1, record.to or math.inf, record.every or 1)

    def disk_bytes(self, layout: Layout, steps: int) -> float:
        """Bytes of the record of so many steps on the disk."""
        taken = max(0.0, (min(steps, self.last) - self.first) // self.every + 1)
        size = sum(contact_record(contact).itemsize for contact in layout.contacts)
        return min(taken * size, layout.budget * MEGABYTE)

    def following(self, step: int) -> float:
        """The first step after `step` that is taken; infinite if there is none."""
        due = self.first if step < self.first else self.first + ((step - self.first) // self.every + 1) * self.every
        return due if due <= self.last else math.inf


def iterate_bytes(layout: Layout, conditions: int) -> int:
    """Bytes of the state after one iteration: displacements and gaps in single precision, and where they belong."""
    return 8 * len(layout.nodes) + 4 * conditions + 16


@dataclass(frozen=True)
class IteratePlan:
    """Iterations whose states are stored: the first `sure` ones, of those behind them fewer and fewer, `rows` at most.

    Nobody knows their number before.
    """

    rows: int

    @classmethod
    def of(cls, layout: Layout, conditions: int) -> IteratePlan | None:
        """The plan of a run; None if no iterations are stored."""
        rows = int(layout.budget * MEGABYTE / iterate_bytes(layout, conditions))
        return cls(rows) if rows >= 4 else None

    @property
    def sure(self) -> int:
        """The last iteration of which none before it is left out."""
        return int(SURE * self.rows)

    def following(self, number: int) -> int:
        """The first iteration after `number` that is stored."""
        begin, every, rows = 1, 1, self.sure
        while number >= (end := begin + rows * every):  # in the stretch behind it every other one is left out
            begin, every, rows = end, 2 * every, max(1, min(rows, self.sure // 4) // 2)
        due = begin if number < begin else begin + ((number - begin) // every + 1) * every
        return min(due, end)  # the next stretch begins with a row of its own
