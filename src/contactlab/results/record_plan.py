"""Which steps the contact record has: a window, and fewer of them where it would be larger than its budget.

What is kept is a function of the number of a step alone, so that a run that is taken up again keeps the same steps.
The same holds for states after Newton's iterations, by their number in the run.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from contactlab.api.contact_steps import contact_record
from contactlab.api.frame import Layout

BUDGET = 64.0  # MB of one run, where the scene names none
MEGABYTE = 1e6
MEANT = 0.75  # of the budget is what a run takes that has as many steps as it was estimated to have


def iterate_bytes(layout: Layout, conditions: int) -> int:
    """What the state after one iteration takes: displacements and gaps in single precision, and where they belong."""
    return 8 * len(layout.nodes) + 4 * conditions + 16


@dataclass(frozen=True)
class RecordPlan:
    """The steps `first`, `first + every`, ... up to `last`; fewer and fewer of them beyond `sure` rows.

    asked  what the scene says of `every`
    every  steps from one row to the next, more than was asked where the budget is too small
    rows   what the budget has room for
    sure   rows after which every other step is left out, then more and more
    """

    first: int
    last: float
    asked: int
    every: int
    rows: int
    sure: int

    @classmethod
    def of(cls, record: Any, layout: Layout, steps: int) -> RecordPlan | None:
        """The plan of a run of about so many steps, from the table `[record]`; None where nothing is kept."""
        size = sum(contact_record(contact).itemsize for contact in layout.contacts)
        rows = int((BUDGET if record.budget is None else record.budget) * MEGABYTE / max(1, size))
        if not layout.contacts or rows < 4:
            return None
        first, last, asked = record.from_ or 1, record.to or math.inf, record.every or 1
        meant, sure = (min(steps, last) - first) // asked + 1, int(MEANT * rows)
        thinner = max(1, math.ceil(meant / sure))
        return cls(first, last, asked, asked * thinner, rows, sure)

    @classmethod
    def of_iterations(cls, record: Any, layout: Layout, conditions: int) -> RecordPlan | None:
        """The plan of states after iterations, whose number nobody knows before; None where none is kept."""
        rows = int((BUDGET if record.budget is None else record.budget) * MEGABYTE / iterate_bytes(layout, conditions))
        return cls(1, math.inf, 1, 1, rows, int(MEANT * rows)) if rows >= 4 else None

    def disk_bytes(self, layout: Layout, steps: int) -> float:
        """What the record of so many steps takes on the disk."""
        kept = (min(steps, self.last) - self.first) // self.every + 1
        return max(0.0, kept) * sum(contact_record(contact).itemsize for contact in layout.contacts)

    def following(self, step: int) -> float:
        """The first step after `step` that is kept; infinite where none is."""
        begin, every, rows = self.first, self.every, self.sure
        while step >= (end := begin + rows * every):  # in the stretch behind it every other step is left out
            begin, every, rows = end, 2 * every, max(1, min(rows, self.sure // 4) // 2)
        due = begin if step < begin else begin + ((step - begin) // every + 1) * every
        due = min(due, end)  # the next stretch begins with a row of its own
        return due if due <= self.last else math.inf

    @property
    def whole(self) -> int:
        """The last step of which none before it is left out."""
        return self.first + (self.sure - 1) * self.every

    def told(self) -> str:
        """What a reader of the run is told where steps are left out; empty where none are."""
        if self.every == self.asked:
            return ""
        return (
            f"contact is recorded every {self.every} steps: its record would be larger than record.budget with "
            f"{'every one' if self.asked == 1 else f'one in {self.asked}'}; record.from and record.to choose a window"
        )
