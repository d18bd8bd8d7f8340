"""The paper's second test: a block on a rigid plane with Tresca friction, against another code and finer meshes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Answer, Case, Job, Measure, Record, Setup
from contactlab.api.case import Measure as Number
from contactlab.api.case import error, reported
from contactlab_cases.circles import only
from contactlab_cases.statics import WORK, iterations

ENDS = {"everywhere": (0.717, 0.717), "closed": (0.715, 0.727)}
"""End of contact in the other code, least and largest [mm]."""
LIFTS = {"everywhere": (2.276e-3, 0.0042), "closed": (4.899e-4, 0.0053)}
"""Lift of the free corner [mm], and its uncertainty: own runs up to FINEST segments (build/docs/references.md).

The other code gives 2.25e-3 and 4.9e-4 on one mesh that is not known.
"""
FINEST = 416


@dataclass(frozen=True)
class TrescaBlock(Case):
    """`where` the friction bound of 200 MPa acts: everywhere, or only where surfaces are closed.

    segments  along the block, of 1.3 mm
    """

    where: str = "everywhere"
    segments: int = 104

    title: ClassVar[str] = "block with Tresca friction (test 2 of the paper)"
    source: ClassVar[str] = "Baillet & Sassi 2005, test 2; an independent active-set code"
    family: ClassVar[str] = "friction"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"where": tuple(ENDS), "segments": (52, 104)}
    demands: ClassVar[frozenset[str]] = frozenset({"friction"})
    integrators: ClassVar[tuple[str, ...]] = ("newton",)
    proves: ClassVar[frozenset[str]] = frozenset({"friction", "partial contact"})
    elements: ClassVar[tuple[str, ...]] = ("q1", "q1-fbar")
    swaps: ClassVar[bool] = False

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one job: the bundled scene."""
        changes = {
            **setup.changes("block"), "contacts.0.swap": False, "contacts.0.friction.where": self.where,
            "level": self.segments // 26 * setup.level,
        }  # fmt: skip
        return (Job("pressed", "tresca-block", changes, work=WORK),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """The end of contact, within one segment of the published place."""
        h, (least, most) = 1.3 / (self.segments * setup.level), ENDS[self.where]
        value, known = LIFTS[self.where]
        lift = Answer(value, "finest", known, "own runs (build/docs/references.md)", FINEST // self.segments)
        answer = Answer(0.5 * (least + most), "other-code", (most - least) / least, "independent active-set code")
        return (
            Number(
                "last closed node", "mm", "error", least - h, most + h, "one segment next to the other code's",
                answer=answer,
            ),
            error("lift of the free corner", 3.2 * h, "falls with the segment length", answer=lift),
            reported("iterations"),
            reported("steps taken back"),
        )  # fmt: skip

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compute the measures along the undeformed sole of the block."""
        record = only(done)
        curve = record.curve()
        start = np.linspace(0.0, 1.3, len(curve.x))
        return {
            "last closed node": float(start[np.asarray(curve.nodal_pressure) > 0.0].max()),
            "lift of the free corner": float(np.nanmax(curve.gap)) / LIFTS[self.where][0] - 1.0,
            "iterations": iterations(record),
            "steps taken back": float(sum("taken back" in text for text in record.events)),
        }
