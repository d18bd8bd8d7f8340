"""Pictures in pages: a column per step or iteration, a row per node, 200 columns on a page.

The page at the cursor shows its columns next to each other, so that what changes from one to the next is seen without
moving; a frame marks the one at the cursor. Pages are counted from the end: the last one is full.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import rerun as rr

from contactlab.api.arrays import Ints
from contactlab.api.drawing.colours import rgb

PAGE = 200  # columns at most
TIMES_AS_WIDE = 2.0  # as it is high: a page, about
LEFT, BELOW, MARGIN = 0.25, 0.067, 0.017  # room for labels and around a page, as shares of its width
NAME, ITS_HEIGHT = 0.127, 0.015  # of a row: where it is centred left of the page, and half of its height
MOST_PAGES = 500  # pictures of a run; earlier pages are left out


@dataclass(frozen=True)
class Picture:
    """A kind of picture: the roots of its entities and of the entities that all kinds share, and the name of its view.

    low, high  corners (2,) of what the view shows, in pixels of a page downwards
    """

    path: str
    beside: str
    name: str
    low: tuple[float, float]
    high: tuple[float, float]

    @classmethod
    def of(cls, path: str, beside: str, name: str, grain: Grain) -> Picture:
        """The picture of pages of this size, with room for labels."""
        width, height = grain.width, grain.height
        corner = width * (1.0 + MARGIN), height + width * BELOW
        return cls(path, beside, name, (-width * LEFT, -width * MARGIN), corner)


class Grain(NamedTuple):
    """Pixels of a column and of a row, and width and height of a page in pixels."""

    wide: int
    high: int
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

    def size(self, rows: int) -> Grain:
        """The smallest pictures of about the right shape: the viewer enlarges them without blurring."""
        shape = TIMES_AS_WIDE * rows / self.page
        wide, high = max(1, round(shape)), max(1, round(1.0 / shape))
        return Grain(wide, high, float(wide * self.page), float(high * rows))

    def pages(self) -> list[tuple[int, int]]:
        """First and last column of each page, whole ones from the end."""
        count = len(self.numbers)
        starts = range(count - self.page * min(MOST_PAGES, -(-count // self.page)), count, self.page)
        return [(max(0, start), start + self.page) for start in starts]


def log_pages(
    recording: rr.RecordingStream,
    path: str,
    columns: Columns,
    indices: np.ndarray,
    palette: Sequence[str],
    grain: Grain,
) -> None:
    """All pages of one kind: colours (n, m) of the columns from top to bottom."""
    pictures, begins = [], [begin for begin, _ in columns.pages()]
    for begin, end in columns.pages():
        page = np.zeros((columns.page, indices.shape[1]), np.uint8)  # all of one size: the viewer takes them for a film
        page[columns.page - (end - begin) :] = indices[begin:end]
        pictures.append(png_of(page.T.repeat(grain.high, axis=0).repeat(grain.wide, axis=1), palette))
    images = rr.EncodedImage.columns(blob=pictures, media_type=["image/png"] * len(pictures))
    recording.send_columns(path, columns.when(np.array(begins)), images)


def log_beside(
    recording: rr.RecordingStream, path: str, columns: Columns, grain: Grain, labels: Sequence[tuple[int, str]]
) -> None:
    """Log what all kinds of pictures share: names of some rows, columns of the page, and the cursor."""
    wide, high, width, height = grain
    style: dict[str, Any] = {"radii": [0.0], "colors": [(205, 210, 216)], "show_labels": True}
    at = [(-NAME * width, high * (k + 0.5) - ITS_HEIGHT * width) for k, _ in labels]  # centred on their points
    recording.log(f"{path}/nodes", rr.Points2D(at, labels=[text for _, text in labels], **style), static=True)
    pages, numbers = columns.pages(), columns.numbers
    begins = [begin for begin, _ in pages]
    spans = [f"{columns.word} {numbers[begin]} to {numbers[end - 1]}" for begin, end in pages]
    places = np.tile(np.array([[width / 2.0, height + ITS_HEIGHT * width]], np.float32), (len(pages), 1))
    when = columns.when(np.array(begins))
    recording.send_columns(f"{path}/page", when, rr.Points2D.columns(positions=places, labels=spans))
    recording.log(f"{path}/page", rr.Points2D.from_fields(**style), static=True)
    place = np.concatenate([np.arange(columns.page - (end - begin), columns.page) for begin, end in pages])
    when = columns.when(np.arange(len(numbers) - len(place), len(numbers)))
    centres = np.stack([wide * (place + 0.5), np.full(len(place), height / 2.0)], axis=1).astype(np.float32)
    # a little larger than a column
    half = (wide / 2.0 + width / 600.0, height / 2.0 + width / 200.0)
    recording.send_columns(f"{path}/cursor", when, rr.Boxes2D.columns(centers=centres))
    frame = rr.Boxes2D.from_fields(half_sizes=[half], colors=[(255, 255, 255)], radii=[-0.8])
    recording.log(f"{path}/cursor", frame, static=True)


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
