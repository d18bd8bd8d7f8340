"""A reference of a scene from its own runs on finer and finer meshes, kept where trials of the same scene find them."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from contactlab.accuracy.point import changed, cost_of, spent_on
from contactlab.accuracy.scene_case import choices_of, may_be_exchanged
from contactlab.accuracy.study import Contender
from contactlab.api import Floats, Job, Record, Setup
from contactlab.cases.run_case import scene_of
from contactlab.errors import ContactlabError
from contactlab.jobs.run import Run
from contactlab.parts.registry import Registry
from contactlab.scene.scene import Scene
from contactlab.studies.make_reference import Curve, holds_for, write_curve
from contactlab.studies.profile import FoldedSurfaceError, Profile, distance, norm
from contactlab.studies.reference import Reference, load_reference
from contactlab.studies.root_edges import with_root_edges
from contactlab.studies.study import FINEST

LEVELS = (2, 4, 8, 16)
KEPT = 2
"""Algorithms with a slave that go on to the third level and beyond: those that change least up to the second."""
MOST_GROWTH = 3.0
"""Power of the level that costs grow with at most, for what the next level will take."""
RATIOS = (1.5, 3.0)
"""Change over the change of the level after it that is believed: of orders from 0.6 to 1.6 with levels of ratio two."""

NEAR = 1e-5
"""Distance of nodes, over the span of a curve, that its file with seven digits keeps apart."""

Said = Callable[[str], None]
"""Called with a line after each run of a reference."""


@dataclass
class _Ladder:
    """The runs of an algorithm with one of the bodies as slave, by level, with their costs [s]."""

    contender: Contender
    swap: bool = False
    curves: dict[int, Profile] = field(default_factory=dict)
    costs: dict[int, float] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Algorithm and slave."""
        return f"{self.contender.algorithm}{', exchanged' if self.swap else ''}"

    def expected(self, level: int) -> float:
        """CPU time [s] of a level from the two before; 0 where none is known."""
        known = sorted(self.costs.items())[-2:]
        if not known:
            return 0.0
        last, cost = known[-1]
        power = MOST_GROWTH
        if len(known) > 1:
            power = math.log(cost / known[0][1]) / math.log(last / known[0][0])
        return float(cost * (level / last) ** min(max(power, 1.0), MOST_GROWTH))


@dataclass(frozen=True)
class Finer:
    """What came of it: no `reference` where no run came to its end, and `why`; `spent` is CPU time of new runs [s]."""

    reference: Reference | None
    file: str
    why: str
    spent: float


def finer_plan(
    scene: Scene, integrator: Any, enough: float, budget: float, folder: Path, registry: Registry, told: Said,
    levels: Sequence[int] = LEVELS,
) -> Generator[Sequence[Run], Sequence[Record], Finer]:  # fmt: skip
    """Runs at `levels`, until the relative error of their mean pressure is below `enough`.

    They begin with every algorithm and either slave; the two that change least for their cost continue to the third
    level and beyond. A level that would take the CPU time of all of them beyond `budget` [s] is not begun.
    """
    ladders = [
        _Ladder(Contender("", "", integrator, name), swap)
        for name in registry.names("contact")
        for swap in (False, True)
        if not swap or may_be_exchanged(scene.data)
    ]
    spent, ends = 0.0, dict[str, str]()
    best: tuple[Curve, float, str] | None = None
    done: list[int] = []
    for level in levels:
        if spent + sum(ladder.expected(level) for ladder in ladders) > budget and best is not None:
            break
        share = max(budget - spent, 0.0) / len(ladders)
        runs, asked = [], []
        for ladder in ladders:
            try:
                runs.append(_run_of(scene, ladder, level, registry, share))
                asked.append(ladder)
            except ContactlabError as error:
                ends[ladder.name] = f"{ladder.name}: {error}"
        records = yield runs
        for ladder, record in zip(asked, records, strict=True):
            cost = cost_of(record)
            spent += share if "cpu_limit" in record.summary else spent_on(record)
            ends[ladder.name] = f"{ladder.name}: {record.status}"
            told(f"reference: {ladder.name}, level {level}: {record.status} in {cost:.3g} s")
            if record.finished and (curve := _curve(record)) is not None:
                ladder.curves[level], ladder.costs[level] = curve, cost
        ladders = [ladder for ladder in ladders if level in ladder.curves]
        if not ladders:
            break
        done.append(level)
        if len(done) > 1:
            ladders = _steadiest(ladders, done)
            best = _mean(ladders, done, scene)
            if best[1] < enough:
                break
    if best is None:
        said = "; ".join(ends.values())
        return Finer(None, "", f"no run at level {levels[len(done)]} has a pressure at its end ({said})", spent)
    path = _written(scene, best, done[-1], folder)
    return Finer(load_reference(str(path)), str(path.resolve()), "", spent)


