"""Tables of the contact: at each drawn instant a row per slave node, with all that is known of it, as numbers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr

from contactlab.api.contact_steps import NO_SEGMENT
from contactlab.api.drawing.units import Units
from contactlab.api.frame import OPEN, ContactLayout
from contactlab_rerun.gathered import Appearance, Gathered, state_names
from contactlab_rerun.profiles import in_brackets
from contactlab_rerun.timelines import frame_times

LETTERS = 500_000  # of all tables of a contact: few nodes at every instant, many at some of them
ROW = 90  # letters of a row, about
FOLDER = "numbers"


def log_tables(recording: rr.RecordingStream, run: Gathered, appearance: Appearance, drawn: Sequence[int]) -> None:
    """A table of each contact for the frames that are drawn: the newest, if there is no room for all."""
    units = Units.of_label(run.layout.units)
    for contact in run.layout.contacts:
        surface, instants = run.surfaces[contact.name], run.instants
        most = max(1, LETTERS // (ROW * max(1, len(surface.s))))
        frames = drawn[-most:]
        recorded = run.recorded_frames(contact.name)
        texts = [table(run, contact, frame, recorded.get(frame), units) for frame in frames]
        when = frame_times(run, [instants[k].step for k in frames], [instants[k].time for k in frames])
        documents = rr.TextDocument.columns(text=texts, media_type=[rr.MediaType.MARKDOWN] * len(texts))
        recording.send_columns(f"{appearance.path}/{FOLDER}/{contact.name}", when, documents)


def table(run: Gathered, contact: ContactLayout, frame: int, row: np.void | None, units: Units) -> str:
    """The slave nodes in the order of the surface; `row` of the contact record, if the step is in it."""
    surface, instant = run.surfaces[contact.name], run.instants[frame]
    stress, length = in_brackets(units.pressure), in_brackets(units.length)
    names = ["node", f"s{length}", "state", f"gap{length}", f"pressure{stress}"]
    states = state_names(bool(contact.friction))
    # numbers as words of five digits: the record has single precision
    columns: list[Sequence[str]] = [
        [str(node) for node in contact.slave_nodes],
        _words(surface.s),
        [states[state] for state in surface.state[frame]],
        _words(surface.gap[frame]),
        _words(surface.pressure[frame]),
    ]
    if contact.friction:
        names.append(f"shear{stress}")
        columns.append(_words(surface.shear[frame]))
    for name, values in instant.curves[contact.name].memory.items():
        names.append(name)
        columns.append(_words(values))
    if row is not None:
        closed = surface.state[frame] != OPEN
        faced = (row["segment"] != NO_SEGMENT) & closed
        names.append("master segment")
        columns.append([str(segment) if there else "" for segment, there in zip(row["segment"], faced, strict=True)])
        if "slip" in (row.dtype.names or ()):
            names.append(f"slip in the step{length}")
            columns.append(_words(row["slip"]))
    head = [f"**{contact.slave}** at the end of step {instant.step}, time {instant.time:.6g}", ""]
    head += [f"| {' | '.join(names)} |", f"|{'---|' * len(names)}"]
    return "\n".join([*head, *(f"| {' | '.join(column[k] for column in columns)} |" for k in surface.along)])


def _words(values: np.ndarray) -> list[str]:
    """Five digits of each number, an empty string for NaN."""
    return [f"{value:.5g}" if np.isfinite(value) else "" for value in values]
