"""A straight line through points, by least squares."""

from __future__ import annotations

from dataclasses import dataclass

from contactlab.api.arrays import Floats


@dataclass(frozen=True)
class LineFit:
    """y = mean + slope (x - middle).

    spread   sum of (x - middle)^2 over the points
    squares  sum of squared residuals
    count    number of points
    """

    mean: float
    slope: float
    middle: float
    spread: float
    squares: float
    count: int

    @property
    def free(self) -> int:
        """Degrees of freedom of the residuals."""
        return self.count - 2


def fitted_line(x: Floats, y: Floats) -> LineFit:
    """Least squares of at least two points with different `x`."""
    middle, mean = float(x.mean()), float(y.mean())
    away = x - middle
    spread = float((away**2).sum())
    slope = float((away * y).sum()) / spread
    squares = float(((y - mean - slope * away) ** 2).sum())
    return LineFit(mean, slope, middle, spread, squares, len(x))
