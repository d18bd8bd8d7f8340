"""Two rings pressed together, the inner one with a free hole: the closed form, from Airy's stress functions.

Smooth, curved, without an edge of contact and with an exact answer: what is left is the error of the contact itself.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contactlab.api import Floats

SOURCE = "Michell 1899; Timoshenko & Goodier, Theory of Elasticity, 28 and 43"


@dataclass(frozen=True)
class TwoRings:
    """Rings a..b and b..c under an outer pressure P0 + P2 cos 2t, without friction. Plane strain, small strains.

    a, b, c         radii [mm]
    inner, outer    (E [MPa], nu) of the rings
    """

    a: float
    b: float
    c: float
    inner: tuple[float, float]
    outer: tuple[float, float]

    def pressure(self, mean: float, wave: float) -> tuple[float, float]:
        """Mean and amplitude (of cos 2t) of the pressure [MPa] between the rings under the outer mean + wave cos 2t."""
        return mean * self._mean(), wave * self._wave()

    def _mean(self) -> float:
        """Lame: s_r = A - B/r^2, u = (1 + nu)/E ((1 - 2 nu) A r + B/r); unknowns A, B of each ring."""
        a, b, c = self.a, self.b, self.c

        def stress(r: float) -> list[float]:
            return [1.0, -1.0 / r**2]

        def motion(r: float, ring: tuple[float, float]) -> list[float]:
            young, nu = ring
            return [(1.0 + nu) / young * (1.0 - 2.0 * nu) * r, (1.0 + nu) / young / r]

        none = [0.0, 0.0]
        rows = [
            stress(a) + none,
            none + stress(c),
            stress(b) + [-value for value in stress(b)],
            motion(b, self.inner) + [-value for value in motion(b, self.outer)],
        ]
        found = _solved(rows, [0.0, -1.0, 0.0, 0.0])
        return -float(np.dot(stress(b), found[:2]))

    def _wave(self) -> float:
        """Four terms of Michell's solution with cos 2t in each ring: r^2, r^4, 1/r^2 and 1."""
        none = [0.0] * 4

        def normal(r: float) -> list[float]:
            return [-2.0, 0.0, -6.0 / r**4, -4.0 / r**2]

        def shear(r: float) -> list[float]:
            return [2.0, 6.0 * r**2, -6.0 / r**4, -2.0 / r**2]

        def motion(r: float, ring: tuple[float, float]) -> list[float]:
            young, nu = ring
            kappa, share = 3.0 - 4.0 * nu, (1.0 + nu) / young  # 1/(2 G)
            return [share * v for v in (-2.0 * r, (kappa - 3.0) * r**3, 2.0 / r**3, (kappa + 1.0) / r)]

        a, b, c = self.a, self.b, self.c
        rows = [
            normal(a) + none,
            shear(a) + none,
            shear(b) + none,
            none + shear(b),
            none + shear(c),
            none + normal(c),
            normal(b) + [-value for value in normal(b)],
            motion(b, self.inner) + [-value for value in motion(b, self.outer)],
        ]
        found = _solved(rows, [0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0])
        return -float(np.dot(normal(b), found[:4]))


def _solved(rows: list[list[float]], right: list[float]) -> Floats:
    """Columns scaled, since powers of the radius make them unlike."""
    matrix = np.array(rows)
    scale = np.abs(matrix).max(axis=0)
    return np.asarray(np.linalg.solve(matrix / scale, np.array(right)) / scale)
