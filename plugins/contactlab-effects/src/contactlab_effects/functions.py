"""Functions by which loads, supports and fields vary."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from contactlab.api import Floats, Function


@dataclass(frozen=True)
class HalfEllipse(Function):
    """sqrt(1 - ((x - c)/a)^2), and 0 beyond: the pressure under a cylinder (Hertz 1882).

    half_width  a [mm, degree or s]
    centre      c [mm, degree or s]
    """

    half_width: float
    centre: float = 0.0

    def __post_init__(self) -> None:
        _check_positive("half_width", self.half_width)

    def values(self, at: Floats) -> Floats:
        """1 in the middle, 0 from the edges on."""
        return np.sqrt(np.maximum(0.0, 1.0 - ((at - self.centre) / self.half_width) ** 2))

    def breaks(self) -> tuple[float, ...]:
        """Both edges, where the slope is infinite."""
        return self.centre - self.half_width, self.end()

    def end(self) -> float:
        """The second edge."""
        return self.centre + self.half_width


@dataclass(frozen=True)
class Sine(Function):
    """sin(2 pi (x - x0)/period): a wave along an edge, or a vibration in time.

    period  from one wave to the next [mm, degree or s]
    start   x0, where it rises through 0 [mm, degree or s]
    """

    period: float
    start: float = 0.0

    def __post_init__(self) -> None:
        _check_positive("period", self.period)

    def values(self, at: Floats) -> Floats:
        """Return values between -1 and 1."""
        return np.sin(2.0 * np.pi * (at - self.start) / self.period)


@dataclass(frozen=True)
class Polynomial(Function):
    """c0 + c1 x + c2 x^2 + ...

    coefficients  c0, c1, c2 and so on, of x in mm, degrees or s
    """

    coefficients: tuple[float, ...]

    def __post_init__(self) -> None:
        if not self.coefficients or not all(map(math.isfinite, self.coefficients)):
            raise ValueError(f"coefficients: got {list(self.coefficients)}, allowed: one finite number or several")

    def values(self, at: Floats) -> Floats:
        """Evaluate by Horner's scheme."""
        return np.asarray(np.polynomial.polynomial.polyval(at, self.coefficients))


def _check_positive(name: str, value: float) -> None:
    if not 0.0 < value < math.inf:
        raise ValueError(f"{name}: got {value}, allowed: a number > 0")
