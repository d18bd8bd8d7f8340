"""The disc on the block with meshes from eight times finer to eight times coarser, steps, damping and depths.

Explicit runs push along the derivatives of their gaps, and so does the static run that they are compared with.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, error, invariant, reported
from contactlab_cases.series import series, table
from contactlab_cases.statics import WORK as ITERATIONS
from contactlab_cases.statics import iterations

CHORD, SEGMENT = 1.6, 1.8  # mm, of the disc and of the block
LOWEST = 1.054e7  # 1/s, lowest frequency that the load meets
COARSER_FROM = 4.0  # ratios from which both meshes have half as many cells, so that the finer one stays affordable
STEPS = 400_000
AGAINST = "reaction against statics with the same forces"
TOLERANCE = 1e-6  # of the forces, in statics: a five-hundredth of what reactions may differ by
VARIED: Mapping[str, Mapping[str, Any]] = {
    "nothing": {},
    "quarter of the step": {"time.fraction": 0.25},
    "whole stable step": {"time.fraction": 1.0},
    "damping w1": {"time.damping": LOWEST},
    "damping 0.01 w1": {"time.damping": 0.01 * LOWEST},
    "shallow": {"supports.1.uy.to": -0.01},
    "friction": {"contacts.0.friction": {"use": "coulomb", "mu": 0.2}},
}


@dataclass(frozen=True)
class MeshLadder(Case):
    """`ratio` of the disc's segments to the block's; `varied` names what differs from a deep, frictionless run."""

    ratio: float = 1.0
    varied: str = "nothing"

    title: ClassVar[str] = "mesh ratios with consistent forces"
    source: ClassVar[str] = "energy and equilibrium"
    family: ClassVar[str] = "large deformation"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {
        "ratio": (1.0, 2.0, 0.5, 3.0, 1.0 / 3.0, 5.0, 0.2, 8.0, 0.125),
        "varied": tuple(VARIED),
    }
    demands: ClassVar[frozenset[str]] = frozenset({"explicit"})
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1", "q2", "q2-lagrange")
    proves: ClassVar[frozenset[str]] = frozenset({"energy", "mesh ratio"})

    def __post_init__(self) -> None:
        if self.varied not in VARIED:
            raise ValueError(f"varied: got {self.varied!r}, allowed: {', '.join(VARIED)}")

    def applies(self, setup: Setup) -> str:
        """Allow variations on one rung with linear edges only, and costly quadratic cells on the first rungs."""
        if self.varied != "nothing" and self.ratio != 1.0 / 3.0:
            return "steps, damping and loads vary at 1:3, with either side as slave"
        if setup.element != "q1" and (self.varied != "nothing" or self.ratio not in self.axes["ratio"][:4]):
            return "explicit runs of quadratic cells are expensive: meshes with a ratio up to 3 are enough"
        return ""

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan the explicit run along its path; if it comes to rest, also the static run to compare it with."""
        if "explicit" in done and not done["explicit"].finished:
            return ()
        changes = {**setup.changes("disc", "block"), **self._meshes(setup), **VARIED[self.varied]}
        pushed = {"use": "forward-increment", "forces": "consistent"}
        own = {"contacts.0.swap": setup.swap, "contacts.0.enforcement": pushed, "time.history": True}
        # forces jump by some 1e-8 where a segment comes within reach: closer than that they may have no answer
        static = {"use": "newton", "steps": 20 if self.varied == "friction" else 10, "tolerance": TOLERANCE}
        held = {
            "integrator": static,
            "contacts.0.swap": setup.swap, "contacts.0.enforcement": {"use": "active-set", "forces": "consistent"},
        }  # fmt: skip
        still = {key: value for key, value in changes.items() if not key.startswith("time.")}
        watch = series("work.contact", most=STEPS)
        explicit = Job("explicit", "disc-on-block", changes | own, watch=(watch,), work=STEPS)
        return (Job("static", "disc-on-block", still | held, work=2 * ITERATIONS) if done else explicit,)

    def _meshes(self, setup: Setup) -> dict[str, Any]:
        longest = max(self.ratio, 1.0 / self.ratio)
        base = setup.level * (24 if longest < COARSER_FROM else 12)
        if setup.element != "q1":
            base //= 2  # as many nodes along the surfaces
        disc = round(base * max(1.0, 1.0 / self.ratio))
        block = round(base * SEGMENT / CHORD * max(1.0, self.ratio))
        return {
            "bodies.disc.mesh.cells": [disc, max(2, disc // 4)],
            "bodies.block.mesh.cells": [block, max(2, block // 6)],
        }

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Contact takes and never gives, and what is at rest is what statics find."""
        solved = "what the solve leaves of gaps, 1e-10 of a segment, times forces"
        rest = "a run that counts as settled still swings by some 1e-4 of its forces"
        slips = "what sticks or slips at the end depends on the way there"
        rubs = self.varied == "friction"
        return (
            error(AGAINST, 5e-3 if rubs else 5e-4, slips if rubs else rest, codes=("kept-overlap",)),
            at_most("energy made by contact over that stored", 1e-3, "round-off of many steps"),
            invariant("largest rise in a step over the energy stored", 1e-9, solved),
            reported("energy taken by contact over that stored"),
            reported("reaction", "N/mm"),
            reported("iterations of the static run"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Reactions of the block, and the work of contact step by step."""
        run, static = done["explicit"], done.get("static")
        work = np.concatenate([[0.0], table(run)["work.contact"]])
        stored, reaction = float(run.summary["balance"]["stored"]), float(run.reaction("block.bottom")[1])
        compared: dict[str, float] = {}
        if static is not None and static.finished:
            compared[AGAINST] = reaction / float(static.reaction("block.bottom")[1]) - 1.0
            compared["iterations of the static run"] = iterations(static)
        return compared | {
            "energy made by contact over that stored": max(0.0, float(work.max())) / stored,
            "largest rise in a step over the energy stored": max(0.0, float(np.diff(work).max())) / stored,
            "energy taken by contact over that stored": -float(work[-1]) / stored,
            "reaction": reaction,
        }
