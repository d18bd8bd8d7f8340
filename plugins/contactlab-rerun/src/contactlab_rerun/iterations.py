"""Newton's iterations one by one, on a timeline of their own.

`iteration` counts all of a run, rejected attempts included. Residuals, active sets, gaps and the
shape of the bodies are shown after each iteration, as far as they were recorded; stresses, tractions and curves are
there from the last iteration of their step on.
"""

from __future__ import annotations

import numpy as np
import rerun as rr

from contactlab.api.drawing.colours import CLOSED, STATES, rgb
from contactlab.api.frame import SLIP
from contactlab_rerun.decades import NEGATIVE, POSITIVE, segment_length, shade_levels
from contactlab_rerun.gathered import Appearance, Gathered
from contactlab_rerun.pages import Columns, Picture, log_beside, log_pages
from contactlab_rerun.series import LINES
from contactlab_rerun.step_pictures import EMPTY, node_labels
from contactlab_rerun.timelines import iteration_times

FLOOR = 1e-17  # residuals below it are drawn there
RESIDUALS, CHANGES = "newton/residuals", "newton/changes"
LINES_OF = {RESIDUALS: ("log10 force", "log10 contact"), CHANGES: ("conditions changed", "closed", "sticking")}


def states_after(run: Gathered) -> np.ndarray:
    """States (n, m) of all slave nodes after each iteration; (0, 0) if conditions are not nodes, or unknown."""
    sets = [row.active_set for row in run.iterations]
    m = sum(len(contact.slave_nodes) for contact in run.layout.contacts)
    return np.array(sets) if m and {len(each) for each in sets} == {m} else np.zeros((0, 0), np.int32)


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
    """Pictures per contact: a column per iteration, a row per slave node: in the colours of states, and gaps."""
    rows, found, begin, states = run.iterations, [], 0, states_after(run)
    if not len(states):
        return []
    columns = Columns("iterations", np.arange(1, len(rows) + 1, dtype=np.int32), lambda at: iteration_times(rows, at))
    kept = [one for one in run.iterates if one.number <= len(rows)]
    numbers, gaps = np.array([one.number for one in kept], np.int32), np.array([one.gap for one in kept])
    of_gaps = Columns("iterations", numbers, lambda at: iteration_times(rows, numbers[at] - 1))
    for contact in run.layout.contacts:
        along = run.surfaces[contact.name].along
        here, begin = slice(begin, begin + len(along)), begin + len(along)
        part = states[:, here][:, along]
        colours = [EMPTY, *STATES[1:SLIP], STATES[SLIP] if contact.friction else CLOSED]
        path, grain = f"{appearance.path}/newton/{contact.name}", columns.size(len(along))
        log_pages(recording, f"{path}/active-set/picture", columns, part.astype(np.uint8), colours, grain)
        log_beside(recording, f"{path}/all", columns, grain, node_labels(run, contact, along))
        name = f"active set of {contact.slave}, by iteration"
        found.append(Picture.of(f"{path}/active-set", f"{path}/all", name, grain))
        if len(kept):
            level = shade_levels(gaps[:, here][:, along], segment_length(run, contact))
            grain = of_gaps.size(len(along))
            log_pages(recording, f"{path}/gap/picture", of_gaps, level, [EMPTY, *NEGATIVE, *POSITIVE], grain)
            log_beside(recording, f"{path}/gaps", of_gaps, grain, node_labels(run, contact, along))
            name = f"gap of {contact.slave}, by iteration (red: overlap, blue: apart; a shade is a power of ten)"
            found.append(Picture.of(f"{path}/gap", f"{path}/gaps", name, grain))
    return found