def _run_of(scene: Scene, ladder: _Ladder, level: int, registry: Registry, limit: float) -> Run:
    """The run of a scene as a contender makes it at a level. Raises ContactlabError."""
    contender = ladder.contender
    setup = Setup(contender.algorithm, ladder.swap, "", contender.integrator, level)
    job = Job("run", dict(scene.data), choices_of(scene.data, setup))
    own = changed(scene_of(job, registry), contender)
    return Run(job, own, f"{scene.name} {ladder.name}", timed=True, cpu_limit=limit)


def _curve(record: Record) -> Profile | None:
    """The last pressure of the first contact, where it is a function of x and is not zero."""
    try:
        found = with_root_edges(Profile.of_curve(record.curve()))
    except FoldedSurfaceError:
        return None
    return found if norm(found) > 0.0 else None


def _steadiest(ladders: Sequence[_Ladder], levels: Sequence[int]) -> list[_Ladder]:
    """Those whose pressure changes least between the last two levels for their cost: errors of order h cost h^-2."""

    def change(ladder: _Ladder) -> float:
        coarse, fine = (ladder.curves[level] for level in levels[-2:])
        return distance(coarse, fine) / norm(fine) * math.sqrt(ladder.costs[levels[-1]])

    return sorted(ladders, key=change)[:KEPT]


def _mean(ladders: Sequence[_Ladder], levels: Sequence[int], scene: Scene) -> tuple[Curve, float, str]:
    """The mean at the finest level with its relative error in L2, and where that comes from in words."""
    mirrored = scene.data.get("symmetry") == "x"
    by_level = [_both([ladder.curves[level] for ladder in ladders], mirrored) for level in levels]
    means = [mean_profile(profiles) for profiles in by_level]
    size = norm(means[-1])
    changes = [distance(coarse, fine) / size for coarse, fine in pairwise(means)]
    apart = max(distance(profile, means[-1]) for profile in by_level[-1]) / size
    change = changes[-1]
    left, said = change, f"the change of their mean from level {levels[-2]}"
    if len(changes) > 1 and change > 0.0:
        ratio = float(np.clip(changes[-2] / change, *RATIOS))
        left, said = change / (ratio - 1.0), f"what is left by Richardson's rule from levels {levels[-3]} on"
    names = " and ".join(ladder.name for ladder in ladders)
    words = f"{names} at level {levels[-1]}; error: the larger of their distance from the mean and {said}"
    x, mean = means[-1].x, means[-1].value
    spread = np.max([np.abs(profile(x) - mean) for profile in by_level[-1]], axis=0)
    return Curve(x, mean, spread, np.abs(means[-2](x) - mean)), max(apart, left), words


def _both(profiles: Sequence[Profile], mirrored: bool) -> list[Profile]:
    """Mirror images of a symmetric scene count as runs, too."""
    return [*profiles, *(profile.mirrored() for profile in profiles if mirrored)]


def mean_profile(profiles: Sequence[Profile]) -> Profile:
    """The mean of piecewise linear functions, on their nodes: of those nearer than NEAR of the span the first.

    Where contact reaches the end of a body the pressure jumps to zero there, at positions that differ from run to run
    by less than that: each of them counts as pressed to the end that is kept.
    """
    x = np.unique(np.concatenate([profile.x for profile in profiles]))
    near = NEAR * (x[-1] - x[0])
    x = x[np.r_[True, np.diff(x) > near]]
    return Profile(x, np.asarray(np.mean([_up_to_end(profile, x, near) for profile in profiles], axis=0)))


def _up_to_end(profile: Profile, x: Floats, near: float) -> Floats:
    """Values at x; those at its ends up to `near` beyond them."""
    inside = np.clip(x, profile.x[0], profile.x[-1])
    return np.asarray(np.where(np.abs(x - inside) <= near, profile(inside), 0.0))


def _written(scene: Scene, best: tuple[Curve, float, str], level: int, folder: Path) -> Path:
    """The reference as a JSON file beside its curve."""
    curve, error, words = best
    place = folder / FINEST
    place.mkdir(parents=True, exist_ok=True)
    write_curve(curve, place / f"{FINEST}.csv")
    description = {
        "format": 1, "name": FINEST, "title": f"{scene.name}, from finer meshes", "curve": f"{FINEST}.csv",
        "columns": {"x": "x_deformed_mm", "pressure": "p_MPa", "spread": "p_spread_MPa"}, "level": level,
        "error_estimate": {"pressure": float(f"{error:.2g}"), "meaning": "relative, in L2"},
        "origin": f"Mean pressure of {words}.", "holds_for": holds_for(scene.data),
    }  # fmt: skip
    path = place / f"{FINEST}.json"
    path.write_text(json.dumps(description, indent=2) + "\n", encoding="utf-8")
    return path
