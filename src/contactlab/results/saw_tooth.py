"""Node-to-node oscillation of a pressure, and depth of the facets that it acts on."""

from __future__ import annotations

import numpy as np

from contactlab.api import ContactCurve, Floats, Ints
from contactlab.api.arrays import Flags
from contactlab.meshing.curves import CORNER

EVENLY = 16  # nodes to the next pressed one: so much finer a side may be than facets of the other that press it


def pressure_saw(curve: ContactCurve, cusps: Flags | None = None) -> float:
    """The larger saw-tooth of nodal pressures, and of multipliers where they do not overshoot at an edge of contact."""
    return max(saw_tooth(curve, curve.nodal_pressure, cusps), saw_tooth(curve, curve.pressure, cusps, beside=2))


def saw_tooth(
    curve: ContactCurve,
    values: Floats,
    cusps: Flags | None = None,
    least: float = 0.0,
    beside: int = 1,
    fewest: int = 3,
) -> float:
    """Oscillation of `values` (m,) where the surface is pressed, over their largest magnitude, or over `least`.

    Second differences of a smooth function keep their sign from node to node, except at inflections; at a step they
    change it once, in a saw-tooth every time. So the smallest of three neighbours of alternating sign counts, a quarter
    of which is the height of the teeth; the result is the root mean square over the nodes that are checked: nodes with
    pressed neighbours of their own state, `beside` many on each side. Kinks between sticking and slipping nodes do not
    count. A cusp of the exact pressure looks like a tooth: nodes next to one of the `cusps` (m,) do not count either.
    `fewest`: nodes that must be checked to speak of teeth; with three, one differs. Isolated pressed nodes, between
    pressed nodes two or three nodes off or evenly spaced, are teeth of half their value.
    """
    largest = max(float(np.abs(values).max(initial=0.0)), least)
    if largest == 0.0:
        return 0.0
    heights, nodes = _heights(_inner(curve, cusps, beside), values, fewest)
    alone = np.abs(values[_alone(curve)]) / 2.0
    count = max(1, nodes + len(alone))
    return float(np.sqrt(((heights**2).sum() + (alone**2).sum()) / count)) / largest


def _heights(inner: Ints, values: Floats, fewest: int) -> tuple[Floats, int]:
    """Heights of the teeth at `inner` nodes, and the number of nodes that were looked at."""
    if len(inner) < fewest:
        return np.zeros(0), 0
    second = (values[inner - 1] - 2.0 * values[inner] + values[inner + 1]) / 4.0
    turns = (np.diff(inner) == 1) & (second[:-1] * second[1:] < 0.0)
    middle = np.flatnonzero(turns[:-1] & turns[1:]) + 1
    return np.abs([second[middle - 1], second[middle], second[middle + 1]]).min(axis=0), len(inner)


def _alone(curve: ContactCurve) -> Ints:
    """Pressed nodes with one or two open ones on either side, or as many on both, and pressed ones behind those."""
    pressed = np.flatnonzero(curve.nodal_pressure > 0.0)
    apart = np.where(np.diff(curve.chain[pressed]) == 0, np.diff(pressed), len(curve.chain))
    before, after = apart[:-1], apart[1:]
    evenly = (np.abs(before - after) <= 1) & (np.maximum(before, after) <= EVENLY)
    near = (np.minimum(before, after) > 1) & (evenly | (np.maximum(before, after) <= 3))
    return np.asarray(pressed[1:-1][near], np.int32)


def _inner(curve: ContactCurve, cusps: Flags | None, beside: int) -> Ints:
    """Pressed nodes with `beside` many neighbours of the same state and chain on each side, without cusps."""
    state = np.where(curve.nodal_pressure > 0.0, curve.state, 0)
    same = (state[:-1] == state[1:]) & (curve.chain[:-1] == curve.chain[1:]) & (state[1:] > 0)
    if cusps is not None:
        same &= ~(cusps[:-1] | cusps[1:])
    if len(same) < 2 * beside:
        return np.zeros(0, np.int32)
    windows = np.lib.stride_tricks.sliding_window_view(same, 2 * beside)
    return np.asarray(np.flatnonzero(windows.all(axis=1)) + beside, np.int32)


def largest_turn(curve: ContactCurve) -> float:
    """Largest angle [rad] between deformed segments at a pressed node or its neighbours.

    The pressure of a node lies on both adjacent segments: the angle at a single pressed node does not include how much
    these lean.
    """
    pressed = np.flatnonzero(curve.nodal_pressure > 0.0)
    near = np.asarray(np.unique([pressed - 1, pressed, pressed + 1]), np.int32)
    return float(_turns(curve, near)[0].max(initial=0.0))


def pressed_depth(curve: ContactCurve) -> float:
    """Largest depth [mm] of the deformed facets next to pressed nodes, length times angle over 8, without corners."""
    angle, length = _turns(curve, np.asarray(np.flatnonzero(curve.nodal_pressure > 0.0), np.int32))
    return float(np.where(angle < CORNER, angle * length / 8.0, 0.0).max(initial=0.0))


def _turns(curve: ContactCurve, at: Ints) -> tuple[Floats, Floats]:
    """Angles [rad] between the deformed segments at some nodes (m,), and the longer one's length [mm]."""
    inner = at[(at > 0) & (at < len(curve.x) - 1)]
    inner = inner[curve.chain[inner - 1] == curve.chain[inner + 1]]
    along = np.diff(curve.x), np.diff(curve.y)
    angle, length = np.arctan2(along[1], along[0]), np.hypot(*along)
    turn = np.abs(np.remainder(angle[inner] - angle[inner - 1] + np.pi, 2.0 * np.pi) - np.pi)
    return np.asarray(turn), np.maximum(length[inner], length[inner - 1])
