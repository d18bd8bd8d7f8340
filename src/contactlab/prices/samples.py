"""The short runs that prices are found from: two blocks, with one part exchanged or added at a time.

A stage finds the prices of all units that its samples have and no stage before it found.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from contactlab.parts.registry import Registry
from contactlab.prices.counts import CONJUGATE_FRICTION
from contactlab.scene.scene import Scene, load_scene
from contactlab.testing.examples import example_spec

FILE = Path(__file__).resolve().parents[1] / "data" / "prices" / "two-blocks.toml"

Changes = dict[str, Any]


@dataclass(frozen=True)
class Sample:
    """A run: what it changes in the scene of two blocks; of explicit runs its steps; and its frames."""

    changes: Changes
    steps: int = 0
    frames: int = 5


@dataclass(frozen=True)
class Stage:
    """Samples that measure a part, told as "element NAME"; they are made when the stage is reached."""

    part: str
    samples: Callable[[], Sequence[Sample]]


def base_scene(registry: Registry) -> Scene:
    """Two blocks that are pressed together, explicit, without recorders."""
    return load_scene(FILE, registry)


def cells(along: int, across: int) -> dict[str, Any]:
    """Meshes of both blocks: so many cells along their contact, and across it."""
    return {"bodies.upper.mesh.cells": [along, across], "bodies.lower.mesh.cells": [max(1, along - 1), across]}


APART: Changes = {"contacts": []}
FLOWS = {"yield_stress": 0.05, "strength": 0.05}  # of laws that have one: all of the blocks flows

SMALL, LARGE = cells(8, 4), cells(60, 30)


class Stages:
    """All stages of the parts in a registry."""

    def __init__(self, registry: Registry) -> None:
        self.registry, self.base = registry, base_scene(registry)
        self.explicit = self._class("integrator", self.base.integrator["use"]).needs
        self.of_base = {
            "element": self.base.bodies["upper"].element["use"],
            "material": self.base.materials["metal"]["use"],
            "contact": self.base.contacts[0].algorithm["use"],
            "integrator": self.base.integrator["use"],
        }

    def gauges(self) -> dict[str, float]:
        """Units that count together with others: they are part of those, and have no price of their own."""
        own = self.of_base
        return {
            f"material {own['material']}: point": 0.0,
            f"material {own['material']}: iteration's point": 0.0,
            f"element {own['element']}: iteration's cell": 0.0,
            f"integrator {own['integrator']}: node": 0.0,
        }

    def __iter__(self) -> Iterator[Stage]:
        """Explicit runs first, then those in load steps."""
        yield Stage(f"integrator {self.of_base['integrator']}", self._explicit_core)
        conjugate = "forces" in self._class("integrator", self.of_base["integrator"]).__dataclass_fields__
        if conjugate:
            yield Stage("conjugate forces", lambda: self._conjugate({}))
        yield from self._parts({}, 1500, 80)
        if conjugate and (rubs := self._rubs()):
            yield Stage(CONJUGATE_FRICTION, lambda: self._conjugate(rubs))
        yield from self._stage("integrator", self._integrators(explicit=True), self._integrator)
        yield from self._recorders({}, self._recorder)
        for number, name in enumerate(self._integrators(explicit=False)):
            given = {"integrator": {"use": name}, "time.step": 2.5e-5, "time.history": True}
            samples = self._other_implicit if number else self._implicit_core
            yield Stage(f"integrator {name}", lambda given=given, samples=samples: samples(given))  # type: ignore[misc]
            if number == 0:
                yield from self._parts(given, 0, 0)
                yield from self._recorders(given, self._implicit_recorder)

    def _class(self, kind: str, name: str) -> Any:
        return self.registry.part_class(kind, name)

    def _spec(self, kind: str, name: str, key: str = "") -> dict[str, Any]:
        """The part with usual values; of a law those of the scene where it has the same."""
        own = dict(self.base.materials["metal"]) | FLOWS if kind == "material" else {}
        fields = self._class(kind, name).__dataclass_fields__
        given = {field: value for field, value in own.items() if field in fields}
        return example_spec(self.registry, kind, name, given)

    def _integrators(self, explicit: bool) -> list[str]:
        names = [n for n in self.registry.names("integrator") if n != self.of_base["integrator"]]
        own = [n for n in names if (self._class("integrator", n).needs is self.explicit) == explicit]
        return sorted(own, key=lambda name: self._class("integrator", name).inertia)

    def _stage(
        self, kind: str, names: Sequence[str], samples: Callable[[str, str], Sequence[Sample]]
    ) -> Iterator[Stage]:
        for name in names:
            yield Stage(f"{kind} {name}", lambda name=name: samples(kind, name))  # type: ignore[misc]

    # --- core ---------------------------------------------------------------------------------------

    def _tower(self) -> dict[str, Any]:
        """Four blocks more on top of the two, with a contact each."""
        contact, upper = self.base.data["contacts"][0], self.base.data["bodies"]["upper"]
        found: dict[str, Any] = {"contacts": [contact]}
        for number in range(4):
            below = f"block{number - 1}" if number else "upper"
            y = [5.0 + 4.0 * number, 9.0 + 4.0 * number]
            mesh = dict(upper["mesh"], x=[1.0, 9.0], y=y, cells=[7 + number % 2, 4])
            found[f"bodies.block{number}"] = dict(upper, mesh=mesh)
            found["contacts"].append(dict(contact, slave=f"block{number}.bottom", master=f"{below}.top"))
        return found | {"supports.1": {"on": "block3.top", "ux": 0.0, "uy": {"ramp": "linear", "to": -0.002}}}

    def together(self) -> list[Sample]:
        """Explicit runs with many parts at once: what parts cost beside each other, they do not quite cost alone."""
        records = {"record.recorders": [{"use": name} for name in self._usual_recorders()]}
        rubs = self._rubs()
        return [
            Sample(SMALL | records, 4000, 30),
            Sample(self._tower() | records, 2000, 30),
            Sample(SMALL | rubs | records, 3000, 30),
            Sample(cells(30, 15) | records, 1500, 20),
        ]

    def _rubs(self) -> Changes:
        """Friction by the first law that is installed; nothing where there is none."""
        laws = self.registry.names("friction")
        return {"contacts.0.friction": self._spec("friction", laws[0])} if laws else {}

    def _usual_recorders(self) -> list[str]:
        names = [name for name in self.registry.names("recorder") if self._class("recorder", name).by_default]
        return sorted(names, key=lambda name: not self._class("recorder", name).stores_results)

    def _explicit_core(self) -> list[Sample]:
        wide, tower, upper = cells(120, 3), self._tower(), self.base.data["bodies"]["upper"]
        load = {"loads": [{"on": "upper.left", "tx": 1.0}]}
        return [
            Sample(APART | SMALL, 3000),
            Sample(APART | SMALL, 200),
            Sample(APART | SMALL, 100, 50),
            Sample(APART | LARGE, 150),
            Sample(APART | LARGE, 40, 40),
            Sample(APART | {"bodies": {"upper": upper}, "supports": []}, 3000),
            Sample(APART | {"bodies": {"upper": upper}, "supports": []}, 100, 50),
            Sample(APART | SMALL | load, 3000),
            Sample(SMALL, 2000),
            Sample(wide, 500),
            Sample(tower, 2000),
            Sample(wide, 60, 60),
            Sample(SMALL, 100, 50),
            Sample(tower, 100, 50),
        ]

    def _conjugate(self, more: Changes) -> list[Sample]:
        given = more | {"integrator": {"use": self.of_base["integrator"], "forces": "consistent"}}
        return [Sample(SMALL | given, 1500), Sample(cells(120, 3) | given, 320)]

    def _implicit_core(self, given: Changes) -> list[Sample]:
        bend, tower = given | cells(40, 20), self._tower() | given
        many = {"time.step": 5e-6}
        return [
            Sample(cells(4, 2) | given | APART),
            Sample(cells(4, 2) | given | APART | many),
            Sample(LARGE | given | APART),
            Sample(cells(30, 15) | given | APART),
            Sample(SMALL | given),
            Sample(SMALL | given | many, frames=20),
            Sample(cells(120, 2) | given),
            Sample(bend),
            Sample(tower),
            Sample(SMALL | given, frames=1),
            Sample(bend, frames=1),
            Sample(tower, frames=1),
        ]

    def _other_implicit(self, given: Changes) -> list[Sample]:
        return [
            Sample(cells(4, 2) | given | APART | {"time.step": 5e-6}),
            Sample(LARGE | given | APART),
            Sample(cells(30, 15) | given | APART),
            Sample(SMALL | given),
            Sample(given | cells(40, 20)),
        ]

    # --- parts --------------------------------------------------------------------------------------

    def _parts(self, given: Changes, many: int, few: int) -> Iterator[Stage]:
        """Stages of elements, laws, algorithms, friction, enforcement and effects; steps of small and large samples."""
        small, wide, large = (SMALL, cells(120, 3), LARGE) if many else (SMALL, cells(80, 2), cells(30, 15))

        def both(key: str) -> Callable[[str, str], list[Sample]]:
            def samples(kind: str, name: str) -> list[Sample]:
                part = {key: self._spec(kind, name)}
                return [Sample(small | given | part, many), Sample(wide | given | part, 4 * few)]

            return samples

        def elements(kind: str, name: str) -> list[Sample]:
            part = {f"bodies.{body}.element": self._spec(kind, name) for body in ("upper", "lower")}
            return [Sample(APART | large | given | part, few)]

        def laws(kind: str, name: str) -> list[Sample]:
            mesh = cells(24, 12) if many else large  # few enough cells for a wave to reach all of them
            return [Sample(APART | mesh | given | {"materials.metal": self._spec(kind, name)}, 6 * few)]

        def effects(kind: str, name: str) -> list[Sample]:
            part = {"effects": [self._spec(kind, name)]}
            return [Sample(APART | small | given | part, many), Sample(APART | large | given | part, few)]

        yield from self._stage("element", self._others("element"), elements)
        yield from self._stage("material", self._others("material"), laws)
        yield from self._stage("contact", self._others("contact"), both("contacts.0.algorithm"))
        yield from self._stage("friction", self.registry.names("friction"), both("contacts.0.friction"))
        yield from self._stage("enforcement", self._enforcements(bool(many)), both("contacts.0.enforcement"))
        yield from self._stage("effect", self.registry.names("effect"), effects)

    def _others(self, kind: str) -> list[str]:
        return [name for name in self.registry.names(kind) if name != self.of_base[kind]]

    def _enforcements(self, explicit: bool) -> list[str]:
        names = self.registry.names("enforcement")
        return [name for name in names if issubclass(self._class("enforcement", name), self.explicit) == explicit]

    def _integrator(self, kind: str, name: str) -> list[Sample]:
        part = {"integrator": self._spec(kind, name)}
        return [Sample(APART | SMALL | part, 1500), Sample(APART | LARGE | part, 60), Sample(SMALL | part, 1500)]

    # --- recorders ----------------------------------------------------------------------------------

    def _recorders(self, given: Changes, samples: Callable[[Changes], Sequence[Sample]]) -> Iterator[Stage]:
        """Each recorder beside the usual ones before it, as they share what they ask of a step."""
        names = self.registry.names("recorder")
        names.sort(key=lambda name: not self._class("recorder", name).stores_results)
        before: list[dict[str, str]] = []
        for name in names:
            part = given | {"record.recorders": [*before, {"use": name}]}
            yield Stage(f"recorder {name}", lambda part=part: samples(part))  # type: ignore[misc]
            if self._class("recorder", name).by_default:
                before.append({"use": name})

    def _recorder(self, part: Changes) -> list[Sample]:
        wide, tower = cells(120, 3), self._tower()
        return [
            Sample(APART | SMALL | part, 3000),
            Sample(APART | SMALL | part, 100, 2),
            Sample(APART | LARGE | part, 30, 30),
            Sample(APART | SMALL | part, 100, 50),
            Sample(SMALL | part, 1500),
            Sample(tower | part, 1500),
            Sample(SMALL | part, 100, 50),
            Sample(tower | part, 100, 50),
            Sample(wide | part, 600),
        ]

    def _implicit_recorder(self, part: Changes) -> list[Sample]:
        return [
            Sample(SMALL | part),
            Sample(LARGE | part | APART),
            Sample(SMALL | part, frames=1),
            Sample(cells(80, 2) | part),
        ]
