"""Pictures of the contact record: a column per step, a row per slave node, 200 steps on a page.

The page at the cursor shows its steps beside each other, so that what changes from one step to the next is seen without
moving; a line marks the step at the cursor. Pages are counted from the end of the run: the last one shows the steps
before it whole.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import rerun as rr

from contactlab.api.arrays import Ints
from contactlab.api.contact_steps import NO_SEGMENT
from contactlab.api.drawing.colours import CLOSED, FIELD, STATES, rgb
from contactlab.api.frame import SLIP, ContactLayout
from contactlab_rerun.gathered import Appearance, Gathered, short
from contactlab_rerun.series import times

PAGE = 200  # steps
WIDE = 3  # pixels of a step
HEIGHT = 300  # pixels of a page, about
LEFT, BELOW = 150, 40  # room for labels
MOST_PAGES = 500  # pictures of a run; earlier pages are left out
TICKS = 6  # nodes that are named
SEGMENTS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9")
EMPTY = "#22262c"
BESIDE = "all"  # entity of what the pictures of a contact share


@dataclass(frozen=True)
class Picture:
    """One kind of picture: the root of its entities, that of what all kinds share, and the name of its view."""

    path: str
    beside: str
    name: str
    width: float
    height: float


def log_pictures(recording: rr.RecordingStream, run: Gathered, appearance: Appearance, unit: str) -> list[Picture]:
    """Pictures of states, segments and pressures of each recorded contact."""
    found = []
    for contact in run.layout.contacts:
        rows = run.records.get(contact.name)
        if rows is None or not len(rows):
            continue
        along = run.surfaces[contact.name].along
        kinds = {
            "state": (f"state of {contact.slave}, node by step", _states(rows, along, bool(contact.friction))),
            "segment": (f"master segment under each node of {contact.slave}", _segments(rows, along)),
            "pressure": (
                f"pressure on {contact.slave} up to {_peak(rows):.3g} {unit}".rstrip(),
                _pressures(rows, along),
            ),
        }
        # without friction all that is closed has one state: where it is says more
        order = ("state", "segment", "pressure") if contact.friction else ("segment", "state", "pressure")
        path, high = f"{appearance.path}/steps/{contact.name}", max(1, round(HEIGHT / len(along)))
        size = float(WIDE * PAGE), float(high * len(along))
        for kind in order:
            name, (indices, palette) = kinds[kind]
            _log(recording, f"{path}/{kind}/picture", rows, indices, palette, high)
            found.append(Picture(f"{path}/{kind}", f"{path}/{BESIDE}", name, *size))
        _log_beside(recording, f"{path}/{BESIDE}", rows, size[1], high, _labels(run, contact, along))
    return found


def _states(rows: np.ndarray, along: Ints, frictional: bool) -> tuple[np.ndarray, list[str]]:
    colours = [EMPTY, *STATES[1:SLIP], STATES[SLIP] if frictional else CLOSED]
    return rows["state"][:, along], colours


def _segments(rows: np.ndarray, along: Ints) -> tuple[np.ndarray, list[str]]:
    """Neighbours have different colours; nodes that touch nothing have none."""
    segment, state = rows["segment"][:, along], rows["state"][:, along]
    seen = (segment != NO_SEGMENT) & (state > 0)
    return np.where(seen, 1 + segment % len(SEGMENTS), 0).astype(np.uint8), [EMPTY, *SEGMENTS]


def _pressures(rows: np.ndarray, along: Ints) -> tuple[np.ndarray, list[str]]:
    share = np.clip(rows["pressure"][:, along] / max(_peak(rows), 1e-30), 0.0, 1.0)
    level = np.ceil(share * (len(FIELD) - 1)).astype(np.uint8)
    return np.where(rows["state"][:, along] > 0, 1 + level, 0).astype(np.uint8), [EMPTY, *FIELD]


def _peak(rows: np.ndarray) -> float:
    return float(rows["pressure"].max(initial=0.0))


def _labels(run: Gathered, contact: ContactLayout, along: Ints) -> list[tuple[int, str]]:
    """Rows that are named, by the number of the node and its arc length."""
    s = run.surfaces[contact.name].s
    chosen = np.unique(np.linspace(0, len(along) - 1, min(TICKS, len(along))).round().astype(int))
    return [(int(k), f"node {contact.slave_nodes[along[k]]}, s {short(s[along[k]])}") for k in chosen]


def _log(
    recording: rr.RecordingStream, path: str, rows: np.ndarray, indices: np.ndarray, palette: list[str], high: int
) -> None:
    """All pages of one kind, rows of `high` pixels."""
    pictures, begins = [], [begin for begin, _ in _pages(len(rows))]
    for begin, end in _pages(len(rows)):
        page = np.zeros((PAGE, indices.shape[1]), np.uint8)  # all of one size: the viewer takes them for a film
        page[PAGE - (end - begin) :] = indices[begin:end]
        pictures.append(png_of(np.repeat(np.repeat(page.T, high, axis=0), WIDE, axis=1), palette))
    when = times(rows["step"][begins], rows["time"][begins])
    columns = rr.EncodedImage.columns(blob=pictures, media_type=["image/png"] * len(pictures))
    recording.send_columns(path, when, columns)


def _log_beside(
    recording: rr.RecordingStream, path: str, rows: np.ndarray, height: float, high: int,
    labels: Sequence[tuple[int, str]],
) -> None:  # fmt: skip
    """What all pictures of a contact have in common: names of nodes, steps of the page, and the cursor."""
    style: dict[str, Any] = {"radii": [0.0], "colors": [(205, 210, 216)], "show_labels": True}
    at = [(-76.0, high * (k + 0.5) - 9.0) for k, _ in labels]  # a label is centred on its point
    recording.log(f"{path}/nodes", rr.Points2D(at, labels=[text for _, text in labels], **style), static=True)
    pages = list(_pages(len(rows)))
    begins = [begin for begin, _ in pages]
    spans = [f"steps {rows['step'][begin]} to {rows['step'][end - 1]}" for begin, end in pages]
    places = np.tile(np.array([[WIDE * PAGE / 2.0, height + 8.0]], np.float32), (len(pages), 1))
    when = times(rows["step"][begins], rows["time"][begins])
    recording.send_columns(f"{path}/page", when, rr.Points2D.columns(positions=places, labels=spans))
    recording.log(f"{path}/page", rr.Points2D.from_fields(**style), static=True)
    columns = [np.arange(PAGE - (end - begin), PAGE) for begin, end in pages]
    _log_cursor(recording, path, rows, np.concatenate(columns), height)


def _log_cursor(recording: rr.RecordingStream, path: str, rows: np.ndarray, column: np.ndarray, height: float) -> None:
    """A frame around the column of the step at the cursor, in the last pages; a line per step is dear."""
    shown = rows[len(rows) - len(column) :]
    centres = np.stack([WIDE * (column + 0.5), np.full(len(column), height / 2.0)], axis=1).astype(np.float32)
    when = times(shown["step"], shown["time"])
    recording.send_columns(f"{path}/cursor", when, rr.Boxes2D.columns(centers=centres))
    style = rr.Boxes2D.from_fields(
        half_sizes=[(WIDE / 2.0 + 1.0, height / 2.0 + 3.0)], colors=[(255, 255, 255)], radii=[-0.8]
    )
    recording.log(f"{path}/cursor", style, static=True)


def _pages(count: int) -> Iterator[tuple[int, int]]:
    """First and last row of each page, whole ones from the end."""
    starts = range(count - PAGE * min(MOST_PAGES, -(-count // PAGE)), count, PAGE)
    yield from ((max(0, start), start + PAGE) for start in starts)


def png_of(indices: np.ndarray, palette: Sequence[str]) -> bytes:
    """A picture (h, w) of colours among at most 256, as a PNG file."""
    height, width = indices.shape
    rows = np.zeros((height, width + 1), np.uint8)
    rows[:, 1:] = indices
    rows[1:, 1:] -= indices[:-1]  # what differs from the row above: equal rows are zeros
    rows[:, 0] = 2
    head = struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0)
    colours = bytes(part for colour in palette for part in rgb(colour))
    runs = zlib.compressobj(1, strategy=zlib.Z_RLE)  # pictures in blocks: smaller and faster than usual
    data = runs.compress(rows.tobytes()) + runs.flush()
    parts = [(b"IHDR", head), (b"PLTE", colours), (b"IDAT", data), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(kind, data) for kind, data in parts)


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
