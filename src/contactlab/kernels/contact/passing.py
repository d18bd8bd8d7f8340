"""Points that pass through a chain of segments while both move along straight lines.

A segment has its body on the left: a point enters when it comes to the left of a segment, between its ends, and leaves
when it goes back. Both are roots of a quadratic in time, so that motions of any length are covered.
"""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats, Ints
from contactlab.api.compiled.kernel import kernel, section

EVENTS = 32  # passages of one point that are checked
SLACK = 1e-9  # of a segment and of the motion: no point slips through between two segments, or just before the start


@section
def _cross(ax, ay, bx, by):
    return ax * by - ay * bx


@section
def _distance(rx, ry, ex, ey):
    """Return the distance [mm] of a point from a segment, both from its first end."""
    along = min(1.0, max(0.0, (rx * ex + ry * ey) / (ex * ex + ey * ey)))
    return np.hypot(rx - along * ex, ry - along * ey)


@section
def _add(events, count, time, segment, speed):
    """Insert a passage in the order of time. Return their number."""
    k = min(count, EVENTS - 1)
    while k > 0 and events[k - 1, 0] > time:
        for c in range(3):
            events[k, c] = events[k - 1, c]
        k -= 1
    events[k, 0], events[k, 1], events[k, 2] = time, segment, speed
    return min(count + 1, EVENTS)


@section
def _roots(a, b, c):
    """Return roots of a t^2 + b t + c; NaN if there are fewer than two."""
    square = b * b - 4.0 * a * c
    if square < 0.0 or (a == 0.0 and b == 0.0):
        return np.nan, np.nan
    q = -0.5 * (b + np.copysign(np.sqrt(square), b))
    return (c / q if q != 0.0 else np.nan), (q / a if a != 0.0 else np.nan)


@section
def _opposed(s, r, t, before, after, segments):
    """Return whether two segments face away from each other at a time, as the sides of a plate."""
    product = 0.0
    for c in range(2):
        one = (1.0 - t) * (before[segments[s, 1], c] - before[segments[s, 0], c])
        two = (1.0 - t) * (before[segments[r, 1], c] - before[segments[r, 0], c])
        one += t * (after[segments[s, 1], c] - after[segments[s, 0], c])
        two += t * (after[segments[r, 1], c] - after[segments[r, 0], c])
        product += one * two
    return product < 0.0


@section
def _cuts_a_corner(s, r, x, y, t, before, after, chain, segments, limit):
    """Return whether two segments share a vertex that is within `limit` [mm] of a point (x, y) at a time.

    Closed chains may have a node twice, first and last, of one number.
    """
    for e in range(2):
        v = segments[s, e]
        if chain[v] == chain[segments[r, 1 - e]]:
            vx = (1.0 - t) * before[v, 0] + t * after[v, 0]
            vy = (1.0 - t) * before[v, 1] + t * after[v, 1]
            return np.hypot(x - vx, y - vy) <= limit
    return False


@section
def _behind(segment, end, after, segments):
    """Return the distance of a point at `end` (2,) behind the line of a segment [mm]."""
    n, m = segments[segment, 0], segments[segment, 1]
    ex, ey = after[m, 0] - after[n, 0], after[m, 1] - after[n, 1]
    return -_cross(end[0] - after[n, 0], end[1] - after[n, 1], ex, ey) / np.hypot(ex, ey)


@section
def _far(end, after, segments, limit):
    """Return whether all segments are farther than `limit` [mm] from a point at `end` (2,)."""
    for s in range(segments.shape[0]):
        n, m = segments[s, 0], segments[s, 1]
        ex, ey = after[m, 0] - after[n, 0], after[m, 1] - after[n, 1]
        if _distance(end[0] - after[n, 0], end[1] - after[n, 1], ex, ey) <= limit:
            return False
    return True


