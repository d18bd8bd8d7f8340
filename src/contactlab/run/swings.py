"""Alternating values in time: where they turn, and whether steps and frames resolve it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from contactlab.api import Floats, RunWarning
from contactlab.model.loading.declared import courses_in
from contactlab.model.loading.load_profile import values_of
from contactlab.model.loading.ramps import Course
from contactlab.model.timing import Timing
from contactlab.scene.scene import Scene

SAMPLES = (1009, 4003, 16033, 64019, 262139)  # of a function between breaks; primes, so that no period fits them all
ALIKE = 1e-3  # of the variation: two sets of samples that see as much have seen all
SMALL = 1e-2  # of the range: turns within it are not followed
LARGE = 0.2  # of the range: smaller ways need not be resolved
EDGE = 0.005  # of a way
AT_ONCE = 1e-4  # of the time to the next way: a value that is made to jump has no course to follow
EACH_WAY = 6  # steps: friction work is then right to 2 % (sliding, and partial slip of a disc), with 4 to 10 %
CURVE = 5  # frames: of fewer nobody draws a curve
SEEN = 2  # frames, or steps without memory, of each way: fewer show a curve of another period


class Swing(NamedTuple):
    """A value that goes to and fro.

    key        of the scene
    turns      (n,) times [s] at which it turns, with the begin and the end of its way
    ways       (w, 2) times [s] between which it moves from one turn to the next, of the larger ways, except
               jumps
    shortest   time [s] of a way over the whole range at the speed of the fastest one; of a jump the time after it,
               until the value moves again
    """

    key: str
    turns: Floats
    ways: Floats
    shortest: float


def swings_of(scene: Scene, timing: Timing) -> list[Swing]:
    """All values of a scene that turn back within the run."""
    end, found = timing.last, []
    for key, _, course in courses_in(scene):
        if course.shape not in ("table", "function") or not course.moves or course.begin >= end:
            continue
        times, values = _samples(course, end)
        turns = _turns(values)
        if len(turns) > 2:
            span = float(np.ptp(values))
            ways = [(_way(times[a : b + 1], values[a : b + 1]), abs(values[b] - values[a]) / span)
                    for a, b in pairwise(turns)]  # fmt: skip
            begins = [*(first for (first, _), _ in ways[1:]), end]
            large = [(way, then, share) for (way, share), then in zip(ways, begins, strict=True) if share > LARGE]
            followed = [way for way, then, _ in large if way[1] - way[0] > AT_ONCE * (then - way[0])]
            shortest = min(((last if (first, last) in followed else then) - first) / share
                           for (first, last), then, share in large)  # fmt: skip
            at = times[turns] if course.function is None else _refined(times, values, turns)
            found.append(Swing(key, at, np.array(followed).reshape(-1, 2), float(shortest)))
    return found


def _samples(course: Course, end: float) -> tuple[Floats, Floats]:
    """Times [s] up to `end` that show every turn of a value, and its values there."""
    if course.function is None:
        points = np.array(course.points)
        times = np.unique(np.clip(course.begin + points[:, 0], 0.0, end))
        return times, np.interp(times, course.begin + points[:, 0], points[:, 1])
    function, where = course.function
    breaks = np.array([course.begin, *(course.begin + t for t in function.breaks()), end])
    breaks = np.unique(np.clip(breaks[np.isfinite(breaks)], course.begin, end))
    before = -1.0
    for count in SAMPLES:
        parts = [np.linspace(a, b, count) for a, b in pairwise(breaks.tolist())]
        times = np.unique(np.concatenate(parts))
        values = values_of(function, times - course.begin, where)
        variation = float(np.abs(np.diff(values)).sum())
        if before > 0.0 and abs(variation - before) <= ALIKE * variation:
            break
        before = variation
    return times, values


def _turns(values: Floats) -> list[int]:
    """Numbers of the samples at which values turn by more than a `SMALL` part of their range, between begin and end."""
    steps = np.diff(values)
    moving = np.flatnonzero(steps)
    if not len(moving):
        return [0]
    signs = np.sign(steps[moving])
    least, kept = SMALL * float(np.ptp(values)), [int(moving[0])]
    best, way = kept[0], 0.0
    for k in (*moving[1:][signs[1:] != signs[:-1]].tolist(), int(moving[-1]) + 1):
        change = float(values[k] - values[best])
        if change * way > 0.0 or (way == 0.0 and abs(change) > least):
            best, way = k, way or change
        elif way and abs(change) > least:
            kept.append(best)
            best, way = k, change
    return [*kept, best]


def _way(times: Floats, values: Floats) -> tuple[float, float]:
    """Between which times a way is made but for its first and last `EDGE`, widened by as much: without holds."""
    done = (values - values[0]) / (values[-1] - values[0])
    first, last = np.interp((EDGE, 1.0 - EDGE), np.maximum.accumulate(np.clip(done, 0.0, 1.0)), times)
    slack = EDGE * (last - first)
    return max(float(first - slack), float(times[0])), min(float(last + slack), float(times[-1]))


def _refined(times: Floats, values: Floats, turns: list[int]) -> Floats:
    """Times of turns, by the parabola through the samples around each."""
    out = times[turns]
    for place, k in enumerate(turns):
        if 0 < k < len(times) - 1:
            (left, right), (before, here, after) = np.diff(times[k - 1 : k + 2]), values[k - 1 : k + 2]
            bend = (after - here) / right - (here - before) / left
            if bend and np.isclose(left, right):
                out[place] += np.clip(-0.5 * (after - before) / bend, -0.5 * left, 0.5 * right)
    return out


def step_warnings(
    swings: list[Swing], each: Callable[[Swing], float], remembers: bool, key: str, now: float
) -> Iterator[RunWarning]:
    """Warnings of values that go to and fro in too few steps.

    each       steps of a way of a swing
    remembers  whether the end depends on the way, by friction, flow or inertia
    key, now   of the scene: what fixes the steps, and its value
    """
    needed = EACH_WAY if remembers else SEEN
    for swing in swings:
        if (found := each(swing)) < needed * (1.0 - ALIKE):
            way, times = swing.shortest, needed / found
            better = f"{0.99 * now / times:.3g}" if key == "time.step" else f"{math.ceil(now * times)}"
            yield RunWarning(
                "coarse-steps", found, needed, key,
                f"{swing.key} alternates, {way:.3g} s each way, and {key} = {now:.6g} gives {found:.2g} steps each way "
                f"(at least {needed}), too few to follow it; write {key} = {better}, or omit it",
            )  # fmt: skip


def frame_warnings(swings: list[Swing], every: float, frames: int) -> Iterator[RunWarning]:
    """Warnings of values that go to and fro faster than frames `every` so many seconds show."""
    for swing in swings:
        if frames >= CURVE and (found := swing.shortest / every) < SEEN * (1.0 - ALIKE):
            yield RunWarning(
                "coarse-frames", found, SEEN, "record.frames",
                f"{swing.key} alternates, {swing.shortest:.3g} s each way, and record.frames = {frames} stores "
                f"{found:.2g} frames each way (at least {SEEN}): curves of the history are aliased; write "
                f"record.frames = {math.ceil(frames * SEEN / found)}",
            )  # fmt: skip
