"""Values that change in time, as scenes write them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from contactlab.api import Function
from contactlab.errors import Where, below
from contactlab.model.loading.load_profile import read_pairs, values_of
from contactlab.parts.registry import Registry
from contactlab.scene import keys

Ramp = Callable[[float], float]
"""Fraction of the final value at a time [s]."""

SET_OUT, ARRIVE = 0.12, 0.35  # of the ramp: some ten periods each, at the pace of a run that follows the path


class RampTime(NamedTuple):
    """Duration of ramps that name none.

    duration  [s]
    gentle    True if they begin and end without a jolt
    end       [s] of the run, if they fill it: a ramp that begins later has the rest of it
    """

    duration: float
    gentle: bool = False
    end: float | None = None

    def length(self, begin: float) -> float:
        """Return the duration [s] of a ramp that begins at a time [s]."""
        return self.duration if self.end is None or begin >= self.end else self.end - begin


class Course(NamedTuple):
    """A value in time before the times of the run are known.

    to        final value
    shape     one of `SHAPES`, "table" with `points`, or "function" with one and its place in the scene
    duration  [s]; None: the run's ramp time
    begin     [s]; zero until then
    points    (time after `begin` [s], fraction) of a table
    """

    to: float
    shape: str = "constant"
    duration: float | None = None
    begin: float = 0.0
    points: tuple[tuple[float, float], ...] = ()
    function: tuple[Function, Where] | None = None

    def bind(self, run: RampTime) -> Ramp:
        """Return the fraction in time, with the ramp time of the `run` for ramps that name no duration."""
        if self.shape == "table":
            return _table(self.points, self.begin)
        if self.function is not None:
            return _shifted(_given(*self.function), self.begin)
        shape = SHAPES[self.shape]
        if run.gentle and self.duration is None and self.shape != "constant":
            return _shifted(gentle(shape(1.0), run.duration), self.begin)
        return _shifted(shape(self._length(run)), self.begin)

    def _length(self, run: RampTime) -> float:
        return run.length(self.begin) if self.duration is None else self.duration

    def over(self, run: RampTime) -> float:
        """Return the time [s] after which the value is constant; infinite for a function that always changes."""
        if self.shape == "table":
            return self.begin + self.points[-1][0]
        if self.function is not None:
            return self.begin + self.function[0].end()
        return self.begin + (0.0 if self.shape == "constant" else self._length(run))

    def corners(self, run: RampTime) -> tuple[float, ...]:
        """Return times [s] at which the value or its speed may jump."""
        if self.shape == "table":
            return tuple(self.begin + time for time, _ in self.points)
        if self.function is not None:
            return self.begin, *(self.begin + time for time in self.function[0].breaks() if time > 0.0)
        return self.begin, self.over(run)

    @property
    def timed(self) -> bool:
        """True if it gives in seconds when or how fast it changes."""
        return self.duration is not None or self.begin > 0.0 or self.shape in ("table", "function")

    @property
    def steady(self) -> bool:
        """True if the value never changes."""
        return not self.moves or (self.shape == "constant" and self.begin <= 0.0)

    @property
    def moves(self) -> bool:
        """True if the value is ever nonzero."""
        return self.to != 0.0


def course_of(value: float | keys.Ramp | keys.Turn, registry: Registry, where: Where) -> Course:
    """Return the course of a number (there from the start) or of a table of the scene at `where`."""
    if isinstance(value, int | float):
        return Course(float(value))
    course = Course(value.to, value.ramp, value.duration, value.begin, getattr(value, "points", ()))
    file, function = getattr(value, "file", None), getattr(value, "function", None)
    if file is not None:
        pairs = read_pairs(str(file), below(where, "file"))
        return course._replace(points=tuple((float(time), float(factor)) for time, factor in pairs))
    if function is not None:
        key = below(where, "function")
        return course._replace(function=(registry.make("function", function, key), key))
    return course


def courses_of(spec: object, names: tuple[str, ...], registry: Registry, where: Where) -> list[Course]:
    """Return the courses of several keys of a table of the scene at `where`; 0 for missing keys."""
    given = {name: getattr(spec, name) for name in names}
    return [course_of(0.0 if v is None else v, registry, below(where, name)) for name, v in given.items()]


def parabola(duration: float) -> Ramp:
    """Return d(t) = 1 - (1 - t/T)^2: starts at speed 2/T and ends with none (Baillet & Sassi 2005, 5.1)."""

    def value(time: float) -> float:
        rest = 1.0 - min(time, duration) / duration
        return 1.0 - rest * rest

    return value


def linear(duration: float) -> Ramp:
    """Return a ramp that rises as t/T and stays at one."""
    return lambda time: min(time, duration) / duration


def smooth(duration: float) -> Ramp:
    """Return d(t) = 3 (t/T)^2 - 2 (t/T)^3: no speed at both ends."""

    def value(time: float) -> float:
        s = min(time, duration) / duration
        return s * s * (3.0 - 2.0 * s)

    return value


def constant(duration: float) -> Ramp:
    """Return a ramp with its full value from the start."""
    return lambda time: 1.0


def gentle(shape: Ramp, duration: float) -> Ramp:
    """Return a ramp along `shape`, which is one at 1, paced so that "parabola" begins and ends without a jolt.

    Speed rises over `SET_OUT` of the time, stays, and falls over `ARRIVE` of it, both as 3 q^2 - 2 q^3. All shapes run
    on the same clock, so that several of them pass through the same states as without it.
    """
    whole = 1.0 - 0.5 * (SET_OUT + ARRIVE)

    def value(time: float) -> float:
        s = min(time / duration, 1.0)
        if s > 1.0 - ARRIVE:
            left = ARRIVE * _eased((1.0 - s) / ARRIVE)
        else:
            left = whole - (SET_OUT * _eased(s / SET_OUT) if s < SET_OUT else s - 0.5 * SET_OUT)
        return shape(1.0 - math.sqrt(max(left, 0.0) / whole))

    return value


def _eased(q: float) -> float:
    """Return the integral of 3 q^2 - 2 q^3 from 0 to q."""
    return q * q * q * (1.0 - 0.5 * q)


SHAPES: dict[str, Callable[[float], Ramp]] = {
    "parabola": parabola,
    "linear": linear,
    "smooth": smooth,
    "constant": constant,
}


def _given(function: Function, where: Where) -> Ramp:
    """Return values of a function, one time after another."""
    return lambda time: float(values_of(function, np.array(time), where))


def _shifted(ramp: Ramp, begin: float) -> Ramp:
    if begin == 0.0:
        return ramp
    return lambda time: ramp(time - begin) if time >= begin else 0.0


def _table(points: tuple[tuple[float, float], ...], begin: float) -> Ramp:
    times, values = np.array(points).T
    first, last, length = float(values[0]), float(values[-1]), len(times)

    def value(time: float) -> float:
        k = int(np.searchsorted(times, time - begin, side="right"))
        if k == 0:
            return first
        if k == length:
            return last
        share = (time - begin - times[k - 1]) / (times[k] - times[k - 1])
        return float(values[k - 1] + share * (values[k] - values[k - 1]))

    return value