@kernel
def passages(start, end, own, before, after, chain, segments, order, first, last, limit, out):
    """Find points that are deeper than `limit` [mm] inside a chain after a motion, or have come out behind it.

    start, end     (p, 2) [mm] of the points, own (p,) their numbers: no point passes through a segment that it ends
    before, after  (n, 2) [mm] of the nodes of the chain, chain (n,) their numbers, segments (s, 2) between them
    order          (s,) segments, checked from first[i] to last[i] for point i
    out            (p,) share of the motion at depth `limit`, or in the middle between both sides; inf without
                   passage
    """
    events = np.empty((EVENTS, 3))
    for i in range(start.shape[0]):
        out[i], count, near, entered, shallow = np.inf, 0, limit, -1, False
        px, py = start[i, 0], start[i, 1]
        dpx, dpy = end[i, 0] - px, end[i, 1] - py
        for z in range(first[i], last[i]):
            s = order[z]
            n, m = segments[s, 0], segments[s, 1]
            if chain[n] == own[i] or chain[m] == own[i]:
                continue
            rx, ry = px - before[n, 0], py - before[n, 1]
            ex, ey = before[m, 0] - before[n, 0], before[m, 1] - before[n, 1]
            drx, dry = dpx - after[n, 0] + before[n, 0], dpy - after[n, 1] + before[n, 1]
            dex, dey = after[m, 0] - after[n, 0] - ex, after[m, 1] - after[n, 1] - ey
            shallow |= _distance(rx + drx, ry + dry, ex + dex, ey + dey) <= limit
            side, far, along = (
                _cross(rx, ry, ex, ey),
                _distance(rx, ry, ex, ey),
                (rx * ex + ry * ey) / (ex * ex + ey * ey),
            )
            # a point that touches, or is slightly inside before, is inside from the start
            if far < near or (far == near and side <= 0.0):
                near, entered = far, s if side <= 0.0 and -SLACK <= along <= 1.0 + SLACK else -1
            a, b = _cross(drx, dry, dex, dey), _cross(rx, ry, dex, dey) + _cross(drx, dry, ex, ey)
            for t in _roots(a, b, side):
                slope = 2.0 * a * t + b
                if not -SLACK <= t <= 1.0 or slope == 0.0:
                    continue
                x, y, ux, uy = rx + t * drx, ry + t * dry, ex + t * dex, ey + t * dey
                along = (x * ux + y * uy) / (ux * ux + uy * uy)
                if -SLACK <= along <= 1.0 + SLACK:
                    count = _add(events, count, max(t, 0.0), s, -slope / np.hypot(ux, uy))
        time, speed = 0.0, 0.0
        for k in range(count):
            now, s = events[k, 0], int(events[k, 1])
            if events[k, 2] > 0.0:
                if entered < 0:
                    entered, time, speed = s, now, events[k, 2]
            elif entered >= 0:
                x, y = px + now * dpx, py + now * dpy
                cut = _cuts_a_corner(entered, s, x, y, now, before, after, chain, segments, limit)
                if s != entered and not cut and _opposed(entered, s, now, before, after, segments):
                    out[i] = 0.5 * (time + now)
                    break
                entered = -1
        if out[i] < np.inf or entered < 0 or shallow or not _far(end[i], after, segments, limit):
            continue
        if speed > 0.0:
            out[i] = min(time + limit / speed, 0.5 * (time + 1.0))
        else:  # next to a chain that it touched it has not passed through
            depth = _behind(entered, end[i], after, segments)
            if depth > limit:
                out[i] = limit / depth


def find_passages(
    points: tuple[Floats, Floats, Ints], chain: tuple[Floats, Floats, Ints], segments: Ints, limit: float
) -> Floats:
    """Find passages (p,) of points through a chain by `passages`; points and chain: before, after, numbers.

    Segments are sorted along the direction of their largest spread, and each point is tested against segments
    whose path may meet its own.
    """
    (start, end, own), (before, after, numbers) = points, chain
    ends = np.concatenate([before[segments], after[segments]], axis=1)
    along = int(np.argmax(np.ptp(ends.reshape(-1, 2), axis=0)))
    low, high = ends[..., along].min(axis=1), ends[..., along].max(axis=1)
    order, out, path = (
        np.argsort(low, kind="stable"),
        np.empty(len(start)),
        np.sort([start[:, along], end[:, along]], 0),
    )
    reach = 1.001 * limit
    first = np.searchsorted(low[order], path[0] - reach - float((high - low).max()))
    last = np.searchsorted(low[order], path[1] + reach, side="right")
    arrays = [np.ascontiguousarray(array) for array in (start, end, own, before, after, numbers)]
    passages(*arrays, segments, order, first, last, limit, out)
    return out
