"""Measures of runs: further columns of comparisons."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, Literal

from contactlab.api.record import Record
from contactlab.api.reference import Solution


class RunMeasure(ABC):
    """A number that a comparison shows for each of its runs. Subclasses are frozen dataclasses without required fields.

    1. `evaluate` finds the number in the record of a run with its whole load applied: the summary, the history and the
       last curve of the compared contact, and no fields.
    2. It returns NaN if the number has no meaning: no pressure at all, or no reference although it needs one.
    3. It changes nothing, and returns the same in every call.

    title    heading of its column
    unit     "share" (0.01 is shown as 1 %), "" for none, or the kind of a unit: "length", "pressure", "line_force" ...
    meaning  one sentence
    digits   significant digits that are shown
    better   "small" if less is better, "" if neither is
    """

    title: ClassVar[str]
    unit: ClassVar[str]
    meaning: ClassVar[str]
    digits: ClassVar[int] = 3
    better: ClassVar[Literal["", "small"]] = ""

    @abstractmethod
    def evaluate(self, record: Record, contact: str, reference: Solution | None) -> float:
        """Return the number of one run.

        contact    the compared contact, "contacts.0": its last curve is `record.curve(contact)`
        reference  the solution that the comparison measures against, None if none fits
        """
