"""The timelines of a recording: `step`, `sim_time`, and in implicit runs `iteration`, which counts all of Newton's."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr

from contactlab.api.frame import IterationRow
from contactlab_rerun.gathered import Gathered

TIMELINE = "iteration"


def times(steps: Sequence[float] | np.ndarray, seconds: Sequence[float] | np.ndarray) -> list[rr.TimeColumn]:
    """Both timelines: `step`, and `sim_time` to a nanosecond."""
    nanoseconds = np.rint(1e9 * np.asarray(seconds, np.float64)).astype("timedelta64[ns]")
    return [
        rr.TimeColumn("step", sequence=np.asarray(steps, np.int64)),
        rr.TimeColumn("sim_time", duration=nanoseconds),
    ]


def iteration_times(rows: Sequence[IterationRow], numbers: np.ndarray) -> list[rr.TimeColumn]:
    """All three timelines at the iterations with these numbers from 0."""
    some = [rows[k] for k in numbers]
    column = rr.TimeColumn(TIMELINE, sequence=np.asarray(numbers, np.int64) + 1)
    return [column, *times([row.step for row in some], [row.time + row.dt for row in some])]


def last_iterations(run: Gathered) -> dict[int, int]:
    """The number on the timeline of the last iteration of each step."""
    return {row.step: number for number, row in enumerate(run.iterations, start=1)}


def iterate_times(numbers: Sequence[int]) -> list[rr.TimeColumn]:
    """The timeline of iterations alone: what belongs to none of the others is not seen on them."""
    return [rr.TimeColumn(TIMELINE, sequence=np.asarray(numbers, np.int64))]


def frame_times(
    run: Gathered, steps: Sequence[float] | np.ndarray, seconds: Sequence[float] | np.ndarray
) -> list[rr.TimeColumn]:
    """Timelines of what is known at the end of steps, in implicit runs with the last iteration of each of them."""
    when = times(steps, seconds)
    if run.iterations:
        known: dict[int, int] = last_iterations(run)
        numbers: list[int] = []
        for step in steps:
            numbers.append(known.get(int(step), numbers[-1] if numbers else 0))
        when.append(rr.TimeColumn(TIMELINE, sequence=np.array(numbers, np.int64)))
    return when
