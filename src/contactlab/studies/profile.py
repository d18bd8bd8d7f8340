"""Piecewise linear functions of the deformed position, with exact integrals.

Pressures of different meshes are compared as functions, never node by node.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contactlab.api.arrays import Flags, Floats
from contactlab.results.results import ContactCurve

Window = tuple[float, float]

NOTHING = 1e-6
"""Share of the largest pressure up to which a node bears nothing: the inverse of T carries so much on to the next."""

# Two Gauss points integrate cubics exactly, and being interior they never meet the jump at a chain end.
_GAUSS = 0.5 / np.sqrt(3.0)


class FoldedSurfaceError(ValueError):
    """The pressed part of a surface turns back in x, so its pressure is not a function of x."""


@dataclass(frozen=True)
class Profile:
    """A piecewise linear function of x, zero outside its nodes.

    x      (m,) [mm] not decreasing
    value  (m,) at the nodes; a repeated x is a jump
    """

    x: Floats
    value: Floats

    @classmethod
    def of_curve(cls, curve: ContactCurve, column: str = "pressure") -> Profile:
        """A column of a contact curve over the deformed x.

        Raises FoldedSurfaceError when the part where the column is not zero turns back in x.
        """
        x, value = np.asarray(curve.x, float), np.nan_to_num(np.asarray(getattr(curve, column), float))
        return cls.of_nodes(x, value)

    @classmethod
    def of_nodes(cls, x: Floats, value: Floats) -> Profile:
        """Make a profile from nodes in chain order, in either direction. Raises FoldedSurfaceError."""
        ordered = _in_order(x, value)
        if ordered is None:
            # Sides of a body may stand upright as long as nothing presses there.
            ordered = _in_order(*_pressed_part(x, value))
        if ordered is None:
            raise FoldedSurfaceError("the pressed surface turns back in x; its pressure is not a function of x")
        return cls(*ordered)

    def __call__(self, x: Floats) -> Floats:
        """Values at x, zero outside the nodes."""
        if self.x.size == 0:
            return np.zeros(np.shape(x))
        return np.interp(x, self.x, self.value, left=0.0, right=0.0)

    def mirrored(self, axis: float = 0.0) -> Profile:
        """The mirror image about the line x = axis."""
        return Profile(2.0 * axis - self.x[::-1], self.value[::-1])

    def edges(self, level: float) -> Window | None:
        """Outermost positions [mm] where the function reaches `level` > 0; None if it never does."""
        above = np.flatnonzero(self.value >= level)
        if above.size == 0:
            return None
        return self._crossing(above[0], -1, level), self._crossing(above[-1], +1, level)

    def _crossing(self, inside: int, step: int, level: float) -> float:
        outside = inside + step
        if not 0 <= outside < self.x.size:
            return float(self.x[inside])
        high, low = self.value[inside], self.value[outside]
        share = (high - level) / (high - low)
        return float(self.x[inside] + share * (self.x[outside] - self.x[inside]))

    def spacing_at(self, x: float) -> float:
        """Length [mm] in x of the segment at position x (the nearest one outside the nodes)."""
        k = int(np.clip(np.searchsorted(self.x, x), 1, self.x.size - 1))
        return float(self.x[k] - self.x[k - 1])


def _in_order(x: Floats, value: Floats) -> tuple[Floats, Floats] | None:
    """The nodes with x not decreasing, or None when the chain turns back."""
    steps = np.diff(x)
    if np.all(steps >= 0.0):
        return x, value
    if np.all(steps <= 0.0):
        return x[::-1], value[::-1]
    return None


def bearing(value: Floats) -> Flags:
    """Return whether each node bears a part of the load: more than `NOTHING` of the largest value."""
    size = np.abs(value)
    return np.asarray(size > NOTHING * size.max(initial=0.0))


def _pressed_part(x: Floats, value: Floats) -> tuple[Floats, Floats]:
    """Part from the node before the first one that bears to the node after the last one."""
    pressed = np.flatnonzero(bearing(value))
    if pressed.size == 0:
        return x[:0], value[:0]
    part = slice(max(pressed[0] - 1, 0), pressed[-1] + 2)
    return x[part], value[part]


def integral(profile: Profile, window: Window | None = None) -> float:
    """Exact integral over the window, or over all x."""
    points, weights = _points((profile,), window)
    return float(weights @ profile(points))


def norm(profile: Profile, window: Window | None = None) -> float:
    """Exact L2 norm over the window, or over all x."""
    points, weights = _points((profile,), window)
    return float(np.sqrt(weights @ profile(points) ** 2))


def distance(a: Profile, b: Profile, window: Window | None = None) -> float:
    """Exact L2 norm of a - b over the window, or over all x; break points of both are merged."""
    points, weights = _points((a, b), window)
    return float(np.sqrt(weights @ (a(points) - b(points)) ** 2))


def _points(profiles: tuple[Profile, ...], window: Window | None) -> tuple[Floats, Floats]:
    """Quadrature points and weights, exact for products of two of the profiles."""
    breaks = np.unique(np.concatenate([p.x for p in profiles]))
    if window is not None:
        inside = breaks[(breaks > window[0]) & (breaks < window[1])]
        breaks = np.concatenate([[window[0]], inside, [window[1]]])
    return quadrature(breaks)


def quadrature(breaks: Floats) -> tuple[Floats, Floats]:
    """Points and weights, exact for products of two functions that are linear between these places."""
    lengths, middles = np.diff(breaks), 0.5 * (breaks[1:] + breaks[:-1])
    points = np.concatenate([middles - _GAUSS * lengths, middles + _GAUSS * lengths])
    return points, np.tile(0.5 * lengths, 2)
