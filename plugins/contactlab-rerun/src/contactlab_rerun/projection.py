"""Drawing in the plane, y upwards, in a viewer whose plane views point down.

Everything is drawn at (x, y, -1) before a pinhole camera of focal length 1 that looks along -z: its
image is the plane itself. The root of a view holds the camera.
"""

from __future__ import annotations

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from contactlab.api.arrays import Floats


def camera() -> rr.Pinhole:
    """What the root of every plane view holds."""
    return rr.Pinhole(
        focal_length=1.0, principal_point=[0.0, 0.0], resolution=[2.0, 2.0], camera_xyz=rr.ViewCoordinates.RUB
    )


def in_plane(points: Floats) -> np.ndarray:
    """Points (..., 2) as the viewer takes them, (..., 3) in single precision."""
    flat = np.full((*points.shape[:-1], 3), -1.0, np.float32)
    flat[..., :2] = points
    return flat


def bounds(low: Floats, high: Floats, margin: float = 0.06) -> rrb.VisualBounds2D:
    """What a view shows at first: the box from `low` to `high` (2,) with a margin."""
    pad = margin * (np.asarray(high) - np.asarray(low)).max()
    (x0, y0), (x1, y1) = np.asarray(low) - pad, np.asarray(high) + pad
    return rrb.VisualBounds2D(x_range=[x0, x1], y_range=[-y1, -y0])
