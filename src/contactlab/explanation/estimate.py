"""What a run will cost, from its trial: seconds per step times steps, with an interval."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from contactlab.explanation.expected import expected_length
from contactlab.explanation.trial_run import CUT, TrialRun
from contactlab.run.prepare import schedule_of

if TYPE_CHECKING:
    from contactlab.model.model import Model
    from contactlab.scene.scene import Scene

REPEATED = (0.85, 1.15)
"""Times the cost of a run that was made before: by so much two runs of a scene differ."""
EXPLICIT = (0.65, 1.4)
"""Times the cost per step of the first steps: contact grows meanwhile, and frames are not spread evenly."""
LATER = (0.5, 2.0)
"""Times the cost of the load increments that were made, for later ones."""


@dataclass(frozen=True)
class Estimate:
    """Cost of a run as expected, and between bounds that hold for nine runs in ten.

    cpu_s, least_s, most_s  CPU time of its steps [s]
    start_s     wall time of imports and building without compilation [s]
    memory_mib  of the process [MiB]
    steps, iterations  of the whole run; 0 iterations in explicit runs
    done        share of the run that the trial made; 1: it was the whole run
    reason      why the trial says nothing of costs: it failed
    """

    cpu_s: float
    least_s: float
    most_s: float
    start_s: float
    memory_mib: float
    steps: float
    iterations: float
    done: float
    reason: str = ""


def estimate(scene: Scene, model: Model, trial: TrialRun) -> Estimate:
    """What a scene costs by its trial, whose model is given."""
    schedule = schedule_of(model, scene)
    length, begin = expected_length(scene, model, schedule), trial.begin
    start = trial.import_s + trial.build_s - trial.compile_s
    if begin is None or (begin.status == CUT and not begin.steps + begin.iterations):
        each = trial.step_s
        ends = [each * factor * part.steps for factor, part in zip((0.5, 1.0, 2.0), length, strict=True)]
        memory = begin.memory_mib if begin is not None else float("nan")
        return Estimate(ends[1], ends[0], ends[2], start, memory, length.usual.steps, length.usual.iterations, 0.0)
    if begin.status not in ("finished", CUT):
        ends, steps, iterations, reason = [begin.cpu_s] * 3, begin.steps, begin.iterations, begin.reason
        return Estimate(*_ordered(ends), start, begin.memory_mib, steps, iterations, 1.0, f"{begin.status}: {reason}")
    if begin.status == "finished":
        ends = [begin.cpu_s * factor for factor in (REPEATED[0], 1.0, REPEATED[1])]
        return Estimate(*_ordered(ends), start, begin.memory_mib, begin.steps, begin.iterations, 1.0)
    cost = begin.cpu_s - begin.once_s
    if model.explicit:
        rest = [cost / begin.steps * max(0.0, part.steps - begin.steps) for part in length]
        least, most = (begin.cpu_s * REPEATED[end] + rest[2 * end] * EXPLICIT[end] for end in (0, 1))
        steps, done = length.usual.steps, min(1.0, begin.steps / length.usual.steps)
        return Estimate(begin.cpu_s + rest[1], least, most, start, begin.memory_mib, steps, 0.0, done)
    if begin.done > 0.0:
        whole = 1.0 / begin.done
        rest = cost * (whole - 1.0)
        ends = [begin.cpu_s + rest, *(begin.cpu_s * REPEATED[end] + rest * LATER[end] for end in (0, 1))]
        steps, iterations = begin.steps * whole, begin.iterations * whole
        return Estimate(ends[0], ends[1], ends[2], start, begin.memory_mib, steps, iterations, begin.done)
    each = begin.cpu_s / max(1.0, begin.iterations)
    ends = [each * max(part.iterations, part.steps) for part in length]
    return Estimate(*_ordered(ends), start, begin.memory_mib, length.usual.steps, length.usual.iterations, 0.0)


def _ordered(ends: list[float]) -> tuple[float, float, float]:
    """Expected, least and most."""
    return ends[1], min(ends), max(ends)
