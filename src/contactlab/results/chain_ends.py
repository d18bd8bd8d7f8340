"""Angles at the ends of a chain, where a force and the traction that is shown for it part by the first order of them.

Inside a chain the segments on both sides of a node lean to either side, and what a force and its traction differ by is
of second order. A corner that touches alone has a segment on one side.
"""

from __future__ import annotations

import numpy as np

from contactlab.api import ContactCurve, Floats, Ints


def turn_at_ends(curve: ContactCurve) -> float:
    """Angle [rad] between the last two segments of a chain, times the share of the force that its end carries.

    The multiplier of an end node is a traction on the segments beyond the first one, too. Summed over all ends.
    """
    x = np.stack([curve.x, curve.y], axis=1)
    ends, inward, shares = _pressed(curve, x)
    last = ends + 2 * inward
    long = (last >= 0) & (last < len(x))
    long[long] = curve.chain[last[long]] == curve.chain[ends[long]]
    a, b, c = x[ends[long]], x[(ends + inward)[long]], x[last[long]]
    return float(shares[long] @ _between(b - a, c - b))


def angle_at_ends(curve: ContactCurve, master: Floats, segments: Ints) -> float:
    """Angle [rad] between both surfaces at an end of a chain, times the share of the force that it carries.

    `master` (n, 2) [mm] are the deformed nodes of the other side, `segments` (k, 2) their numbers. Summed over ends.
    """
    x = np.stack([curve.x, curve.y], axis=1)
    total = 0.0
    for end, inward, share in zip(*_pressed(curve, x), strict=True):
        a, edge = master[segments[:, 0]], master[segments[:, 1]] - master[segments[:, 0]]
        along = np.clip(((x[end] - a) * edge).sum(axis=1) / (edge**2).sum(axis=1), 0.0, 1.0)
        nearest = np.hypot(*(a + along[:, None] * edge - x[end]).T).argmin()
        # the slave's body lies on one side of its chain and the master's on the other: they run against each other
        own = inward * (x[end + inward] - x[end])
        total += share * float(_between(own[None], -edge[nearest][None])[0])
    return total


def _pressed(curve: ContactCurve, x: Floats) -> tuple[Ints, Ints, Floats]:
    """Ends of chains that are pressed (e,), +1 or -1 to the next node of each (e,), and shares of the force (e,)."""
    same = np.diff(curve.chain) == 0
    length = np.where(same, np.hypot(*np.diff(x, axis=0).T), 0.0)
    force = curve.nodal_pressure * 0.5 * (np.append(length, 0.0) + np.insert(length, 0, 0.0))
    before, after = np.insert(same, 0, False), np.append(same, False)
    ends = np.flatnonzero((force > 0.0) & (before != after))
    return np.asarray(ends), np.where(after[ends], 1, -1), np.asarray(force[ends] / max(force.sum(), 1e-300))


def _between(a: Floats, b: Floats) -> Floats:
    """Angles [rad] between vectors (e, 2)."""
    return np.asarray(np.abs(np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], (a * b).sum(axis=1))))
