"""The record of a run, from which a case is evaluated: numbers and arrays, no model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from contactlab.api.arrays import Floats, Ints
from contactlab.api.frame import ContactCurve


@dataclass(frozen=True, eq=False)
class Record:
    """A run as a case sees it; a run that failed is a record, too.

    status, reason  how it ended, as in `summary.json`: "finished", "diverged", "not-converged", "timed-out" ...
    summary         the content of `summary.json`
    history         columns of `history.csv` by name, each (frames,)
    times, curves   of each contact by "contacts.0": stored frames (frames,) [s] and their curves
    watched         of each watch by its name: the arrays of its memory
    events          the strings of warnings and other events
    nodes           (N, 2) reference positions [mm], displacement (N, 2) [mm], velocity (N, 2) [mm/s] at the end
    stress          Cauchy stress of each body at the end, (n, q, 4) xx yy zz xy [MPa]
    cells           of each body in global node numbers

    The last three rows are there for jobs with `fields`; otherwise their arrays are empty.
    """

    status: str
    reason: str
    summary: Mapping[str, Any]
    history: Mapping[str, Floats] = field(default_factory=dict)
    times: Mapping[str, Floats] = field(default_factory=dict)
    curves: Mapping[str, Sequence[ContactCurve]] = field(default_factory=dict)
    watched: Mapping[str, Mapping[str, Floats]] = field(default_factory=dict)
    events: Sequence[str] = ()
    nodes: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    displacement: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    velocity: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    stress: Mapping[str, Floats] = field(default_factory=dict)
    cells: Mapping[str, Ints] = field(default_factory=dict)

    @property
    def finished(self) -> bool:
        """True if the run finished."""
        return self.status == "finished"

    def curve(self, contact: str = "contacts.0") -> ContactCurve:
        """Return the contact at the last stored frame. Raises LookupError without one."""
        return self.curves[contact][-1]

    def reaction(self, support: str) -> Floats:
        """Return the force (2,) [N] of a support on its body at the end. Raises LookupError without one."""
        return np.asarray(self.summary["reactions"][support], float)

    @property
    def warnings(self) -> frozenset[str]:
        """Return codes of the warnings of the run."""
        return frozenset(str(w.get("code", w.get("name", ""))) for w in self.summary.get("warnings", ()))
