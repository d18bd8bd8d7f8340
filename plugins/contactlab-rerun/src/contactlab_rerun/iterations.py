"""Newton's iterations one by one, on a timeline of their own.

`iteration` counts all of a run, those of attempts that were taken back included. Residuals and active sets are those
after each iteration; meshes and curves are there from the last iteration of their step on.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr

from contactlab.api.drawing.colours import CLOSED, STATES, rgb
from contactlab.api.frame import SLIP, IterationRow
from contactlab_rerun.gathered import Appearance, Gathered
from contactlab_rerun.pages import Columns, Picture, log_beside, log_pages
from contactlab_rerun.series import LINES, times
from contactlab_rerun.step_pictures import EMPTY, node_labels

TIMELINE = "iteration"
FLOOR = 1e-17  # residuals below it are drawn there
RESIDUALS, CHANGES = "newton/residuals", "newton/changes"
LINES_OF = {RESIDUALS: ("log10 force", "log10 contact"), CHANGES: ("conditions changed", "closed", "sticking")}


def iteration_times(rows: Sequence[IterationRow], numbers: np.ndarray) -> list[rr.TimeColumn]:
    """All three timelines at the iterations with these numbers from 0."""
    some = [rows[k] for k in numbers]
    column = rr.TimeColumn(TIMELINE, sequence=np.asarray(numbers, np.int64) + 1)
    return [column, *times([row.step for row in some], [row.time + row.dt for row in some])]


def last_iterations(run: Gathered) -> dict[int, int]:
    """The number on the timeline of the last iteration of each step."""
    return {row.step: number for number, row in enumerate(run.iterations, start=1)}


def frame_times(run: Gathered, steps: Sequence[int], seconds: Sequence[float]) -> list[rr.TimeColumn]:
    """Timelines of what is known at the end of steps, in implicit runs with the last iteration of each of them."""
    when = times(steps, seconds)
    if run.iterations:
        known: dict[int, int] = last_iterations(run)
        numbers: list[int] = []
        for step in steps:
            numbers.append(known.get(int(step), numbers[-1] if numbers else 0))
        when.append(rr.TimeColumn(TIMELINE, sequence=np.array(numbers, np.int64)))
    return when


def log_newton(recording: rr.RecordingStream, run: Gathered, appearance: Appearance) -> list[Picture]:
    """Residuals and counts as curves over iterations, active sets as a picture; nothing in explicit runs."""
    rows = run.iterations
    if not rows:
        return []
    when = iteration_times(rows, np.arange(len(rows)))
    with np.errstate(invalid="ignore"):
        residuals = np.log10(np.maximum([(row.force, row.contact) for row in rows], FLOOR))
    counts = np.array([(row.changed, row.active, row.sticking) for row in rows], float)
    for path, values in ((RESIDUALS, residuals), (CHANGES, counts)):
        columns = rr.Scalars.columns(scalars=values.ravel()).partition(np.full(len(values), values.shape[1]))
        recording.send_columns(f"{appearance.path}/{path}", when, columns)
        colours = [rgb(LINES[k]) for k in range(values.shape[1])]
        style = rr.SeriesLines(names=LINES_OF[path], colors=colours, widths=[1.5] * len(colours))
        recording.log(f"{appearance.path}/{path}", style, static=True)
    return _active_sets(recording, run, appearance)


def _active_sets(recording: rr.RecordingStream, run: Gathered, appearance: Appearance) -> list[Picture]:
    """A picture per contact: a column per iteration, a row per slave node, in the colours of states."""
    rows, contacts, found, begin = run.iterations, run.layout.contacts, [], 0
    sets = [row.active_set for row in rows]
    if len({len(each) for each in sets}) != 1 or len(sets[0]) != sum(len(c.slave_nodes) for c in contacts):
        return []
    states = np.array(sets)
    columns = Columns("iterations", np.arange(1, len(rows) + 1, dtype=np.int32), lambda at: iteration_times(rows, at))
    for contact in contacts:
        along = run.surfaces[contact.name].along
        part, begin = states[:, begin : begin + len(along)][:, along], begin + len(along)
        colours = [EMPTY, *STATES[1:SLIP], STATES[SLIP] if contact.friction else CLOSED]
        path, (high, *size) = f"{appearance.path}/newton/{contact.name}", columns.size(len(along))
        log_pages(recording, f"{path}/active-set/picture", columns, part.astype(np.uint8), colours, high)
        log_beside(recording, f"{path}/all", columns, size[1], high, node_labels(run, contact, along))
        found.append(
            Picture(f"{path}/active-set", f"{path}/all", f"active set of {contact.slave}, by iteration", *size)
        )
    return found
