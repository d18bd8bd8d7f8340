"""Pictures in pages: a column per step or iteration, a row per node, 200 columns on a page.

The page at the cursor shows its columns beside each other, so that what changes from one to the next is seen without
moving; a frame marks the one at the cursor. Pages are counted from the end: the last one is full.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import rerun as rr

from contactlab.api.arrays import Ints
from contactlab.api.drawing.colours import rgb

PAGE = 200  # columns at most
WIDTH, HEIGHT = 600, 300  # pixels of a page, about
LEFT, BELOW = 150, 40  # room for labels
MOST_PAGES = 500  # pictures of a run; earlier pages are left out


@dataclass(frozen=True)
class Picture:
    """One kind of picture: the root of its entities, that of what all kinds share, and the name of its view."""

    path: str
    beside: str
    name: str
    width: float
    height: float


@dataclass(frozen=True)
class Columns:
    """The columns of all pages: what they are, their numbers (n,), and the times of some of them."""

    word: str
    numbers: Ints
    when: Callable[[np.ndarray], list[rr.TimeColumn]]

    @property
    def page(self) -> int:
        """Columns of a page."""
        return min(PAGE, len(self.numbers))

    @property
    def wide(self) -> int:
        """Pixels of a column."""
        return WIDTH // self.page

    def size(self, rows: int) -> tuple[int, float, float]:
        """Pixels of a row where there are so many, and width and height of a page."""
        high = max(1, round(HEIGHT / rows))
        return high, float(self.wide * self.page), float(high * rows)

    def pages(self) -> list[tuple[int, int]]:
        """First and last column of each page, whole ones from the end."""
        count = len(self.numbers)
        starts = range(count - self.page * min(MOST_PAGES, -(-count // self.page)), count, self.page)
        return [(max(0, start), start + self.page) for start in starts]


def log_pages(
    recording: rr.RecordingStream, path: str, columns: Columns, indices: np.ndarray, palette: Sequence[str], high: int
) -> None:
    """All pages of one kind: colours (n, m) of the columns from top to bottom, rows of `high` pixels."""
    pictures, begins = [], [begin for begin, _ in columns.pages()]
    for begin, end in columns.pages():
        page = np.zeros((columns.page, indices.shape[1]), np.uint8)  # all of one size: the viewer takes them for a film
        page[columns.page - (end - begin) :] = indices[begin:end]
        pictures.append(png_of(np.repeat(np.repeat(page.T, high, axis=0), columns.wide, axis=1), palette))
    images = rr.EncodedImage.columns(blob=pictures, media_type=["image/png"] * len(pictures))
    recording.send_columns(path, columns.when(np.array(begins)), images)


def log_beside(
    recording: rr.RecordingStream, path: str, columns: Columns, height: float, high: int,
    labels: Sequence[tuple[int, str]],
) -> None:  # fmt: skip
    """What all kinds have in common: names of some rows, what columns the page has, and the cursor."""
    style: dict[str, Any] = {"radii": [0.0], "colors": [(205, 210, 216)], "show_labels": True}
    at = [(-76.0, high * (k + 0.5) - 9.0) for k, _ in labels]  # a label is centred on its point
    recording.log(f"{path}/nodes", rr.Points2D(at, labels=[text for _, text in labels], **style), static=True)
    pages, numbers = columns.pages(), columns.numbers
    begins = [begin for begin, _ in pages]
    spans = [f"{columns.word} {numbers[begin]} to {numbers[end - 1]}" for begin, end in pages]
    places = np.tile(np.array([[columns.wide * columns.page / 2.0, height + 8.0]], np.float32), (len(pages), 1))
    when = columns.when(np.array(begins))
    recording.send_columns(f"{path}/page", when, rr.Points2D.columns(positions=places, labels=spans))
    recording.log(f"{path}/page", rr.Points2D.from_fields(**style), static=True)
    place = np.concatenate([np.arange(columns.page - (end - begin), columns.page) for begin, end in pages])
    when = columns.when(np.arange(len(numbers) - len(place), len(numbers)))
    _log_cursor(recording, path, when, place, columns.wide, height)


def _log_cursor(
    recording: rr.RecordingStream, path: str, when: list[rr.TimeColumn], place: np.ndarray, wide: int, height: float
) -> None:
    """A frame around the column at the cursor."""
    centres = np.stack([wide * (place + 0.5), np.full(len(place), height / 2.0)], axis=1).astype(np.float32)
    recording.send_columns(f"{path}/cursor", when, rr.Boxes2D.columns(centers=centres))
    style = rr.Boxes2D.from_fields(
        half_sizes=[(wide / 2.0 + 1.0, height / 2.0 + 3.0)], colors=[(255, 255, 255)], radii=[-0.8]
    )
    recording.log(f"{path}/cursor", style, static=True)


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
