"""Cost estimate of a run from its trial: seconds per step times steps, with an interval."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from contactlab.explanation.trial_run import CUT, TrialRun
from contactlab.model.model import Model
from contactlab.run.prepare import schedule_of
from contactlab.run.schedule import Schedule
from contactlab.scene.scene import Scene

PERIODS = (1.0, 2.0, 6.0)  # that an explicit run takes to settle after its ramp
ALONE = (2.0, 5.0, 8.0)  # where no contact presses them: kinetic energy has to fall below a thousandth of little
ITERATIONS = (1.0 / 3.0, 1.0, 3.0)  # times the usual number
LINEAR, NONLINEAR = 1.0, 3.0  # usual iterations of a load step without contact
CONTACT, FRICTION = 3.0, 3.0  # and further iterations if a step goes directly to the end
FOLLOWED = 1.0 / 3.0  # of those, where the way is followed in many steps


class Length(NamedTuple):
    """Length of a run: steps, and Newton iterations of all of them (0 in explicit runs)."""

    steps: float
    iterations: float


class Expected(NamedTuple):
    """Something at least, as expected, and at most."""

    least: Length
    usual: Length
    most: Length


def expected_length(scene: Scene, model: Model, schedule: Schedule) -> Expected:
    """Lengths of a run of a scene."""
    if not model.explicit:
        return _implicit(scene, model, schedule)
    timing = model.timing
    if not timing.until_settled:
        steps = schedule.estimated_steps()
        return Expected(*(Length(steps, 0.0) for _ in PERIODS))
    lengths = []
    usual = PERIODS if model.contact is not None else ALONE
    for periods in usual if timing.damping else (math.inf,) * len(usual):
        time = timing.last + min(periods * timing.period, timing.hold)
        lengths.append(Length(time / schedule.first, 0.0))
    return Expected(*lengths)


def _implicit(scene: Scene, model: Model, schedule: Schedule) -> Expected:
    steps = schedule.estimated_steps()
    linear = all(body.material.kinematics == "small" for body in model.bodies)
    rubs = any(contact.friction for contact in scene.contacts)
    more = (CONTACT if model.contact is not None else 0.0) + (FRICTION if rubs else 0.0)
    usual = (LINEAR if linear else NONLINEAR) + more * (1.0 if schedule.skips else FOLLOWED)
    least, expected, most = (max(1.0, usual * factor) * steps for factor in ITERATIONS)
    prescribed = model.prescribed
    moved = bool(np.any(prescribed.values(0.0).copy() != prescribed.values(model.timing.last)))
    if not (scene.loads or scene.effects or moved):
        least = expected = 0.0
    return Expected(*(Length(steps, iterations) for iterations in (least, expected, most)))


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
    """Estimate the cost of a scene by its trial, with its model."""
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
        later = cost * (whole - 1.0)
        ends = [begin.cpu_s + later, *(begin.cpu_s * REPEATED[end] + later * LATER[end] for end in (0, 1))]
        steps, iterations = begin.steps * whole, begin.iterations * whole
        return Estimate(ends[0], ends[1], ends[2], start, begin.memory_mib, steps, iterations, begin.done)
    each = begin.cpu_s / max(1.0, begin.iterations)
    ends = [each * max(part.iterations, part.steps) for part in length]
    return Estimate(*_ordered(ends), start, begin.memory_mib, length.usual.steps, length.usual.iterations, 0.0)


def _ordered(ends: list[float]) -> tuple[float, float, float]:
    """Expected, least and most."""
    return ends[1], min(ends), max(ends)
