"""How loads vary along their edges: a factor at each integration point, from where the points lie before the run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from contactlab.api import Floats
from contactlab.errors import SceneError

if TYPE_CHECKING:
    from contactlab.scene.keys import LoadProfile

ROWS = "rows of two finite numbers, the first ones rising"


def factors(profile: LoadProfile, points: Floats) -> Floats:
    """Factors (e, g) [-] of a load at points (e, g, 2) [mm] of its edges.

    Raises SceneError for a file that holds no table.
    """
    at = coordinate(profile, points)
    if profile.cosine is not None:
        mean, amplitude, period = profile.cosine
        return np.asarray(mean + amplitude * np.cos(2.0 * np.pi * at / period))
    table = np.array(profile.table) if profile.table is not None else _read(profile)
    return np.interp(at, table[:, 0], table[:, 1])


def coordinate(profile: LoadProfile, points: Floats) -> Floats:
    """Where the points are [mm or degrees] by what the profile varies with."""
    if profile.by in ("x", "y"):
        return np.asarray(points[..., "xy".index(profile.by)])
    x, y = np.moveaxis(points - np.array(profile.centre), -1, 0)
    return np.asarray(np.degrees(np.arctan2(y, x)))


def _read(profile: LoadProfile) -> Floats:
    try:
        table = np.loadtxt(str(profile.file), delimiter=",", ndmin=2)
    except (OSError, ValueError) as error:
        raise SceneError(
            "no table can be read here", where="loads, key profile.file", got=str(error), allowed=ROWS
        ) from error
    if table.shape[1] != 2 or len(table) < 2 or not np.all(np.diff(table[:, 0]) > 0.0) or not np.isfinite(table).all():
        raise SceneError(
            "not a table of a load", where=f"loads, key profile.file, {profile.file}",
            got=f"{table.shape[0]} rows of {table.shape[1]}",
            allowed=ROWS,
        )  # fmt: skip
    return table
