"""Prices of this machine from short runs in quiet moments: rounds over all samples, then the prices stage by stage."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date
from typing import NamedTuple

import numpy as np

from contactlab.errors import RequestError, one_line
from contactlab.model.build import build
from contactlab.model.held_arrays import held_arrays
from contactlab.parts.registry import Registry
from contactlab.prices.counts import counts_of, total
from contactlab.prices.measure import Measured, sample_scene
from contactlab.prices.price_list import PriceList, machine, versions
from contactlab.prices.quiet import Quiet, Timed
from contactlab.prices.samples import Stage, Stages
from contactlab.prices.start import measured_starts
from contactlab.scene.scene import Scene
from contactlab.studies.unit_costs import unit_costs
from contactlab.testing.assertions import NotApplicable

Progress = Callable[[str, float], None]
"""Called with what is measured and the share that is done."""

ROUNDS = 2
MIB = 2.0**20


class Work(NamedTuple):
    """A sample that was run: its counted work, and the memory [MiB] and nodes of its model before the first step."""

    run: Measured
    counts: dict[str, float]
    held_mib: float
    nodes: int


@dataclass
class Trial:
    """The samples of a stage and what they took so far; `reason` why the part cannot be measured, if so."""

    stage: Stage
    scenes: Sequence[Scene] = ()
    best: list[Timed | None] = field(default_factory=list)
    reason: str = ""

    @classmethod
    def of(cls, stage: Stage, base: Scene) -> Trial:
        """The scenes of a stage, where its part can be put into them."""
        try:
            scenes = [sample_scene(base, sample) for sample in stage.samples()]
        except (RequestError, NotApplicable) as error:
            return cls(stage, reason=one_line(error, name=False))
        return cls(stage, scenes, [None] * len(scenes))

    def run(self, quiet: Quiet) -> None:
        """Run every sample once more, and keep the better run."""
        for number, scene in enumerate(self.scenes if not self.reason else ()):
            before = self.best[number]
            try:
                found = quiet.timed(scene)
            except RequestError as error:
                self.reason = one_line(error, name=False)
                return
            self.best[number] = found if before is None or found.better_than(before) else before

    def work(self) -> list[Work]:
        """The samples, once all of them were run."""
        return [_work(scene, one.run) for scene, one in zip(self.scenes, self.best, strict=True) if one is not None]


def _work(scene: Scene, run: Measured) -> Work:
    model = build(scene, scene.registry)
    held = sum(array.bytes for array in held_arrays(model)) / MIB
    return Work(run, counts_of(scene, model, run.length), held, len(model.reference))


def calibrate(registry: Registry, rounds: int = ROUNDS, progress: Progress | None = None) -> PriceList:
    """Measure the prices of all parts in a registry. What cannot be measured is told in `unknown`."""
    stages = Stages(registry)
    together = Trial.of(Stage("many parts together", stages.together), stages.base)
    trials = [*(Trial.of(stage, stages.base) for stage in stages), together]
    quiet = Quiet(registry)
    for number in range(rounds):
        for at, trial in enumerate(trials):
            if progress is not None:
                progress(trial.stage.part, (number + at / len(trials)) / rounds)
            trial.run(quiet)
    units, unknown, done = stages.gauges(), {}, list[Work]()
    for trial in trials[:-1]:
        if trial.reason:
            unknown[trial.stage.part] = trial.reason
        else:
            work = trial.work()
            units |= _fitted(work, units)
            done += work
    start, process = measured_starts(stages.base)
    return PriceList(
        made=date.today().isoformat(),
        machine=machine(),
        versions=versions(),
        units=units,
        unknown={part: reason for part, reason in unknown.items() if not _priced(part, units)},
        start_s=start,
        process_mib=process,
        step_mib=_step_memory(done),
        together=_together(together.work(), units),
    )


def _priced(part: str, units: Mapping[str, float]) -> bool:
    """Whether a part has a price, of explicit or of implicit runs."""
    return any(unit.startswith(f"{part}: ") for unit in units)


def _fitted(work: Sequence[Work], known: Mapping[str, float]) -> dict[str, float]:
    """Prices of the units that samples are the first to have, from what they took beyond known prices."""
    new = [unit for unit in dict.fromkeys(unit for one in work for unit in one.counts) if unit not in known]
    if not new:
        return {}
    cost = np.array([one.run.cpu_s for one in work])
    rest = cost - np.array([total(one.counts, known) for one in work])
    counts = np.array([[one.counts.get(unit, 0.0) for unit in new] for one in work])
    return dict(zip(new, unit_costs(counts, cost, rest).tolist(), strict=True))


def _step_memory(work: Sequence[Work]) -> float:
    """MiB that implicit steps add to the arrays of a model, per N log2 N of N nodes: mean of the samples."""
    found = [(one.run.arrays_mib - one.held_mib) / node_measure(one.nodes) for one in work if one.run.length.iterations]
    return float(np.mean(found)) if found else 0.0


def _together(work: Sequence[Work], units: Mapping[str, float]) -> float:
    """Geometric mean of measured over foreseen cost of runs with many parts; 1 where none could be made."""
    ratios = [one.run.cpu_s / total(one.counts, units) for one in work]
    return float(np.exp(np.mean(np.log(ratios)))) if ratios else 1.0


def node_measure(nodes: int) -> float:
    """N log2 N: what factors of a plane mesh of N nodes take (George 1973)."""
    return nodes * float(np.log2(nodes))
