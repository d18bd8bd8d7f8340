"""Progress of the loading of a static run, so that load steps can be of equal size."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from contactlab.api import Floats
from contactlab.model.loading.declared import courses_in, declared_in
from contactlab.model.loading.ramps import smooth
from contactlab.model.model import Model
from contactlab.model.timing import Timing
from contactlab.run.swings import Swing
from contactlab.scene.scene import Scene

SAMPLES = 1024
EACH_LEG = 17  # samples between two corners of a loading that goes to and fro
IN_TIME = 10  # steps in time of each way
NEARLY = 1e-9  # of the whole time: differences below it are round-off
JUMP = 0.05  # of the largest load: less is no jump
AT_ONCE = 0.1  # of a step: loads that change within it jump
APART = 1e-3  # of a step: jumps that are closer are one
LEAST = 1e-3  # of the whole path that time itself counts, so that a hold is passed in few steps


class LoadPath:
    """Fraction of the loading (0 to 1) as a function of time, and back.

    Between two times the loading advances by the largest change of any prescribed displacement, over the range
    of that displacement, of any load, over the largest load, or of what is left of overlaps that are pushed out.
    Inertia plays no part in statics: the accuracy of a step depends on its load increment, not on its duration.
    Laws that depend on rate are the exception: time then counts as much as load.

    A step must end where the loading turns a corner: the state there depends on the path (friction, flow).

    parameter
             quantity that steps are equal parts of, in words
    length   of the loading, a way from end to end of a value counting 1
    """

    def __init__(self, model: Model, scene: Scene, swings: list[Swing]) -> None:
        end = model.timing.last
        rated = rate_dependent(model)
        self.parameter = f"loading and time: material of {', '.join(rated)} is rate-dependent" if rated else "loading"
        self.corners = corners(scene, model.timing, swings)
        self.times: Floats = np.linspace(0.0, end, SAMPLES + 1)
        share = np.full(SAMPLES, 1.0 / SAMPLES)
        if swings:
            legs = [np.linspace(a, b, EACH_LEG) for a, b in pairwise([0.0, *self.corners])]
            self.times = np.unique(np.concatenate([self.times, *legs]))
            share = np.diff(self.times) / end
        change = (1.0 if rated else LEAST) * share
        np.maximum(change, _motion(model, self.times), out=change)
        np.maximum(change, _loads(model, self.times), out=change)
        for duration in relaxed_overlaps(scene, model.timing.ramp):
            np.maximum(change, np.diff([smooth(duration)(float(time)) for time in self.times]), out=change)
        self.fractions: Floats = np.concatenate([[0.0], np.cumsum(change)])
        self.length = float(self.fractions[-1])
        self.fractions /= self.length

    def fraction(self, time: float) -> float:
        """Fraction of the loading that is done at a time [s]."""
        return float(np.interp(time, self.times, self.fractions))

    def time(self, fraction: float) -> float:
        """When that much of the loading is done [s]."""
        return float(np.interp(fraction, self.fractions, self.times))

    def stop(self, time: float) -> float:
        """The next corner of the loading after a time [s], or its end."""
        return _next(self.corners, time)


class TimePath:
    """The loading of runs in which time matters: time itself, in more steps where a value goes to and fro fast.

    number   of steps of the whole run; without `swings` the equal ones that are wished
    corners  at which a step must end, the last at the end of the run: without inertia the path counts
    """

    parameter = "time"

    def __init__(self, end: float, wished: float, swings: list[Swing], corners: Sequence[float] = ()) -> None:
        self.end, self.number, self.corners = end, wished, corners or (end,)
        if not swings:
            self.times = self.fractions = np.zeros(0)
            return
        ways = np.concatenate([np.zeros((0, 2)), *(_followed(swing, AT_ONCE * end / wished) for swing in swings)])
        self.times = np.unique(np.concatenate([[0.0, end], ways.ravel()]))
        rate = np.full(len(self.times) - 1, wished / end)
        middle = 0.5 * (self.times[1:] + self.times[:-1])
        for first, last in ways.tolist():
            inside = (middle > first) & (middle < last)
            np.maximum(rate, IN_TIME / (last - first), out=rate, where=inside)
        steps = np.concatenate([[0.0], np.cumsum(rate * np.diff(self.times))])
        self.number = float(steps[-1])
        self.fractions = steps / steps[-1]

    def fraction(self, time: float) -> float:
        """Fraction of all steps that is done at a time [s]."""
        even = time >= self.end or not len(self.times)
        return time / self.end if even else float(np.interp(time, self.times, self.fractions))

    def time(self, fraction: float) -> float:
        """When that much of all steps is done [s]."""
        even = fraction >= 1.0 or not len(self.times)
        return fraction * self.end if even else float(np.interp(fraction, self.fractions, self.times))

    def stop(self, time: float) -> float:
        """The next corner after a time [s], or the end."""
        return _next(self.corners, time)


def _next(corners: Sequence[float], time: float) -> float:
    return next((corner for corner in corners if corner > time + NEARLY * corners[-1]), corners[-1])


def rate_dependent(model: Model) -> list[str]:
    """Names of the bodies whose law depends on rate."""
    return [body.name for body in model.bodies if body.material.rate_dependent]


def relaxed_overlaps(scene: Scene, ramp_time: float) -> list[float]:
    """Durations [s] over which contacts relax overlaps of the start."""
    return [spec.start.duration or ramp_time for spec in scene.contacts if spec.start.overlap == "ramp"]


def corners(scene: Scene, timing: Timing, swings: list[Swing]) -> list[float]:
    """Times [s] in (0, end] at which the loading may turn: values or their speeds jump, or go back, overlaps are out.

    The last is the end.
    """
    end = timing.last
    times = {time for _, _, course in courses_in(scene) for time in course.corners(timing.ramps)}
    times |= {one.end for one in declared_in(scene, timing.ramps)}
    times |= {time for swing in swings for time in swing.turns.tolist()}
    found: list[float] = []
    for time in sorted(times):
        if NEARLY * end < time < (1.0 - NEARLY) * end and (not found or time - found[-1] > NEARLY * end):
            found.append(time)
    return [*found, end]


def _followed(swing: Swing, short: float) -> Floats:
    """Ways (w, 2) [s] of a value that steps follow: not jumps of loads, made within a `short` time [s] to last longer.

    Steps end at jumps (`load_jumps`). A load that comes and goes within a short time is followed.
    """
    if not swing.key.startswith("loads."):
        return swing.ways
    jumps = np.diff(swing.ways)[:, 0] <= short
    lasts = np.append(swing.ways[1:, 0], np.inf) - swing.ways[:, 1] > short
    spikes = np.flatnonzero(jumps[:-1] & jumps[1:] & ~lasts[:-1])
    jumps[spikes] = jumps[spikes + 1] = False
    return np.asarray(swing.ways[~jumps])


def load_jumps(scene: Scene, timing: Timing, step: float) -> dict[float, bool]:
    """Times [s] in (0, end) right before a load changes within much less than a step [s]; whether it drops there.

    A load that drops sets off waves. One that changes its sign drops to zero and rises again. No two times are so
    close, nor one so close to the end, that the step between them has no equilibrium but for round-off.
    """
    found: list[tuple[float, bool]] = []
    for key, _, course in courses_in(scene):
        if key.startswith("loads.") and course.moves:
            value, times = course.bind(timing.ramps), [t for t in course.corners(timing.ramps) if 0.0 < t < timing.last]
            sides = []
            for time in times:
                before = time - 0.5 * NEARLY * timing.last
                near = [other for other in times if time <= other < time + AT_ONCE * step]
                sides.append((before, value(before), [value(t) for t in (*near, time + AT_ONCE * step)]))
            least = JUMP * max((abs(one) for _, here, then in sides for one in (here, *then)), default=0.0)
            for before, here, then in sides:
                if max(abs(one - here) for one in then) > least:
                    found.append((before, abs(here) - max(0.0, min(np.sign(here) * one for one in then)) > least))
    jumps: dict[float, bool] = {}
    for time, drops in sorted(found):
        last = next(reversed(jumps), 0.0)
        if time - last > APART * step:
            if timing.last - time > APART * step:
                jumps[time] = drops
        elif jumps:
            jumps[last] |= drops
    return jumps


def _motion(model: Model, times: Floats) -> Floats:
    """Largest relative change of a prescribed displacement in each interval."""
    values = np.array([model.prescribed.values(float(time)).copy() for time in times])
    span = np.ptp(values, axis=0)
    moving = span > 1e-12 * max(float(np.abs(values).max(initial=0.0)), 1e-300)
    if not moving.any():
        return np.zeros(len(times) - 1)
    return np.asarray(np.abs(np.diff(values[:, moving], axis=0) / span[moving]).max(axis=1))


def _loads(model: Model, times: Floats) -> Floats:
    """Largest change of a nodal load over the largest load, at the undeformed positions."""
    out = np.zeros_like(model.reference)
    if not model.external_force(0.0, out):
        return np.zeros(len(times) - 1)
    before, changes, largest = out.copy(), [], float(np.abs(out).max())
    for time in times[1:]:
        model.external_force(float(time), out)
        changes.append(float(np.abs(out - before).max()))
        largest = max(largest, float(np.abs(out).max()))
        before[:] = out
    return np.array(changes) / largest if largest > 0.0 else np.zeros(len(times) - 1)
