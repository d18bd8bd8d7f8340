"""How values vary along edges or over bodies: a factor at each point, from where the points lie before the run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from contactlab.api import Element, Floats, Ints
from contactlab.errors import PartError, SceneError, below, one_line

if TYPE_CHECKING:
    from contactlab.api import Function, Profile
    from contactlab.errors import Where
    from contactlab.parts.registry import Registry

ROWS = "rows of two finite numbers, the first ones rising"
PARTS = 3  # Gauss points of a part of an edge, whose length is exact where it is straight


def factors(profile: Profile, points: Floats, s: Floats, registry: Registry, where: Where) -> Floats:
    """Factors (...) [-] at points (..., 2) [mm], at arc lengths s (...) [mm] along the edge set.

    Raises SceneError for a file that holds no table, PartError for a function that gives no numbers.
    """
    at = s if profile.by == "s" else coordinate(profile, points)
    if profile.function is not None:
        key = below(where, "function")
        return values_of(registry.make("function", profile.function, key), at, key)
    if profile.cosine is not None:
        mean, amplitude, period = profile.cosine
        return np.asarray(mean + amplitude * np.cos(2.0 * np.pi * at / period))
    table = (
        np.array(profile.table) if profile.table is not None else read_pairs(str(profile.file), below(where, "file"))
    )
    return np.asarray(np.interp(at, table[:, 0], table[:, 1]))


def at_nodes(profile: Profile, points: Floats, registry: Registry, where: Where) -> Floats:
    """Factors (k,) [-] at nodes of a body, of which `points` (k, 2) [mm] tell where they are.

    Raises SceneError for a profile by arc length, which they have none of, or with a mean.
    """
    if profile.by == "s":
        raise SceneError(
            "the nodes of a body have no arc length", where=below(where, "by"), got="s", allowed="x, y, angle",
            hint="arc lengths are those of edge sets, under supports and loads",
        )  # fmt: skip
    if profile.mean is not None:
        raise SceneError(
            "there is no resultant to keep", where=below(where, "mean"), got=profile.mean, allowed="a mean under loads",
            hint="leave `mean` out",
        )  # fmt: skip
    return factors(profile, points, np.zeros(len(points)), registry, where)


def values_of(function: Function, at: Floats, where: Where) -> Floats:
    """What a function gives at places or times (...), in their shape. Raises PartError where that is no number."""
    try:
        found = np.asarray(function.values(np.array(at, np.float64).reshape(-1)), np.float64)
    except Exception as error:
        raise PartError(f"the function failed: {one_line(error)}", where=where, got=type(function).__name__) from error
    if found.shape != (np.size(at),) or not np.isfinite(found).all():
        shown = f"shape {found.shape}" if found.shape != (np.size(at),) else _first_not_finite(found, np.ravel(at))
        raise PartError(
            "the function gives no number at some place", where=where, got=shown,
            allowed="a finite number for every place or time that it is asked for",
            hint="contactlab check tells more about the part",
        )  # fmt: skip
    return found.reshape(np.shape(at))


def _first_not_finite(found: Floats, at: Floats) -> str:
    k = int(np.flatnonzero(~np.isfinite(found))[0])
    return f"{found[k]} at {at[k]:g}"


def coordinate(profile: Profile, points: Floats) -> Floats:
    """Where the points are [mm or degrees] by what the profile varies with, arc length aside."""
    if profile.by in ("x", "y"):
        return np.asarray(points[..., "xy".index(profile.by)])
    x, y = np.moveaxis(points - np.array(profile.centre), -1, 0)
    return np.asarray(np.degrees(np.arctan2(y, x)))


def with_mean(profile: Profile, found: Floats, lengths: Floats, where: Where) -> Floats:
    """Factors scaled to the mean that the profile asks for; `lengths` [mm] that each of them stands for.

    Raises SceneError where their own mean is none.
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


def arc_lengths(element: Element, edges: Ints, reference: Floats, at: Floats) -> Floats:
    """Arc length (e, g) [mm] at places `at` (g,) in [-1, 1] of `edges` (e, b), which go on where others end.

    It begins at the edge that follows none, in the order of the edges where there are several pieces; a closed curve
    begins at its first edge.
    """
    points, weights = np.polynomial.legendre.leggauss(PARTS)
    ends = np.append(at, 1.0)
    inside = np.empty((len(edges), len(ends)))
    for k, end in enumerate(ends):
        half = 0.5 * (end + 1.0)
        _, derivative = element.edge_shape(half * (points + 1.0) - 1.0)
        along = np.einsum("ga,eai->egi", derivative, reference[edges])
        inside[:, k] = half * np.hypot(along[..., 0], along[..., 1]) @ weights
    first, last = _ends(element)
    begins, following = _order(edges[:, first], edges[:, last]), 0.0
    starts = np.empty(len(edges))
    for edge in begins:
        starts[edge] = following
        following += float(inside[edge, -1])
    return np.asarray(starts[:, None] + inside[:, :-1])


def _ends(element: Element) -> tuple[int, int]:
    """Which nodes of an edge lie at its ends."""
    values, _ = element.edge_shape(np.array([-1.0, 1.0]))
    return int(values[0].argmax()), int(values[1].argmax())


def _order(first: Ints, last: Ints) -> list[int]:
    """Edges one after the other: pieces with a beginning first, closed ones after them."""
    at = {int(node): number for number, node in enumerate(first)}
    reached = {int(node) for node in last}
    order: dict[int, None] = {}
    for begin in sorted(range(len(first)), key=lambda edge: int(first[edge]) in reached):
        edge: int | None = begin
        while edge is not None and edge not in order:
            order[edge] = None
            edge = at.get(int(last[edge]))
    return list(order)


def read_pairs(file: str, where: Where) -> Floats:
    """The table (n, 2) in a CSV file: places or times, and factors [-]. Raises SceneError where there is none."""
    try:
        table = np.loadtxt(file, delimiter=",", ndmin=2)
    except (OSError, ValueError) as error:
        raise SceneError("no table can be read here", where=where, got=str(error), allowed=ROWS) from error
    if table.shape[1] != 2 or len(table) < 2 or not np.all(np.diff(table[:, 0]) > 0.0) or not np.isfinite(table).all():
        raise SceneError(
            f"no table in {file}", where=where, got=f"{table.shape[0]} rows of {table.shape[1]}", allowed=ROWS
        )
    return table
