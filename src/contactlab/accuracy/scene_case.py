"""A scene with a reference, asked as a case: how far is its contact pressure off?"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from contactlab.accuracy.configuration import Configuration, exchangeable
from contactlab.accuracy.study import CaseChoice
from contactlab.api import Answer, Case, Job, Measure, Record, Setup, Solution
from contactlab.api.case import error
from contactlab.errors import RequestError
from contactlab.parts.registry import Registry
from contactlab.scene.scene import load_scene
from contactlab.studies.find_reference import find_reference, matching_reference
from contactlab.studies.measures import pressure_error
from contactlab.studies.profile import Profile
from contactlab.studies.reference import Reference

PRESSURE = "pressure, L2"


@dataclass(frozen=True)
class SceneCase(Case):
    """A scene (`data`: all of its keys) whose first contact's pressure is compared with a reference."""

    data: Mapping[str, Any]
    against: Reference

    title: ClassVar[str] = "a scene against its reference"
    source: ClassVar[str] = ""
    family: ClassVar[str] = "scenes"
    integrators: ClassVar[tuple[str, ...]] = ()
    elements: ClassVar[tuple[str, ...]] = ()

    @classmethod
    def of(cls, choice: CaseChoice, registry: Registry, folder: Path | None) -> SceneCase:
        """The scene of an entry with the reference that it names, or the first that fits. Raises RequestError."""
        beside = (folder or Path()) / choice.scene
        scene = load_scene(beside if beside.is_file() else choice.scene, registry, choice.changes)
        where = f"case {choice.label}"
        if choice.reference:
            source = find_reference(choice.reference, registry, beside=folder, where=where)
            why, found = source.mismatch(scene.data), None
            found = source.at(scene.data) if not why else None
        else:
            found, why = matching_reference(scene.data, registry), "no installed reference holds for it"
        if found is None:
            raise RequestError(f"the scene cannot be measured: {why}", where=where, got=choice.scene,
                               hint="name a reference, or compare the scene with --reference finest")  # fmt: skip
        return cls(scene.data, found)

    def applies(self, setup: Setup) -> str:
        """A rigid surface cannot be the slave."""
        return "a rigid surface cannot be the slave" if setup.swap and 0 not in exchangeable(self.data) else ""

    def plan(self, setup: Setup, done: Mapping[str, Record]) -> Sequence[Job]:
        """The scene with the choices of the setup in all its contacts and bodies."""
        sides = tuple(range(len(self.data["contacts"]))) if setup.swap else ()
        own = Configuration(setup.algorithm, sides, setup.element).changes(self.data, setup.level)
        return () if done else (Job("run", self.data, own | {"integrator": setup.integrator}),)

    def measures(self, setup: Setup) -> Sequence[Measure]:
        """The relative error of the pressure."""
        known = self.against.pressure_uncertainty
        kind: Any = self.against.error_estimate.get("kind", "two-discretisations")
        known = 0.0 if math.isnan(known) else known
        answer = Answer(1.0, kind, known, self.against.title, self.against.level)
        return (error(PRESSURE, math.inf, "it is measured here, not judged", answer=answer),)

    def exact_pressure(self, setup: Setup, done: Mapping[str, Record]) -> Solution | None:
        """Return the pressure of the reference."""
        profile = self.against.profile
        return Solution(profile.x, profile.value, self.against.pressure_uncertainty, window=self.against.window)

    def evaluate(self, setup: Setup, done: Mapping[str, Record]) -> Mapping[str, float]:
        """Compare the pressure at the end with that of the reference."""
        (record,) = done.values()
        profile = Profile.of_curve(record.curve())
        return {PRESSURE: pressure_error(profile, self.against.profile, self.against.window)}
