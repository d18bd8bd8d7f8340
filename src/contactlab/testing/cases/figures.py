"""Measured numbers and the criteria they must meet."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Figure:
    """One measured number of a case.

    says         what was measured, with its unit
    value        nan never meets a criterion
    least, most  the criterion; without either the number is only reported
    """

    says: str
    value: float
    least: float = -math.inf
    most: float = math.inf

    @property
    def judged(self) -> bool:
        """Whether the figure has a criterion to be judged by."""
        return math.isfinite(self.least) or math.isfinite(self.most)

    @property
    def met(self) -> bool:
        """Whether the criterion is met; a number that is only reported always is."""
        return not self.judged or self.least <= self.value <= self.most

    @property
    def criterion(self) -> str:
        """Write the criterion in words: its limits and unit."""
        if not self.judged:
            return "reported"
        if not math.isfinite(self.least):
            return f"<= {self.most:.4g}"
        if not math.isfinite(self.most):
            return f">= {self.least:.4g}"
        return f"{self.least:.5g} to {self.most:.5g}"

    def __str__(self) -> str:
        return f"{self.says}: {self.value:.6g} ({self.criterion})"


def near(says: str, value: float, exact: float, within: float) -> Figure:
    """A number that must lie within the fraction `within` of the exact one."""
    slack = abs(exact) * within
    return Figure(f"{says} (exact: {exact:.6g})", value, exact - slack, exact + slack)
