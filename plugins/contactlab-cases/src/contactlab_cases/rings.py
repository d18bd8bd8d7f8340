"""Rings and discs pressed together: closed forms from Airy's stress functions. Plane strain, small strains.

Smooth, curved, without an edge of contact and with an exact answer: what is left is the error of the contact itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from contactlab.api import Floats

SOURCE = "Michell 1899; Timoshenko & Goodier, Theory of Elasticity, 28 and 43"

Moduli = tuple[float, float]
"""E [MPa] and nu."""


@dataclass(frozen=True)
class TwoRings:
    """Rings a..b and b..c under an outer pressure P0 + P2 cos 2t, without friction.

    a, b, c         radii [mm]; a = 0 is a full disc
    inner, outer    moduli of the rings
    """

    a: float
    b: float
    c: float
    inner: Moduli
    outer: Moduli

    def pressure(self, mean: float, wave: float) -> tuple[float, float]:
        """Mean and amplitude (of cos 2t) of the pressure [MPa] between the rings under the outer mean + wave cos 2t."""
        return mean * self._between((0, 1), []), wave * self._between((2, 3, 4, 5), [1])

    def bonded(self, mean: float, wave: float) -> tuple[float, float, float]:
        """Traction [MPa] between rings that stick to each other under the outer pressure mean + wave cos 2t.

        Mean and amplitude (of cos 2t) of the pressure, and amplitude (of sin 2t) of the shear on the inner ring's edge.
        """
        b, c, terms = self.b, self.c, (2, 3, 4, 5)
        inner = terms if self.a else _regular(terms)
        none = [0.0] * len(inner), [0.0] * len(terms)
        rows = [[t[k](self.a) for k in inner] + none[1] for t in _TRACTIONS] if self.a else []
        rows += [none[0] + [t[k](c) for k in terms] for t in _TRACTIONS]
        rows += [[t[k](b) for k in inner] + [-t[k](b) for k in terms] for t in _TRACTIONS]
        for moved in (_motion, _turning):
            rows.append([moved(k, b, self.inner) for k in inner] + [-moved(k, b, self.outer) for k in terms])
        right = [0.0] * len(rows)
        right[2 if self.a else 0] = -1.0  # s_r at c
        found = _solved(rows, right)[: len(inner)]
        pressure, shear = (float(np.dot([t[k](b) for k in inner], found)) for t in _TRACTIONS)
        return mean * self._between((0, 1), []), -wave * pressure, wave * shear

    def _between(self, terms: tuple[int, ...], free: list[int]) -> float:
        """Pressure at b under a unit pressure at c; `free` of further tractions that vanish everywhere: the shear."""
        b, c = self.b, self.c
        inner = _regular(terms) if self.a == 0.0 else terms
        none = [0.0] * len(inner), [0.0] * len(terms)
        rows, right = [], []
        for component in [0, *free] if self.a else []:
            rows.append([_TRACTIONS[component][k](self.a) for k in inner] + none[1])
            right.append(0.0)
        for component in free:
            rows += [[_TRACTIONS[component][k](b) for k in inner] + none[1]]
            rows += [none[0] + [_TRACTIONS[component][k](r) for k in terms] for r in (b, c)]
            right += [0.0, 0.0, 0.0]
        at_b = [_TRACTIONS[0][k](b) for k in inner]
        rows += [
            none[0] + [_TRACTIONS[0][k](c) for k in terms],
            at_b + [-_TRACTIONS[0][k](b) for k in terms],
            [_motion(k, b, self.inner) for k in inner] + [-_motion(k, b, self.outer) for k in terms],
        ]
        found = _solved(rows, [*right, -1.0, 0.0, 0.0])
        return -float(np.dot(at_b, found[: len(inner)]))


def shrunk_rings(radii: Sequence[tuple[float, float]], moduli: Sequence[Moduli], overlaps: Sequence[float]) -> Floats:
    """Pressures (k,) [MPa] between rings from the inside out whose radii overlap by `overlaps` (k,) [mm].

    Radii describe the fitted rings: radii[i][1] == radii[i + 1][0].
    """

    def moved(ring: int, r: float, inside: float, outside: float) -> float:
        (ri, ro), (young, nu) = radii[ring], moduli[ring]
        a, b = inside * ri**2 - outside * ro**2, (inside - outside) * ri**2 * ro**2
        return (1.0 + nu) / young * ((1.0 - 2.0 * nu) * a * r + b / r) / (ro**2 - ri**2)

    count = len(overlaps)
    matrix = np.zeros((count, count))
    for k, (_, r) in enumerate(radii[:-1]):
        for j in range(count):
            unit = [0.0, *(1.0 if i == j else 0.0 for i in range(count)), 0.0]
            matrix[k, j] = moved(k + 1, r, *unit[k + 1 : k + 3]) - moved(k, r, *unit[k : k + 2])
    return np.asarray(np.linalg.solve(matrix, np.asarray(overlaps)))


# Terms 0, 1: Lame's A - B/r^2; 2 to 5: Michell's with cos 2t, from r^2, r^4, 1/r^2 and 1. First the radial stress, then
# the shear (of sin 2t).
_TRACTIONS = (
    (
        lambda r: 1.0, lambda r: -1.0 / r**2,
        lambda r: -2.0, lambda r: 0.0, lambda r: -6.0 / r**4, lambda r: -4.0 / r**2,
    ),
    (
        lambda r: 0.0, lambda r: 0.0,
        lambda r: 2.0, lambda r: 6.0 * r**2, lambda r: -6.0 / r**4, lambda r: -2.0 / r**2,
    ),
)  # fmt: skip


def _motion(term: int, r: float, ring: Moduli) -> float:
    """Radial displacement of a term."""
    young, nu = ring
    kappa, share = 3.0 - 4.0 * nu, (1.0 + nu) / young  # 1/(2 G)
    return share * (
        (1.0 - 2.0 * nu) * r, 1.0 / r, -2.0 * r, (kappa - 3.0) * r**3, 2.0 / r**3, (kappa + 1.0) / r,
    )[term]  # fmt: skip


def _turning(term: int, r: float, ring: Moduli) -> float:
    """Circumferential displacement of a term with sin 2t."""
    young, nu = ring
    kappa, share = 3.0 - 4.0 * nu, (1.0 + nu) / young
    return share * (0.0, 0.0, 2.0 * r, (kappa + 3.0) * r**3, 2.0 / r**3, -(kappa - 1.0) / r)[term]


def _regular(terms: tuple[int, ...]) -> tuple[int, ...]:
    """Terms without a pole at the centre."""
    return tuple(k for k in terms if k in (0, 2, 3))


def _solved(rows: list[list[float]], right: list[float]) -> Floats:
    """Columns scaled, since powers of the radius make them unlike."""
    matrix = np.array(rows)
    scale = np.abs(matrix).max(axis=0)
    return np.asarray(np.linalg.solve(matrix / scale, np.array(right)) / scale)


def stood_ring_pressure(a: float, b: float, c: float, moduli: Moduli) -> float:
    """Pressure [MPa] at b within a ring a..c of one material whose hole is held, under a unit pressure at c."""
    rows = [[_motion(k, a, moduli) for k in (0, 1)], [_TRACTIONS[0][k](c) for k in (0, 1)]]
    found = _solved(rows, [0.0, -1.0])
    return -float(np.dot([_TRACTIONS[0][k](b) for k in (0, 1)], found))
