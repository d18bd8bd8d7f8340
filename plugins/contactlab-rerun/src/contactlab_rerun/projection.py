"""Drawing in the plane, y upwards, in a viewer whose plane views point down.

Everything is drawn at (x, y, -d) before a pinhole camera of focal length d that looks along -z: its
image is the plane itself. The root of a view holds the camera. The distance d is of the size of what is
drawn: seen from much nearer, lines at the rim are drawn far too wide and arrows run out of the picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pyarrow as pa
import rerun as rr
import rerun.blueprint as rrb

from contactlab.api.arrays import Floats

ON_MESH = 1e-3
"""Lift of lines over a mesh, which would else come and go."""


def camera(distance: float = 1.0) -> rr.Pinhole:
    """The camera that the root of every plane view holds."""
    return rr.Pinhole(
        focal_length=distance, principal_point=[0.0, 0.0], resolution=[2.0, 2.0], camera_xyz=rr.ViewCoordinates.RUB
    )


def in_plane(points: Floats, lift: float = 0.0, distance: float = 1.0) -> np.ndarray:
    """Points (..., 2) as the viewer takes them, (..., 3) in single precision.

    With `lift` they are nearer to the camera by that share, and drawn before what has less of it.
    """
    flat = np.full((*points.shape[:-1], 3), (lift - 1.0) * distance, np.float32)
    flat[..., :2] = (1.0 - lift) * np.asarray(points)
    return flat


def bounds(low: Floats, high: Floats, margin: float = 0.06) -> rrb.VisualBounds2D:
    """Initial bounds of a view: the box from `low` to `high` (2,) with a margin."""
    pad = margin * (np.asarray(high) - np.asarray(low)).max()
    (x0, y0), (x1, y1) = np.asarray(low) - pad, np.asarray(high) + pad
    return rrb.VisualBounds2D(x_range=[x0, x1], y_range=[-y1, -y0])


_STRIPS = rr.components.LineStrip3DBatch([]).as_arrow_array().type


def line_strips(points: np.ndarray, lengths: Sequence[int] | np.ndarray) -> Any:
    """Lines through consecutive `points` (P, 3), so many in each, as the viewer's own arrays.

    The library makes a Python object of every line; there are thousands, in every frame.
    """
    values = pa.array(np.ascontiguousarray(points, np.float32).ravel())
    inner = pa.FixedSizeListArray.from_arrays(values, type=_STRIPS.value_type)
    offsets = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int32)
    return pa.ListArray.from_arrays(pa.array(offsets), inner, type=_STRIPS)
