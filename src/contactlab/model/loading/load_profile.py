"""Profiles along edges or over bodies: a factor at each point, from its undeformed position."""

from __future__ import annotations

import io
import warnings
from pathlib import Path

import numpy as np

from contactlab.api import Floats, Function, Profile
from contactlab.errors import PartError, SceneError, Where, below, one_line
from contactlab.outside_files import text_outside
from contactlab.parts.registry import Registry

ROWS = "rows of two finite numbers, the first ones rising"


class Varying:
    """A profile, ready to be evaluated.

    breaks  places of jumps of values or slopes, as far as known
    """

    def __init__(self, profile: Profile, registry: Registry, where: Where) -> None:
        self.spec, self.by, self.breaks = profile, profile.by, np.zeros(0)
        self._key, self._function, self._table = below(where, "function"), None, np.zeros((0, 2))
        if profile.function is not None:
            self._function = registry.make("function", profile.function, self._key)
            self.breaks = np.array(self._function.breaks(), np.float64)
        elif profile.cosine is None:
            given = profile.table
            self._table = np.array(given) if given is not None else read_pairs(str(profile.file), below(where, "file"))
            self.breaks = self._table[:, 0]

    def at(self, points: Floats) -> Floats:
        """Return coordinates or angles (n,) [mm or degrees] of points (n, 2) [mm]; arc lengths are not known here.

        Angles lie between -180 and 180, or as far from the middle of a profile that extends beyond.
        """
        if self.by in ("x", "y"):
            return np.asarray(points[..., "xy".index(self.by)])
        x, y = np.moveaxis(points - np.array(self.spec.centre), -1, 0)
        angle = np.degrees(np.arctan2(y, x))
        if len(self.breaks) and max(-self.breaks.min(), self.breaks.max()) > 180.0:
            first = 0.5 * float(self.breaks.min() + self.breaks.max()) - 180.0
            return np.asarray((angle - first) % 360.0 + first)
        return np.asarray(angle)

    def values(self, at: Floats) -> Floats:
        """Return factors (...) [-] at coordinates or arc lengths (...). Raises PartError if a function fails."""
        if self._function is not None:
            return values_of(self._function, at, self._key)
        if self.spec.cosine is not None:
            mean, amplitude, period = self.spec.cosine
            return np.asarray(mean + amplitude * np.cos(2.0 * np.pi * at / period))
        return np.asarray(np.interp(at, self._table[:, 0], self._table[:, 1]))


def of_nodes(profile: Profile, registry: Registry, where: Where) -> Varying:
    """Return a profile over nodes of a body. SceneError if it uses arc length or a mean: nodes have neither."""
    if profile.by == "s":
        raise SceneError(
            "the nodes of a body have no arc length", where=below(where, "by"), got="s", allowed="x, y, angle",
            hint="arc lengths belong to edge sets, under supports and loads",
        )  # fmt: skip
    if profile.mean is not None:
        raise SceneError(
            "there is no resultant to keep", where=below(where, "mean"), got=profile.mean, allowed="a mean under loads",
            hint="leave `mean` out",
        )  # fmt: skip
    return Varying(profile, registry, where)


def values_of(function: Function, at: Floats, where: Where) -> Floats:
    """Return values of a function at places or times (...), in their shape. PartError if they are not finite."""
    try:
        found = np.asarray(function.values(np.array(at, np.float64).reshape(-1)), np.float64)
    except Exception as error:
        raise PartError(f"the function failed: {one_line(error)}", where=where, got=type(function).__name__) from error
    if found.shape != (np.size(at),) or not np.isfinite(found).all():
        shown = f"shape {found.shape}" if found.shape != (np.size(at),) else _first_not_finite(found, np.ravel(at))
        raise PartError(
            "the function gives no number at some place", where=where, got=shown,
            allowed="a finite number for every place or time",
            hint="run contactlab check for details",
        )  # fmt: skip
    return found.reshape(np.shape(at))


def _first_not_finite(found: Floats, at: Floats) -> str:
    k = int(np.flatnonzero(~np.isfinite(found))[0])
    return f"{found[k]} at {at[k]:g}"


def with_mean(profile: Profile, found: Floats, lengths: Floats, where: Where) -> Floats:
    """Return factors scaled to the mean of the profile; `lengths` [mm] belong to each factor.

    Raises SceneError if their own mean is zero.
    """
    if profile.mean is None:
        return found
    mean = float((found * lengths).sum() / lengths.sum())
    if abs(mean) <= 1e-9 * float(np.abs(found).max(initial=0.0)):
        raise SceneError(
            "these factors have no mean to be scaled", where=where, got=f"a mean of {mean:g}",
            allowed="a profile whose factors do not cancel each other",
            hint="leave `mean` out",
        )  # fmt: skip
    return found * (profile.mean / mean)


def read_pairs(file: str, where: Where) -> Floats:
    """Return the table (n, 2) in a CSV file: places or times, and factors [-]. SceneError without a table."""
    text = text_outside(Path(file), where, ROWS, kind=SceneError)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # an empty file has no rows, reported below
            table = np.loadtxt(io.StringIO(text), delimiter=",", ndmin=2)
    except ValueError as error:
        raise SceneError("no table can be read here", where=where, got=str(error), allowed=ROWS) from error
    if table.shape[1] != 2 or len(table) < 2 or not np.all(np.diff(table[:, 0]) > 0.0) or not np.isfinite(table).all():
        raise SceneError(
            f"no table in {file}", where=where, got=f"{table.shape[0]} rows of {table.shape[1]}", allowed=ROWS
        )
    return table
