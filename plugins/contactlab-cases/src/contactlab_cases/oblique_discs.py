"""Two spinning discs that hit each other obliquely: momenta, and what Coulomb lets pass along the surface."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Case, Job, Measure, Record, Setup
from contactlab.api.case import at_most, error, invariant, reported
from contactlab_cases.discs import INERTIA, MASS, RADIUS, soft, soft_disc
from contactlab_cases.dynamics import WORK, momentum_change, pushed
from contactlab_cases.series import series, table

SPEED, YOUNG, END = 200.0, 1.0, 0.04  # mm/s; MPa; s


@dataclass(frozen=True)
class ObliqueDiscs(Case):
    """`mu`; `spin` of the flying disc [1/s]; `aside` is how far its way passes the other's centre, in radii; `forces`
    along frozen rows or along derivatives of gaps, which have no moment and give no energy on any mesh.

    Friction passes mu times the normal impulse while the surfaces slide, which a fast spin makes sure of; each disc
    takes up R times that as angular momentum. Without friction nothing passes, and spins stay.
    """

    mu: float = 0.2
    spin: float = 60.0
    aside: float = 0.5
    forces: str = "consistent"

    title: ClassVar[str] = "oblique impact of two discs with spin"
    source: ClassVar[str] = "Routh 1860; momenta and Coulomb's law"
    family: ClassVar[str] = "impact"
    axes: ClassVar[Mapping[str, tuple[Any, ...]]] = {
        "mu": (0.0, 0.1, 0.2),
        "spin": (60.0, 100.0),
        "aside": (0.0, 0.5),
        "forces": ("consistent", "frozen"),
    }
    demands: ClassVar[frozenset[str]] = frozenset({"friction", "explicit"})
    integrators: ClassVar[tuple[str, ...]] = ("central-difference",)
    elements: ClassVar[tuple[str, ...]] = ("q1",)
    proves: ClassVar[frozenset[str]] = frozenset({"impact", "momentum", "energy", "friction"})

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """Plan one run: a disc flies against a disc at rest."""
        cells, y = 8 * setup.level, self.aside * RADIUS
        x = -float(np.sqrt(4.0 * RADIUS**2 - y**2)) - 0.05 * RADIUS
        bodies = {
            "flying": soft_disc(cells, shift=[x, y], velocity=[SPEED, 0.0], spin=self.spin, element=setup.element),
            "resting": soft_disc(cells, rotate=5.0, element=setup.element),
        }
        contact = {
            "slave": "flying.arc", "master": "resting.arc", "algorithm": setup.algorithm, "swap": setup.swap,
            "enforcement": pushed(self.forces),
        }  # fmt: skip
        friction = {"friction": {"use": "coulomb", "mu": self.mu}} if self.mu else {}
        scene = {
            "name": "oblique-discs", "time": {"end": END}, "integrator": setup.integrator,
            "materials": {"soft": soft(YOUNG)}, "bodies": bodies, "contacts": [contact | friction],
        }  # fmt: skip
        velocities = [f"velocity.{name}.{axis}" for name in bodies for axis in "xy"]
        names = ("work.contact", "momentum.x", "momentum.y", "angular-momentum", "energy", "push", *velocities)
        return (Job("hit", scene, watch=(series(*names),), work=WORK),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """Momenta are kept whatever the mesh; directions of forces lean by a part of a segment's turn."""
        turn = 0.2 / setup.level  # rad, of a segment
        why = "surfaces are polygons: a force leans by a fraction of the angle between segments, 0.2 at level 1"
        return (
            invariant("linear momentum, change", 1e-12, "forces come in pairs"),
            *self._of_forces(),
            at_most("energy gained", 1e-3, "contact never adds energy; energies of leapfrog are half a step apart"),
            error("tangential over normal impulse, less mu", 0.25 * turn, why),
            at_most(
                "part of the normal speed that is left", 1.0 + 0.1 * turn, f"nothing is gained along the normal; {why}"
            ),
            reported("energy lost"),
        )

    def _of_forces(self) -> tuple[Measure, ...]:
        if self.forces != "consistent":
            facets = "forces lean on facets, by the square of a segment's turn over 20"
            return error("angular momentum, change", 2e-3, facets), reported("largest gift of contact in a step")
        moment = "derivatives of gaps, which no rotation changes, have no moment"
        return (
            invariant("angular momentum, change", 1e-12, moment),
            invariant("largest gift of contact in a step", 1e-9, "what the solve leaves of gaps, times forces"),
        )

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Impulses on the disc that was at rest, along the line of centres at the first touch and across it."""
        found = table(done["hit"])
        n = np.array([np.sqrt(1.0 - 0.25 * self.aside**2), -0.5 * self.aside])
        gained = np.array([found[f"velocity.resting.{axis}"][-1] for axis in "xy"])
        left = np.array([found[f"velocity.flying.{axis}"][-1] for axis in "xy"])
        normal, across = float(gained @ n), abs(float(gained[0] * n[1] - gained[1] * n[0]))
        start = 0.5 * MASS * SPEED**2 + 0.5 * INERTIA * self.spin**2
        spin = found["angular-momentum"]
        return {
            "linear momentum, change": momentum_change(found, MASS * SPEED),
            "angular momentum, change": float(np.abs(spin - spin[0]).max())
            / (INERTIA * self.spin + MASS * SPEED * RADIUS),
            "largest gift of contact in a step": max(0.0, float(np.diff(found["work.contact"]).max())) / start,
            "energy gained": max(0.0, float(found["energy"][-1]) / start - 1.0),
            "tangential over normal impulse, less mu": across / normal - self.mu,
            "part of the normal speed that is left": (normal - float(left @ n)) / (SPEED * float(n[0])),
            "energy lost": 1.0 - float(found["energy"][-1]) / start,
        }
