"""Sources of the error of a run: changes by a finer mesh, time step, ramp, element and so on, one at a time.

A result that lies off by C h^q changes by C h^q (1 - 2^-q) when h is halved, so that a change tells what part of the
error one choice of numerics brings (Richardson 1911). Orders are those of theory, the lowest where it knows several.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from contactlab.accuracy.configuration import exchangeable
from contactlab.accuracy.judged import ForcesJudged, Judge, forces_of, moves
from contactlab.api import ExplicitIntegrator, Job, Record
from contactlab.errors import RequestError
from contactlab.jobs.run import Run
from contactlab.parts.registry import Registry
from contactlab.run.attempts import as_taken
from contactlab.scene.scene import Scene
from contactlab.studies.measure_run import without_compilation
from contactlab.studies.recordings import RUNS

AS_IT_IS = "as it is"
WHOLE = 30.0
"""Order of what does not converge: the change is all of the error."""
UNRESOLVED = 0.5
"""Part of a pressure or force from which on a change is no estimate: the run as it is does not resolve it."""
SCATTER = 0.12
"""Part of the cost of a single run that is taken for scatter."""


@dataclass(frozen=True)
class Knob:
    """Choice of numerics and the scene keys that make it finer; `order` is the order of its error.

    exchanged  numbers of the contacts whose other side is the slave: nobody knows which of the two is the finer choice
    element    whether it changes elements
    """

    name: str
    settings: Mapping[str, Any]
    order: float
    exchanged: tuple[int, ...] = ()
    element: bool = False


@dataclass(frozen=True)
class Share:
    """Effect of one knob. Numbers that a run did not give are NaN.

    pressure   part of the error of the contact pressures in L2, as a fraction, the largest of all contacts
    force      part of that of the reactions and contact forces
    cost       CPU time of the finer run [s]; extra: beyond that of the run as it is
    away       whether it comes no nearer to the run on the finer mesh: an element that trades one error for another
    """

    knob: Knob
    status: str
    reason: str
    pressure: float
    force: float
    cost: float
    extra: float
    away: bool = False

    @property
    def resolved(self) -> bool:
        """Return whether the change is small enough to give the part of the error."""
        return not self.part >= UNRESOLVED

    @property
    def part(self) -> float:
        """Part of the pressure's error, of the force's where there is no pressure to compare."""
        return self.force if math.isnan(self.pressure) else self.pressure

    @property
    def gain(self) -> float:
        """Error taken off per CPU second that it costs more; what is within the scatter counts as that.

        Else a knob that changes next to nothing would come first whenever its run happens to be the faster one.
        """
        less = self.part * (1.0 - 0.5**self.knob.order)
        extra = max(self.extra, SCATTER * (self.cost - self.extra))
        return less / extra if extra > 0.0 else math.inf


@dataclass(frozen=True)
class ErrorBudget:
    """All shares, the largest first, beside the run as it is."""

    status: str
    reason: str
    cost: float
    shares: Sequence[Share]

    @property
    def cheapest(self) -> Share | None:
        """The knob to turn next: the most error for its cost; None where nothing was found."""
        known = [share for share in self.shares if share.part > 0.0 and not (share.knob.exchanged or share.away)]
        return max(known, key=lambda share: (share.gain, share.part), default=None)


Told = Callable[[str], None]


def budget_plan(scene: Scene, registry: Registry, told: Told) -> Generator[Sequence[Any], Sequence[Any], ErrorBudget]:
    """Run the scene as it is, then with each knob turned. Raises RequestError for a scene without contact."""
    if not scene.contacts:
        raise RequestError("the scene has no contact whose pressure could be compared", where=scene.name,
                           allowed="[[contacts]]")  # fmt: skip
    means = moves(scene, registry)
    base = yield from _run_plan(AS_IT_IS, scene, means, told)
    if not base.finished:
        return ErrorBudget(base.status, base.reason, _cost(base), ())
    scene = as_taken(scene, base.summary)
    knobs = knobs_of(scene, base.summary, registry)
    finer = yield [_run_plan(knob.name, scene.with_(dict(knob.settings)), means, told) for knob in knobs]
    judge = Judge()
    judge.pressures(base)  # the lines along which pressures are compared
    shares = [
        replace(_share(knob, base, record, judge), away=_away(knob, base, record, finer[0], judge))
        for knob, record in zip(knobs, finer, strict=True)
    ]
    shares.sort(key=lambda share: -share.part if share.part >= 0.0 else math.inf)
    return ErrorBudget(base.status, base.reason, _cost(base), shares)


def _run_plan(name: str, scene: Scene, means: bool, told: Told) -> Generator[Sequence[Run], Sequence[Record], Record]:
    job = Job(name, "", curves="last", means=means)
    (record,) = yield [Run(job, scene, name, place=f"{RUNS}/{name.replace(' ', '-')}", timed=True)]
    told(f"{name}: {record.status}")
    return record


def knobs_of(scene: Scene, summary: Mapping[str, Any], registry: Registry) -> list[Knob]:
    """Yield everything that can be made twice as fine in a scene; `summary` belongs to the run as it is."""
    kind = registry.part_class("integrator", scene.integrator["use"])
    knobs = [Knob("mesh", {"level": 2 * scene.level}, 1.0)]
    time = scene.data["time"]
    if issubclass(kind, ExplicitIntegrator):
        step = {"time.step": 0.5 * time["step"]} if time.get("step") else {"time.fraction": 0.5 * time["fraction"]}
        knobs.append(Knob("time step", step, 2.0))
        knobs += _pace(time, summary.get("resolved", {}))
    elif kind.inertia or summary.get("history", {}).get("matters"):
        knobs.append(Knob("load steps", {"integrator.steps": 2 * int(summary["steps"])}, 2.0 if kind.inertia else 1.0))
    if "tolerance" in scene.integrator:
        knobs.append(Knob("tolerance", {"integrator.tolerance": 0.5 * scene.integrator["tolerance"]}, 1.0))
    for number, contact in enumerate(scene.data["contacts"]):
        enforcement = contact.get("enforcement") or {}
        if "factor" in enforcement:  # of springs between the surfaces
            setting = {f"contacts.{number}.enforcement.factor": 2.0 * enforcement["factor"]}
            knobs.append(Knob(f"stiffness of {contact.get('name') or f'contacts.{number}'}", setting, 1.0))
    return [*knobs, *_others(scene, registry)]


def _others(scene: Scene, registry: Registry) -> list[Knob]:
    """Elements and materials that have more than those of the scene, and the other slave of each contact."""
    found: list[Knob] = []
    bodies, materials = scene.data["bodies"], scene.data["materials"]
    own = {str(body["element"]["use"]) for body in bodies.values()}
    for name in sorted({n for each in own for n in registry.part_class("element", each).beyond.values()} - own):
        if name in registry.names("element"):
            found.append(
                Knob(f"element {name}", {f"bodies.{body}.element": name for body in bodies}, WHOLE, element=True)
            )
    for name, material in materials.items():
        finite = registry.part_class("material", material["use"]).beyond.get("finite strain")
        if finite in registry.names("material"):
            found.append(Knob(f"finite strain of {name}", {f"materials.{name}.use": finite}, WHOLE))
    for number in exchangeable(scene.data):
        contact = scene.data["contacts"][number]
        setting = {f"contacts.{number}.swap": not contact.get("swap", False)}
        found.append(Knob(f"slave of {contact.get('name') or f'contacts.{number}'}", setting, WHOLE, (number,)))
    return found


def _pace(time: Mapping[str, Any], found: Mapping[str, Any]) -> list[Knob]:
    """Ramp and settling of a quasi-static explicit run: what it found for itself is written out, but for one.

    Half the damping would settle less: what is left of the motion falls with the time that it has.
    """
    if time.get("end") != "auto" or not found:
        damping = time.get("damping")
        return [Knob("damping", {"time.damping": 0.5 * damping}, 1.0)] if damping else []
    own = {f"time.{name}": found[name] for name in ("ramp", "damping", "relaxation") if found.get(name) is not None}
    return [
        Knob("ramp", own | {"time.ramp": 2.0 * found["ramp"]}, 1.0),
        Knob("hold", own | {"time.hold": 2.0 * found["hold"]}, WHOLE),
    ]


def _cost(record: Record) -> float:
    return without_compilation(record.summary.get("cost", {}), "run_cpu_s")


def _share(knob: Knob, base: Record, finer: Record, judge: Judge) -> Share:
    pressure, force = _changes(base, finer, judge, knob.exchanged)
    whole, cost = 1.0 / (1.0 - 0.5**knob.order), _cost(finer)
    return Share(knob, finer.status, finer.reason, whole * pressure, whole * force, cost, cost - _cost(base))


def _away(knob: Knob, base: Record, finer: Record, mesh: Record, judge: Judge) -> bool:
    """Return whether an element leads away from the result of the finer mesh, although both reduce the same error."""
    if not knob.element:
        return False
    before, after = _changes(base, mesh, judge), _changes(finer, mesh, judge)
    n = 1 if math.isnan(before[0]) else 0
    return after[n] >= before[n]


def _changes(base: Record, finer: Record, judge: Judge, exchanged: Sequence[int] = ()) -> tuple[float, float]:
    """Distances of pressures and forces over the size of those of the finer run; nan where there is no such number."""
    if not (base.finished and finer.finished):
        return math.nan, math.nan
    before, after = judge.pressures(base), judge.pressures(finer)
    force = ForcesJudged.apart(forces_of(base), forces_of(finer, exchanged))
    return judge.apart(before, after) if before and after else math.nan, force if math.isfinite(force) else math.nan
