"""The scale of the field below the bodies, and what the colours of arrows mean."""

from __future__ import annotations

import numpy as np
import rerun as rr

from contactlab.api.arrays import Floats
from contactlab.api.drawing.colours import CLOSED, rgb
from contactlab.api.drawing.colours import STATES as COLOURS
from contactlab.api.frame import SLIP, STATES, STICK
from contactlab_rerun.axes import labels
from contactlab_rerun.drawing import TABLE
from contactlab_rerun.gathered import short
from contactlab_rerun.projection import in_plane

BANDS = 64


def log_colour_bar(
    recording: rr.RecordingStream,
    path: str,
    label: str,
    field: tuple[float, float],
    low: Floats,
    high: Floats,
    distance: float,
) -> tuple[Floats, Floats]:
    """The scale of the field, with its ends, below the model's box; gives the box with it."""
    width, size = (high - low)[0], (high - low).max()
    x0, x1 = low[0] + 0.25 * width, low[0] + 0.75 * width
    y1 = low[1] - 0.07 * size
    y0 = y1 - 0.025 * size
    recording.log(f"{path}/bar", _bar(x0, x1, y0, y1, distance), static=True)
    y = y0 - 0.015 * size
    at = [np.array([x, y, -distance]) for x in (x0, 0.5 * (x0 + x1), x1)]
    recording.log(f"{path}/bar/labels", labels(at, [short(field[0]), label, short(field[1])]), static=True)
    return np.array([low[0], y - 0.05 * size]), high


def log_state_key(
    recording: rr.RecordingStream, path: str, low: Floats, high: Floats, frictional: bool, distance: float
) -> None:
    """Log the key of the arrows' colours, right of the scale."""
    size = (high - low).max()
    x, y = high[0] - 0.1 * (high - low)[0], low[1] - 0.045 * size
    shown = [(STATES[s], COLOURS[s]) for s in (STICK, SLIP)] if frictional else [("traction", CLOSED)]
    for number, (text, colour) in enumerate(shown):
        at = np.array([x, y - 0.055 * size * number, -distance])
        recording.log(f"{path}/bar/{text}", labels([at], [text], rgb(colour)), static=True)


def _bar(x0: float, x1: float, y0: float, y1: float, distance: float) -> rr.Mesh3D:
    x = np.repeat(np.linspace(x0, x1, BANDS + 1), 2)
    points = in_plane(np.stack([x, np.tile([y0, y1], BANDS + 1)], axis=1), 0.0, distance)
    a = 2 * np.arange(BANDS)
    triangles = np.concatenate([np.stack([a, a + 2, a + 3], axis=1), np.stack([a, a + 3, a + 1], axis=1)])
    colours = np.repeat(TABLE[np.linspace(0, len(TABLE) - 1, BANDS + 1).astype(int)], 2)
    return rr.Mesh3D(vertex_positions=points, triangle_indices=triangles, vertex_colors=colours)
