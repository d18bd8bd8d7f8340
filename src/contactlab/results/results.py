"""What a run gives back."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from contactlab.api.arrays import Floats, Ints


@dataclass(frozen=True)
class ContactCurve:
    """The contact surface at one instant, one entry per slave node (m,), in chain order.

    s               arc length of the undeformed slave surface [mm]
    x, y            deformed position [mm]
    pressure        the multiplier Lambda, positive when pressed [MPa]
    shear           positive along the slave's arc length [MPa]
    nodal_pressure  nodal force per covered length, never negative [MPa]
    gap             [mm], nan where the node is not covered
    state           0 open, 1 stick, 2 slip (frictionless contact counts as slip)
    """

    s: Floats
    x: Floats
    y: Floats
    pressure: Floats
    shear: Floats
    nodal_pressure: Floats
    gap: Floats
    state: Ints

    COLUMNS = ("s", "x", "y", "pressure", "shear", "nodal_pressure", "gap", "state")


@dataclass
class ContactHistory:
    """The stored curves of one contact: `times` (frames,) [s] and the curves."""

    times: list[float] = field(default_factory=list)
    curves: list[ContactCurve] = field(default_factory=list)

    @property
    def last(self) -> ContactCurve:
        """The curve of the last stored frame."""
        if not self.curves:
            raise LookupError("no frame was stored for this contact")
        return self.curves[-1]


@dataclass
class Results:
    """A finished, failed or interrupted run.

    summary  the content of `summary.json` (see docs/scene-format.md)
    history  columns of `history.csv` by name, each (frames,)
    contact  per contact its stored curves, by "contacts.0" and by the contact's name
    nodes    (N, 2) reference positions; displacement (N, 2) of the last frame
    cells    cells of each body by name, in global node numbers
    stress   Cauchy stress of each body at the last frame, (n, q, 4) xx yy zz xy [MPa]
    folder   where the files are, None if none were written
    """

    summary: dict[str, Any]
    history: dict[str, Floats]
    contact: dict[str, ContactHistory]
    nodes: Floats
    displacement: Floats
    cells: dict[str, Ints]
    stress: dict[str, Floats]
    folder: Path | None = None

    @property
    def status(self) -> str:
        """finished, diverged, not-converged, refused, interrupted or failed."""
        return str(self.summary["status"])

    @property
    def reason(self) -> str:
        """Why the run did not finish; empty when it did."""
        return str(self.summary["reason"])
