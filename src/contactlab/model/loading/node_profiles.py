"""Check that nodes resolve a profile: supports, springs, gravity and velocities have it at nodes alone."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats, Ints, RunWarning
from contactlab.errors import Where
from contactlab.model.bodies.body import Body
from contactlab.model.loading.load_profile import Varying

LIMIT = 0.02  # of the profile's integral: error allowed between nodes
PLACES = 33  # between two neighbours, or between a node and a break
MOST = 20_000  # intervals that are checked
NEARLY = 1e-9  # of the range: coordinates that differ by less are the same


def tell_unresolved(
    profile: Varying, bodies: tuple[Body, ...], nodes: Ints, at: Floats, where: Where, told: list[RunWarning]
) -> None:
    """Append a warning if linear interpolation between nodes differs from the profile.

    nodes  (k,) that have a value
    at     (N,) variable of the profile, at all nodes
    """
    own = np.zeros(len(at), np.bool_)
    own[nodes] = True
    groups = [group[own[group].all(axis=1)] for group in _groups(bodies, whole=True)]
    if not any(map(len, groups)):
        groups = [group[own[group].all(axis=1)] for group in _groups(bodies, whole=False)]
    low, high = _intervals([at[group] for group in groups if len(group)], float(np.ptp(at[nodes])))
    if profile.by == "angle":  # intervals across the half line of 180 degrees are skipped
        low, high = low[high - low < 180.0], high[high - low < 180.0]
    missed = _missed(profile, low, high) if len(low) else 0.0
    if missed > LIMIT:
        key = getattr(where, "key", where)
        told.append(RunWarning(
            "coarse-profile", missed, LIMIT, str(key),
            f"{key}: values at nodes and straight between them miss {missed:.0%} of the profile (at most {LIMIT:.0%}): "
            f"it varies too fast for nodes that are {float(np.median(high - low)):.3g} apart; try finer cells, or "
            "a wider profile",
        ))  # fmt: skip


def _groups(bodies: tuple[Body, ...], whole: bool) -> list[Ints]:
    """Return nodes (g, b) of cells of the `whole` bodies, or of the edges of their edge sets."""
    if whole:
        return [body.cells for body in bodies]
    return [edges + body.first for body in bodies for edges in body.mesh.edges.values()]


def _intervals(groups: list[Floats], span: float) -> tuple[Floats, Floats]:
    """Return ends (m,), (m,) of the intervals between neighbours within a cell or edge, each once."""
    if not groups or not span > 0.0:
        return np.zeros(0), np.zeros(0)
    found = []
    for group in groups:
        ordered = np.sort(group, axis=1)
        found.append(np.stack([ordered[:, :-1].ravel(), ordered[:, 1:].ravel()], axis=1))
    pairs = np.concatenate(found)
    pairs = pairs[(pairs[:, 1] - pairs[:, 0]) > NEARLY * span]
    _, first = np.unique(np.round(pairs / (NEARLY * span)), axis=0, return_index=True)
    pairs = pairs[first][:: max(1, len(first) // MOST)]
    return pairs[:, 0], pairs[:, 1]


def _missed(profile: Varying, low: Floats, high: Floats) -> float:
    """Return the integral of |profile - its linear interpolation| over all intervals, relative to |profile|."""
    breaks = np.sort(profile.breaks)
    first, last = np.searchsorted(breaks, low, side="right"), np.searchsorted(breaks, high, side="left")
    number = np.maximum(last - first, 0)
    part = np.repeat(np.arange(len(low)), number)
    inner = breaks[np.arange(len(part)) - np.repeat(np.cumsum(number) - number, number) + first[part]]
    of = np.concatenate([np.arange(len(low)), part, np.arange(len(low))])
    ends = np.concatenate([low, inner, high])
    order = np.lexsort((ends, of))
    of, ends = of[order], ends[order]
    a, b, of = ends[:-1], ends[1:], of[:-1]
    within = b > a
    within &= b <= high[of]
    a, b, of = a[within], b[within], of[within]
    share = (np.arange(PLACES) + 0.5) / PLACES
    x = a[:, None] + (b - a)[:, None] * share
    left, right = profile.values(low), profile.values(high)
    straight = left[of, None] + (right - left)[of, None] * (x - low[of, None]) / (high - low)[of, None]
    values, length = profile.values(x), (b - a)[:, None] / PLACES
    size = float((np.abs(values) * length).sum())
    off = float((np.abs(values - straight) * length).sum())
    # a profile that is 0 at all places and nodes is no reason for a warning; nonzero at nodes alone is
    return off / size if size > 0.0 else float(off > 0.0)
