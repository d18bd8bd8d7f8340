"""Waves along the plane between two elastic half planes that slide on each other with Coulomb friction.

The upper one has shear modulus and density 1 and slides towards +x; the lower one has another modulus and the same
density; nu = 0. What moves as exp(i k x + p k t), with p per shear wave speed of the upper one, solves an equation
without k: if its real part is positive, the rate of growth p k has no bound, and the problem no answer.
"""

from __future__ import annotations

import cmath

import numpy as np
from numpy.typing import NDArray

from contactlab.api import Floats

STEPS, ROUNDS, NEAR = 12, 40, 1e-6


def compliance(p: complex, modulus: float, side: float) -> NDArray[np.complex128]:
    """(2, 2) from the stresses (xy, yy) on its surface to the displacements of a half plane, for k = 1.

    side  1.0 above the surface, -1.0 below it

    Potentials exp(i x - side a y) of the dilatation and exp(i x - side b y) of the rotation, a^2 = 1 + (p/c_p)^2,
    b^2 = 1 + (p/c_s)^2 (Achenbach 1973, 5.11).
    """
    a, b = cmath.sqrt(1.0 + p * p / (2.0 * modulus)), cmath.sqrt(1.0 + p * p / modulus)
    moved = np.array([[1j, -side * b], [-side * a, -1j]])
    stress = modulus * np.array([[-2j * side * a, b * b + 1.0], [2.0 * a * a, 2j * side * b]])
    return np.asarray(moved @ np.linalg.inv(stress))


def opening(p: complex, modulus: float, mu: float) -> complex:
    """Opening of the surfaces under a wave of stresses that obey Coulomb's law: zero for free waves."""
    difference = compliance(p, 1.0, 1.0) - compliance(p, modulus, -1.0)
    return complex(difference[1, 1] - mu * difference[1, 0])


def sliding_wave(modulus: float, mu: float) -> complex:
    """p of the wave that becomes the generalised Rayleigh wave as mu goes to zero: Newton's method, mu by mu.

    Raises ArithmeticError if there is no such wave: the materials are too unlike.
    """
    c = np.linspace(0.5, 0.9999, 400)
    values = np.array([opening(complex(0.0, -speed), modulus, 0.0).real for speed in c])
    found = np.flatnonzero((values[1:] * values[:-1] < 0.0) & (np.abs(values[1:] - values[:-1]) < 1e3))
    if not len(found):
        raise ArithmeticError("no generalised Rayleigh wave")
    p = complex(0.0, -float(c[found[-1]]))
    for part in np.linspace(0.0, 1.0, STEPS):
        p = _newton(p, modulus, mu * float(part))
    return p


def _newton(p: complex, modulus: float, mu: float) -> complex:
    for _ in range(ROUNDS):
        slope = (opening(p + NEAR, modulus, mu) - opening(p - NEAR, modulus, mu)) / (2.0 * NEAR)
        change = opening(p, modulus, mu) / slope
        p -= change
        if abs(change) < 1e-12:
            return p
    raise ArithmeticError(f"no wave found at mu = {mu:g}")


def driven_wave(times: Floats, shear: NDArray[np.complex128], modulus: float, mu: float) -> NDArray[np.complex128]:
    """(n,) of the pressure's wave exp(i x) while a shear exp(i x) [MPa] of (n,) pushes the upper surface, for k = 1.

    times  (n,) evenly from 0, at least half of them after the last push

    By Laplace's transform: the pressure is -C_yx shear/opening, along a line beyond all growth.
    """
    dt = float(times[1] - times[0])
    line = max(0.0, sliding_wave(modulus, mu).real) + 8.0 / float(times[-1])
    p = line + 2j * np.pi * np.fft.fftfreq(len(times), dt)
    answer = np.array([-compliance(q, 1.0, 1.0)[1, 0] / opening(q, modulus, mu) for q in p])
    return np.asarray(np.fft.ifft(answer * np.fft.fft(shear * np.exp(-line * times))) * np.exp(line * times))


def tapered(x: Floats, margin: float) -> Floats:
    """A window (n,) over x (n,): zero within `margin` of both ends, one from twice that on."""
    inside = np.clip(np.minimum(x - x.min(), x.max() - x) / margin - 1.0, 0.0, 1.0)
    return np.asarray(inside * inside * (3.0 - 2.0 * inside))


def growth_and_speed(times: Floats, wave: NDArray[np.complex128]) -> tuple[float, float]:
    """Rate of growth and speed of a wave exp(i x), its values (r,) at `times` (r,), by straight lines."""
    growth = np.polyfit(times, np.log(np.abs(wave)), 1)[0]
    turning = np.polyfit(times, np.unwrap(np.angle(wave)), 1)[0]
    return float(growth), float(-turning)


def short_growth(times: Floats, rows: Floats, x: Floats) -> float:
    """Rate of growth [1/s] of the waves of 2.7 to 4.5 nodes in rows (r, n) over x (n,), by a straight line."""
    parts = np.abs(np.fft.rfft(rows[:, np.argsort(x)], axis=1))
    nodes = len(x) / np.maximum(1, np.arange(parts.shape[1]))
    band = parts[:, (nodes > 2.7) & (nodes < 4.5)]
    return float(np.polyfit(times, np.log(np.linalg.norm(band, axis=1)), 1)[0])
