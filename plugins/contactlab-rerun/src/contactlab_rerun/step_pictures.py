"""Pictures of the contact record: a column per step, a row per slave node."""

from __future__ import annotations

from functools import partial

import numpy as np
import rerun as rr

from contactlab.api.arrays import Ints
from contactlab.api.contact_steps import NO_SEGMENT
from contactlab.api.drawing.colours import CLOSED, FIELD, STATES
from contactlab.api.frame import SLIP, ContactLayout
from contactlab_rerun.decades import NEGATIVE, POSITIVE, segment_length, shade_levels
from contactlab_rerun.gathered import Appearance, Gathered, short
from contactlab_rerun.pages import Columns, Picture, log_beside, log_pages
from contactlab_rerun.profiles import slips
from contactlab_rerun.timelines import frame_times

TICKS = 6  # nodes that are named, and two more if some change a lot
ROOM = 9  # labels that a page has room for side by side
SEGMENTS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9")
EMPTY = "#22262c"
BESIDE = "all"  # entity of what the pictures of a contact share


def log_pictures(recording: rr.RecordingStream, run: Gathered, appearance: Appearance, unit: str) -> list[Picture]:
    """Pictures of states, segments, pressures, gaps and slips of each recorded contact."""
    found = []
    for contact in run.layout.contacts:
        rows = run.records.get(contact.name)
        if rows is None or not len(rows):
            continue
        along = run.surfaces[contact.name].along
        share = np.clip(rows["pressure"][:, along] / max(_peak(rows), 1e-30), 0.0, 1.0)
        level = np.ceil(share * (len(FIELD) - 1)).astype(np.uint8)
        kinds = {
            "state": (f"state of {contact.slave}, node by step", _states(rows, along, bool(contact.friction))),
            "segment": (f"master segment under each node of {contact.slave}", _segments(rows, along)),
            "pressure": (
                f"pressure on {contact.slave} up to {_peak(rows):.3g} {unit}".rstrip(),
                (np.where(rows["state"][:, along] > 0, 1 + level, 0).astype(np.uint8), [EMPTY, *FIELD]),
            ),
            "gap": (
                f"gaps on {contact.slave} (red: overlap, blue: apart; a shade is a power of ten)",
                _lengths(rows["gap"][:, along], segment_length(run, contact)),
            ),
        }
        # without friction all closed nodes have one state: its place is more useful
        order = ["segment", "state", "pressure", "gap"]
        if contact.friction:
            slip = slips(rows)[:, along]
            kinds["slip"] = (
                f"slips on {contact.slave} in a step (blue: along s, red: against it; a shade is a power of ten)",
                _lengths(slip, float(np.nanmax(np.abs(slip), initial=1e-300))),
            )
            order = ["state", "segment", "pressure", "slip", "gap"]
        path = f"{appearance.path}/steps/{contact.name}"
        columns = Columns("steps", rows["step"], partial(_when, run, rows))
        grain = columns.size(len(along))
        for kind in order:
            name, (indices, palette) = kinds[kind]
            log_pages(recording, f"{path}/{kind}/picture", columns, indices, palette, grain)
            found.append(Picture.of(f"{path}/{kind}", f"{path}/{BESIDE}", name, grain))
        log_beside(recording, f"{path}/{BESIDE}", columns, grain, node_labels(run, contact, along))
    return found


def _when(run: Gathered, rows: np.ndarray, at: np.ndarray) -> list[rr.TimeColumn]:
    return frame_times(run, rows["step"][at], rows["time"][at])


def _states(rows: np.ndarray, along: Ints, frictional: bool) -> tuple[np.ndarray, list[str]]:
    colours = [EMPTY, *STATES[1:SLIP], STATES[SLIP] if frictional else CLOSED]
    return rows["state"][:, along], colours


def _segments(rows: np.ndarray, along: Ints) -> tuple[np.ndarray, list[str]]:
    """Neighbours have different colours; nodes that touch nothing have none."""
    segment, state = rows["segment"][:, along], rows["state"][:, along]
    seen = (segment != NO_SEGMENT) & (state > 0)
    return np.where(seen, 1 + segment % len(SEGMENTS), 0).astype(np.uint8), [EMPTY, *SEGMENTS]


def _lengths(lengths: np.ndarray, largest: float) -> tuple[np.ndarray, list[str]]:
    return shade_levels(lengths, largest), [EMPTY, *NEGATIVE, *POSITIVE]


def _peak(rows: np.ndarray) -> float:
    return float(rows["pressure"].max(initial=0.0))


def node_labels(run: Gathered, contact: ContactLayout, along: Ints) -> list[tuple[int, str]]:
    """Rows that are named, by the number of the node and its arc length: nodes that change most, and some between."""
    s = run.surfaces[contact.name].s
    even = np.linspace(0, len(along) - 1, min(TICKS, len(along))).round().astype(int).tolist()
    apart, chosen = len(along) / ROOM, list[int]()
    for row in (*_restless(run.records.get(contact.name), along), *even):
        if len(chosen) < TICKS + 2 and all(abs(row - other) >= apart for other in chosen):
            chosen.append(row)
    return [(k, f"node {contact.slave_nodes[along[k]]}, s {short(s[along[k]])}") for k in sorted(chosen)]


def _restless(rows: np.ndarray | None, along: Ints) -> list[int]:
    """The rows of nodes that change their segment while they touch, the most restless first."""
    if rows is None or len(rows) < 2:
        return []
    segment, closed = rows["segment"][:, along], rows["state"][:, along] > 0
    changes = ((segment[1:] != segment[:-1]) & closed[1:] & closed[:-1]).sum(axis=0)
    order = np.argsort(-changes, kind="stable")
    return [int(row) for row in order if changes[row] > 0]
