"""The cost breakdown: what each effect of a scene costs, and what leaving it out changes in the answer."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from contactlab.api import Floats, Record
from contactlab.errors import RequestError
from contactlab.parts.registry import Registry
from contactlab.results.force_curve import THE_END_ONLY
from contactlab.scene.scene import Scene
from contactlab.studies.measure_run import applied_share, carried_load, driven_support, without_compilation
from contactlab.studies.plan import Combination, Plan, compared_scene, find_scene
from contactlab.studies.profile import FoldedSurfaceError, Profile, distance, norm
from contactlab.studies.removable import Variant, variants
from contactlab.studies.study import Study

BASE = "as declared"
INSTANTS = 201  # of the loading, at which histories are compared


@dataclass(frozen=True)
class EffectCost:
    """Cost of one effect, and its change of the answer.

    declared   False: the scene leaves it out, and it was added to be measured
    step_s     what it costs in each step, CPU [s]; NaN if the runs cannot be compared step by step
    run_s      what it costs in the whole run, CPU [s]
    memory_mib what its arrays need
    reaction, pressure, energy  what leaving it out changes: of the force and of the internal energy over the
               whole loading (at its end, if the runs have no loading in common), and of the final pressure, L2
               norms relative to the run that has the effect
    status     of the run without it (or with it, if it is not declared), and the reason if it did not finish
    """

    effect: str
    declared: bool
    step_s: float = math.nan
    run_s: float = math.nan
    memory_mib: float = math.nan
    reaction: float = math.nan
    pressure: float = math.nan
    energy: float = math.nan
    status: str = "refused"
    reason: str = ""

    @property
    def error(self) -> float:
        """The largest of the changes in the answer, NaN if none is known."""
        known = [value for value in (self.reaction, self.pressure, self.energy) if not math.isnan(value)]
        return max(known, default=math.nan)


@dataclass(frozen=True)
class CostBreakdown:
    """Costs of effects in the order of the variants, with the cost of the scene as declared.

    step_s, run_s CPU time [s]; memory_mib of its arrays; status, reason of the run as declared
    """

    step_s: float
    run_s: float
    memory_mib: float
    steps: float
    status: str
    reason: str
    effects: Sequence[EffectCost]


@dataclass(frozen=True)
class BreakdownPlan(Plan):
    """The runs of a breakdown: the scene as declared, a run for each variant, and the variants that are refused."""

    shown: Mapping[str, Variant]
    refused: Sequence[EffectCost]


def plan_breakdown(
    request: Scene | Study | str | Any, registry: Registry | None = None, changes: Mapping[str, Any] | None = None
) -> BreakdownPlan:
    """Plan the runs for the breakdown of a scene. Raises RequestError if nothing can be taken out or added."""
    study, scene = find_scene(request, registry)
    scene = scene.with_(changes or {})
    found = variants(scene)
    jobs, shown, refused = [_job("1-as-declared", scene, BASE)], {}, []
    for variant in found:
        try:
            changed = scene.with_(variant.changes)
        except RequestError as error:
            refused.append(EffectCost(variant.effect, variant.declared, reason=str(error)))
            continue
        name = f"{len(jobs) + 1}-{variant.label.replace(' ', '-')}"
        shown[name] = variant
        jobs.append(_job(name, changed, variant.label))
    if not found:
        raise RequestError("the scene has no effect that could be taken out", where=scene.origin.file or scene.name)
    own = Study(scene=study.scene, name=f"{scene.name}: costs of its effects", repeat=study.repeat)
    return BreakdownPlan(own, scene, 0, jobs, shown, refused)


def _job(name: str, scene: Scene, label: str) -> Combination:
    """Make the job of one variant; it has no partner."""
    contact = scene.contacts[0] if scene.contacts else None
    algorithm = contact.algorithm["use"] if contact is not None else "no contact"
    slave = contact.sides[0].partition(".")[0] if contact is not None else ""
    choice = {"effect": label}
    return Combination(name, compared_scene(scene), choice, choice, algorithm, slave, partner=name, refines=False)


def breakdown_of(plan: BreakdownPlan, records: Mapping[str, Record]) -> CostBreakdown:
    """The cost breakdown from the records of all its runs."""
    base = records[plan.jobs[0].name]
    effects = [
        _cost(plan.shown[job.name], plan, base, records[job.name], job) for job in plan.jobs if job.name in plan.shown
    ]
    costs = _costs(base)
    return CostBreakdown(
        *costs, base.summary.get("steps", math.nan), base.status, base.reason, [*effects, *plan.refused]
    )


def _costs(record: Record) -> tuple[float, float, float]:
    """CPU seconds of a step and of the run without the compiling and loading of kernels, and MiB of arrays."""
    cost = record.summary.get("cost", {})
    run = max(0.0, without_compilation(cost, "run_cpu_s"))  # empty if a run left no cost
    steps = record.summary.get("steps", 0)
    return run / steps if steps else math.nan, run, float(cost.get("arrays_mib", math.nan))


def _cost(variant: Variant, plan: BreakdownPlan, base: Record, other: Record, job: Combination) -> EffectCost:
    rich, poor = (base, other) if variant.declared else (other, base)
    step, run, memory = (a - b for a, b in zip(_costs(rich), _costs(poor), strict=True))
    if _implicit(rich) != _implicit(poor):
        step = math.nan  # a load step is not a time step
    named = (variant.effect, variant.declared)
    if not all(carried_load(run.status, applied_share(run.summary)) for run in (base, other)):
        return EffectCost(*named, step, status=other.status, reason=other.reason)
    # change of the driven support's force, or of the first contact's if nothing is supported
    scene = plan.scene if variant.declared else job.scene
    reactions = {on: np.asarray(force) for on, force in rich.summary.get("reactions", {}).items()}
    where = driven_support(scene.data, reactions) or ("contacts.0" if scene.contacts else "")
    reaction = _change_of(rich, poor, tuple(f"{where}.{component}" for component in ("fx", "fy")) if where else ())
    changes = reaction, _pressure(rich, poor), _change_of(rich, poor, ("energy.internal",))
    return EffectCost(*named, step, run, memory, *changes, other.status, other.reason)


def _implicit(record: Record) -> bool:
    return bool(record.summary.get("iterations"))


# --- changes of the answer ----------------------------------------------------------------------


def _change_of(rich: Record, poor: Record, columns: Sequence[str]) -> float:
    """Change of columns of the history over the loading.

    Only at the end if one of the runs is right only there, or if one takes load steps and the other starts gently.
    """
    whole = _implicit(rich) == _implicit(poor) and not any(
        one.summary.get("history", {}).get("curve") == THE_END_ONLY for one in (rich, poor)
    )
    course = _course if whole else _end
    return _change([course(rich, name) for name in columns], [course(poor, name) for name in columns])


def _course(record: Record, column: str) -> Floats:
    """A column of the history over the loading, from 0 to its end; zero if it does not exist."""
    if column not in record.history:
        return np.zeros(INSTANTS)
    time, values = (np.asarray(record.history[name]) for name in ("time", column))
    whole = record.summary.get("resolved", {}).get("ramp") or time[-1]
    return np.interp(np.linspace(0.0, 1.0, INSTANTS), time / whole, values)


def _end(record: Record, column: str) -> Floats:
    """The last entry of a column (1,), zero if it does not exist."""
    return np.asarray(record.history.get(column, np.zeros(1)))[-1:]


def _change(rich: Sequence[Floats], poor: Sequence[Floats]) -> float:
    """L2 norm of the difference over the L2 norm of the richer run; NaN if that is zero."""
    if not rich:
        return math.nan
    whole, difference = np.stack(rich), np.stack(rich) - np.stack(poor)
    size = float(np.linalg.norm(whole))
    return float(np.linalg.norm(difference)) / size if size > 0.0 else math.nan


def _pressure(rich: Record, poor: Record) -> float:
    """Change of the final pressure of the first contact; 1 if the other run has no contact."""
    try:
        profiles = [Profile.of_curve(r.curve()) if r.curves.get("contacts.0") else None for r in (rich, poor)]
    except FoldedSurfaceError:
        return math.nan
    own, other = profiles
    size = norm(own) if own is not None else 0.0
    if own is None or not size > 0.0:
        return math.nan
    return distance(own, other) / size if other is not None else 1.0
