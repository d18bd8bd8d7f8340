"""Edges of contact where the pressure ends as a square root, which no mesh follows there.

Between smooth surfaces p(x) ~ (a - x)^(1/2) at an edge a (Johnson 1985, Contact Mechanics, 5.1), so that p^2 is smooth
up to the edge. Multipliers are off in a few segments next to it, depending on where a falls in its segment. Their force
is right all the same, and so are they a little further in. There p^2 = b1 (a - x) + b2 (a - x)^2 is fitted, with the
edge a that leaves the force as it is.
"""

from __future__ import annotations

import numpy as np

from contactlab.api.arrays import Floats
from contactlab.studies.profile import Profile, bearing

LEFT_OUT = 2
"""Nodes next to an edge that are replaced."""
FITTED = 6
"""Nodes before these that p^2 is fitted to."""
CLOSE = 0.025
"""Largest residual of the fit, over the largest p^2 in it, with which an edge is taken for a root."""
REACH = (0.5, 2.0)
"""Segments inside and outside of the last pressed node between which the edge is sought."""
POINTS = 32
"""Points of the replaced part, quadratically denser to the edge."""


def with_root_edges(profile: Profile) -> Profile:
    """The same with all edges of contact followed to their roots; what does not end as a root stays as it is."""
    return _right_edges(_right_edges(profile).mirrored()).mirrored()


def _right_edges(profile: Profile) -> Profile:
    """The right edge of each contact, without what the nodes have between it and the middle of the gap beyond."""
    x, p = profile.x, profile.value
    found: list[tuple[Floats, Floats]] = []
    begun = 0  # nodes before this one are done
    contacts = stretches(p)
    for number, (first, last) in enumerate(contacts):
        after = len(x)
        if number + 1 < len(contacts):
            after = int(np.searchsorted(x, 0.5 * (x[last] + x[contacts[number + 1][0]])))
        added = _right_edge(x, p, first, last, after)
        if added is not None:
            kept = last - LEFT_OUT + 1
            found += [(x[begun:kept], p[begun:kept]), (added.x, added.value)]
            begun = after
    found.append((x[begun:], p[begun:]))
    return Profile(*(np.concatenate(parts) for parts in zip(*found, strict=True)))


def stretches(p: Floats) -> list[tuple[int, int]]:
    """First and last node of each stretch of contact whose pressure is not small against the largest."""
    if len(p) == 0:
        return []
    steps = np.flatnonzero(np.diff(np.r_[0, (p > 0.0) & bearing(p), 0]))
    parts = zip(steps[::2].tolist(), (steps[1::2] - 1).tolist(), strict=True)
    return [(first, last) for first, last in parts if p[first : last + 1].max() > CLOSE * p.max()]


def _right_edge(x: Floats, p: Floats, first: int, last: int, after: int) -> Profile | None:
    """Root that ends the contact of nodes `first` to `last`, whose force reaches to the node before `after`."""
    peak = first + int(np.argmax(p[first : last + 1]))
    fitted = last - LEFT_OUT - FITTED + 1
    if fitted < max(0, peak - FITTED) or last + 1 >= after:
        return None
    kept = last - LEFT_OUT + 1
    force = float(np.trapezoid(p[kept - 1 : after], x[kept - 1 : after]))
    return _root(x[fitted:kept], p[fitted:kept], force, x[last - 1 : last + 1])


def _root(x: Floats, p: Floats, force: float, end: Floats) -> Profile | None:
    """The pressure beyond the nodes `x` that carries `force` and ends near the last segment `end`, if there is one."""
    from scipy.optimize import brentq

    start, segment = x[-1], end[1] - end[0]

    def excess(a: float) -> float:
        return float(np.trapezoid(*_beyond(x, p, a)[::-1])) - force

    low, high = end[1] - REACH[0] * segment, end[1] + REACH[1] * segment
    if low <= start or excess(low) * excess(high) > 0.0:
        return None
    a = float(brentq(excess, low, high))
    residual = np.abs(_squares(x, p, a, x) - p**2).max() / (p**2).max()
    if residual > CLOSE:
        return None
    at, values = _beyond(x, p, a)
    return Profile(at[1:], values[1:])


def _squares(x: Floats, p: Floats, a: float, at: Floats) -> Floats:
    """The fit of p^2 with its root at `a`, at other positions."""
    b = np.linalg.lstsq(np.stack([a - x, (a - x) ** 2], axis=1), p**2, rcond=None)[0]
    return np.asarray(b[0] * (a - at) + b[1] * (a - at) ** 2)


def _beyond(x: Floats, p: Floats, a: float) -> tuple[Floats, Floats]:
    """Positions from the last of `x` to the edge `a`, and the fitted pressures there."""
    at = a - (a - x[-1]) * np.linspace(1.0, 0.0, POINTS) ** 2
    return at, np.sqrt(np.maximum(0.0, _squares(x, p, a, at)))
