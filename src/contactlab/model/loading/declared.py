"""Declarations of a scene in time, key by key: their begin and end."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from contactlab.api import RunWarning
from contactlab.errors import SceneError
from contactlab.model.loading.ramps import Course, RampTime, course_of
from contactlab.scene.scene import Scene

VALUES = ("ux", "uy", "turn", "pressure", "shear", "tx", "ty", "value")  # of supports, rigid surfaces, loads, fields
NEARLY = 1e-9  # of the end: differences below it are round-off


class Declared(NamedTuple):
    """A change in time that a scene declares.

    key     of the scene, the key to change
    begin   [s]
    end     [s]; infinite if it never ends
    course  of a value in time; None for effects, overlaps and holds
    """

    key: str
    begin: float
    end: float
    course: Course | None = None


def courses_in(scene: Scene) -> Iterator[tuple[str, Any, Course]]:
    """Yield all values of supports, loads, rigid surfaces and fields: keys, values as written, courses in time."""
    tables: list[tuple[str, Any]] = [(f"supports.{i}", spec) for i, spec in enumerate(scene.supports)]
    tables += [(f"loads.{i}", spec) for i, spec in enumerate(scene.loads)]
    tables += [(f"rigid.{name}", spec) for name, spec in scene.rigid.items()]
    tables += [(f"fields.{name}", spec) for name, spec in scene.fields.items()]
    for table, spec in tables:
        for name in VALUES:
            value = getattr(spec, name, None)
            if value is not None:
                key = f"{table}.{name}"
                yield key, value, course_of(value, scene.registry, scene.where(key))


def declared_in(scene: Scene, ramps: RampTime) -> Iterator[Declared]:
    """Yield all changes in time of a scene, with `ramps` for ramps without a duration."""
    for key, value, course in courses_in(scene):
        if not course.steady:
            yield Declared(_key_of_end(scene, key, value, course), course.begin, course.over(ramps), course)
    for number, spec in enumerate(scene.contacts):
        if spec.start.overlap == "ramp":
            given = spec.start.duration
            key = f"contacts.{number}.start.duration" if given else "time.ramp"
            yield Declared(key, 0.0, given or ramps.duration)
    for number, part in enumerate(scene.effects):
        key = f"effects.{number}"
        for time in scene.registry.make("effect", part, scene.where(key)).times():
            named = next((name for name, value in part.items() if value == time), None)
            yield Declared(f"{key}.{named}" if named else key, 0.0, time)


def _key_of_end(scene: Scene, key: str, value: Any, course: Course) -> str:
    """Return the key that gives the end of the change at `key`."""
    if course.shape == "table":
        return f"{key}.{'file' if value.file is not None else 'points'}"
    if course.shape == "function":
        return f"{key}.function"
    if course.duration is not None:
        return f"{key}.duration"
    if course.shape != "constant" and scene.time.ramp is not None:
        return "time.ramp"
    return f"{key}.begin" if course.begin > 0.0 else key


def last_of(scene: Scene, ramps: RampTime) -> tuple[float, str]:
    """Return the end of all declarations of a scene [s], and its key; "" if nothing is declared.

    Raises SceneError for a change that never ends: the run then needs an end of its own.
    """
    end, key = 0.0, ""
    for one in declared_in(scene, ramps):
        if math.isinf(one.end):
            raise SceneError(
                "this never ends by itself, and the scene gives the run no end", where=scene.where(one.key),
                got=f"time.end: {scene.time.end}", allowed="time.end in seconds",
                hint="write end = 1.0 under [time], or how many seconds of it are to be simulated",
            )  # fmt: skip
        if one.end > end:
            end, key = one.end, one.key
    return end, key


def _rests(course: Course, value: Callable[[float], float], end: float) -> bool:
    """Return whether a table keeps its value at the end [s] of the run from there on."""
    return all(value(course.begin + time) == value(end) for time, _ in course.points if course.begin + time > end)


def beyond(scene: Scene, ramps: RampTime, end: float) -> Iterator[RunWarning]:
    """Yield warnings of all declarations that begin or last beyond a written end of the run."""
    held = [Declared("time.hold", 0.0, ramps.duration + scene.time.hold)] if scene.time.hold else []
    for one in (*declared_in(scene, ramps), *held):
        if math.isinf(one.end) or one.end <= (1.0 + NEARLY) * end:
            continue
        cut = (one.end - end) / (one.end - min(one.begin, end))
        reached = ""
        if one.course is not None:
            value = one.course.bind(ramps)
            if one.course.shape == "table" and _rests(one.course, value, end):
                continue
            reached = f", the value is {value(end):.3g} of `to` there instead of {value(one.end):.3g}"
        yield RunWarning(
            "beyond-end", one.end, end, one.key,
            f"{one.key}: it lasts until {one.end:.6g} s, and the run ends at {end:.6g} s (time.end): {cut:.0%} of its "
            f'time is cut off{reached}; write time.end = {one.end:.6g}, or end = "auto"',
        )  # fmt: skip
