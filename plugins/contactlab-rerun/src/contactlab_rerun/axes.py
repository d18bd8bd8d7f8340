"""Axes drawn by hand: the viewer has plots over time, and none over anything else."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr
from numpy.typing import ArrayLike

from contactlab.api.arrays import Floats
from contactlab_rerun.gathered import short
from contactlab_rerun.projection import camera, in_plane, line_strips

WIDTH = 1.7  # of a plot whose height is 1
BOX = (np.array([-0.22, -0.22]), np.array([WIDTH + 0.1, 1.14]))
"""Everything that is drawn of a plot but a legend next to it."""

INK, GREY = (205, 210, 216), (74, 80, 88)
DASHES = 40  # in a dashed line
GRAIN = 2.0**-11  # of a plot's height: finer details are invisible and take room


@dataclass(frozen=True)
class Axes:
    """A plot from `x0` to `x1` and from `low` to `high`.

    path   of its entities
    hang   how far below its point the viewer draws a label, as a share of the plot's height
    """

    path: str
    x0: float
    x1: float
    low: float
    high: float
    hang: float

    def points(self, x: ArrayLike, y: ArrayLike) -> np.ndarray:
        """Return positions of values in the drawing (..., 3)."""
        across = WIDTH * (np.asarray(x) - self.x0) / (self.x1 - self.x0)
        up = (np.asarray(y) - self.low) / (self.high - self.low)
        return in_plane(np.rint(np.stack([across, up], axis=-1) / GRAIN) * GRAIN)

    def log(
        self,
        recording: rr.RecordingStream,
        titles: tuple[str, str],
        x_ticks: Sequence[tuple[float, str]],
        y_ticks: Sequence[tuple[float, str]],
    ) -> None:
        """Draw lines, ticks and labels; `titles` of both axes."""
        recording.log(f"{self.path}/view", camera(), static=True)
        grid = [self.points([self.x0, self.x1], [y, y]) for y, _ in y_ticks]
        corner = self.points([self.x0, self.x0, self.x1], [self.high, self.low, self.low])
        colours, radii = [GREY] * len(grid) + [INK], [-0.6] * len(grid) + [-1.0]
        lines = rr.LineStrips3D([*grid, corner], colors=colours, radii=radii)
        recording.log(f"{self.path}/axes", lines, static=True)
        at = [self.points(self.x0, y) + np.array([-0.09, self.hang, 0.0]) for y, _ in y_ticks]
        at += [self.points(x, self.low) + np.array([0.0, -0.02, 0.0]) for x, _ in x_ticks]
        at += [np.array([WIDTH / 2, -0.04 - 2.0 * self.hang, -1.0]), np.array([0.0, 1.02 + 2.0 * self.hang, -1.0])]
        texts = [text for _, text in (*y_ticks, *x_ticks)] + list(titles)
        recording.log(f"{self.path}/labels", labels(at, texts), static=True)


def labels(at: Sequence[np.ndarray], texts: Sequence[str], colour: tuple[int, ...] = INK) -> rr.Points3D:
    """Draw strings at points."""
    return rr.Points3D(np.array(at, np.float32), labels=list(texts), radii=[0.0], colors=[colour], show_labels=True)


def log_legend(
    recording: rr.RecordingStream, path: str, names: Sequence[tuple[str, tuple[int, ...]]], hang: float
) -> None:
    """Write names in their colours next to a plot."""
    for number, (name, colour) in enumerate(names):
        at = np.array([WIDTH + 0.42, 1.0 - 2.2 * hang * number, -1.0])
        recording.log(f"{path}/legend/{number}", labels([at], [name], colour), static=True)


def ticks(low: float, high: float) -> list[tuple[float, str]]:
    """Return about five round numbers within the range, with their labels."""
    step = nice_step((high - low) / 5.0)
    first = np.ceil(low / step - 1e-9) * step
    values = [round(float(t), 12) + 0.0 for t in np.arange(first, high + 1e-9 * step, step)]
    return [(value, short(value)) for value in values]


def nice_step(value: float) -> float:
    """1, 2 or 5 times a power of ten, not below `value`."""
    unit = 10.0 ** np.floor(np.log10(value))
    return float(unit * next(m for m in (1.0, 2.0, 5.0, 10.0) if m * unit >= value * (1.0 - 1e-9)))


def dashed(x: Floats, y: Floats, pieces: int = DASHES) -> tuple[Floats, Floats]:
    """The polyline as separate `pieces` of two points each: x, y (2 pieces,); x must not fall."""
    edges = np.linspace(x[0], x[-1], 2 * pieces)
    return edges, np.interp(edges, x, y)


def solid_columns(points: np.ndarray) -> rr.ComponentColumnList:
    """Return columns of a line (k points) in each of F frames (F, k, 3)."""
    frames, count = points.shape[:2]
    lines = line_strips(points.reshape(-1, 3), [count] * frames)
    return rr.LineStrips3D.columns(strips=lines).partition([1] * frames)


def dashed_columns(points: np.ndarray) -> rr.ComponentColumnList:
    """Pieces of two points in each of F frames (F, 2 pieces, 3)."""
    frames, pieces = len(points), points.shape[1] // 2
    lines = line_strips(points.reshape(-1, 3), [2] * (frames * pieces))
    return rr.LineStrips3D.columns(strips=lines).partition([pieces] * frames)
