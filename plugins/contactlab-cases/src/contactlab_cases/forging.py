"""The paper's third test: a plastic billet between a punch and an anvil of the same metal, on a rigid floor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Answer, Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, error, reported, within
from contactlab_cases.circles import only
from contactlab_cases.dynamics import WORK, largest
from contactlab_cases.statics import HELD_BY_FRICTION
from contactlab_cases.taylor_bar import area

DEPTH = 2.5  # mm, of the punch
MU = 0.1
RATIO = 1.75  # of the tools' segments to the billet's in the bundled scene
CELLS = {"anvil": (20, 4), "punch": (14, 3)}  # at that ratio; the billet has 14 x 9
SEGMENT = 2.0  # mm, of the anvil
ANSWER = Answer(5850.0, "two-discretisations", 0.05, "mortar-p0, tools or billet as slaves, on cells a quarter as long")
"""Force on the floor at the end [N/mm] with mu = 0.1: 5715 and 5878; the tools on cells an eighth as long gave 5573."""


@dataclass(frozen=True)
class Forging(Case):
    """Coulomb friction `mu` in all three contacts.

    ratio  of the tools' segments to the billet's, whose cells stay; the tools are the declared slaves
    """

    mu: float = MU
    ratio: float = RATIO

    title: ClassVar[str] = "forging of three bodies (test 3 of the paper)"
    source: ClassVar[str] = "Baillet & Sassi 2005, test 3; its shapes are ours"
    family: ClassVar[str] = "large deformation"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {"mu": (0.05, MU), "ratio": (1.0, RATIO)}
    demands: ClassVar[frozenset[str]] = frozenset({"friction"})
    integrators: ClassVar[tuple[str, ...]] = ("central-difference", "newton")
    elements: ClassVar[tuple[str, ...]] = ("q1-fbar",)
    proves: ClassVar[frozenset[str]] = frozenset({"plasticity", "large deformation", "many contacts"})

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """The bundled scene on cells twice as long; the anvil stays the slave on the floor, which is rigid."""
        changes = setup.changes("anvil", "billet", "punch", contacts=3)
        cells = {body: [round(n * RATIO / self.ratio) for n in CELLS[body]] for body in CELLS}
        for body, counts in {**cells, "billet": [14, 9]}.items():
            changes[f"bodies.{body}.mesh.cells"] = counts
        friction = {"use": "coulomb", "mu": self.mu}
        changes |= {f"contacts.{number}.friction": friction for number in range(3)}
        changes |= {"contacts.2.swap": False, "level": setup.level, "supports.0.uy.to": -DEPTH}
        if setup.integrator == "newton":
            changes["integrator"] = {"use": "newton", "steps": 50}
            changes |= {f"contacts.{number}.enforcement": HELD_BY_FRICTION for number in range(3)}
        else:  # frozen forces would let the billet's finer surface draw energy from the tools
            changes["integrator"] = {"use": setup.integrator, "forces": "consistent"}
        return (Job("forged", "three-body-forging", changes, work=WORK * setup.level, fields=True, frames=50),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Both methods and slaves carry the same force; metal neither vanishes nor passes through metal."""
        weak = "weak conditions hold in the mean: an arc of 10 mm rises by 0.025 over a segment, and the metal folds"
        told = ("penetration", "unbalanced-reactions", "pressure-saw", "open-contact")
        steps = "force rises in steps, as segments of 2 mm close: by a tenth on the way, half of it at the end"
        known = (error("force on the floor", 0.08 / setup.level, steps, answer=ANSWER, codes=told),)
        return (
            *(known if self.mu == MU else ()),
            at_most("deepest node of the billet in the anvil, in segments", 0.08, weak, codes=told),
            at_most("change of the area of a body", 0.01, "plastic flow keeps it; elastic strains are below 0.005"),
            within("force on the floor over that on the punch, less one", -0.01, 0.01, "at rest, but for vibrations"),
            at_most("kinetic energy over what was stored and flowed", 1e-3, "a forging, not an impact"),
            within(
                "least lift of the anvil's ends", 0.1, 1.0, "it bends about the billet, and nothing holds it down", "mm"
            ),
            reported("force on the floor at the end", "N/mm"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Evaluate reactions, frames, and the deformed bodies."""
        record = only(done)
        floor, punch = (abs(float(record.reaction(name)[1])) for name in ("floor", "punch.top"))
        x, balance = record.nodes + record.displacement, record.summary["balance"]
        gap = np.asarray(record.curve("contacts.2").gap)
        deep = record.summary["contacts"]["contacts.0"]["max_penetration"]
        areas = [area(x, cells) / area(record.nodes, cells) - 1.0 for cells in record.cells.values()]
        known = {"force on the floor": floor / ANSWER.value - 1.0} if self.mu == MU else {}
        segment = SEGMENT * self.ratio / RATIO / setup.level
        return {
            **known,
            "deepest node of the billet in the anvil, in segments": deep / segment,
            "change of the area of a body": largest(np.array(areas)),
            "force on the floor over that on the punch, less one": floor / punch - 1.0,
            "kinetic energy over what was stored and flowed": balance["kinetic"] / balance["internal"],
            "least lift of the anvil's ends": float(min(gap[0], gap[-1])),
            "force on the floor at the end": floor,
        }
