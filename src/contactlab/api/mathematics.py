"""Functions of numbers for formulas, and dual numbers in plain Python.

Formulas that say `math.sqrt`, `np.sqrt` or `sqrt` all mean the function of that name here: in a kernel it is compiled
(`contactlab.api.compiled.mathematics`), in Python it takes floats and dual numbers.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from contactlab.api.arrays import Floats

__all__ = [
    "DualNumber", "absolute", "acos", "arccos", "arcsin", "arctan", "arctan2", "asin", "atan", "atan2", "copysign",
    "cos", "cosh", "e", "exp", "fabs", "hypot", "inf", "isnan", "log", "maximum", "minimum", "nan", "pi", "power",
    "sin", "sinh", "sqrt", "tan", "tanh", "where",
]  # fmt: skip

pi, e, inf, nan = math.pi, math.e, math.inf, math.nan


class DualNumber:
    """A value and its derivatives (d,). Comparisons use the value: at a kink the derivative is one-sided."""

    __array_ufunc__ = None
    __slots__ = ("derivatives", "value")

    def __init__(self, value: float, derivatives: Floats) -> None:
        self.value, self.derivatives = value, derivatives

    def __repr__(self) -> str:
        return f"{self.value} (d {self.derivatives.tolist()})"

    def __float__(self) -> float:
        raise TypeError("a function that takes floats alone has lost the derivatives of a formula")

    def __add__(self, other: Any) -> DualNumber:
        value, derivatives = _parts(other)
        return DualNumber(self.value + value, self.derivatives + derivatives)

    __radd__ = __add__

    def __sub__(self, other: Any) -> DualNumber:
        value, derivatives = _parts(other)
        return DualNumber(self.value - value, self.derivatives - derivatives)

    def __rsub__(self, other: Any) -> DualNumber:
        return DualNumber(other - self.value, -self.derivatives)

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, tuple):
            return NotImplemented
        value, derivatives = _parts(other)
        return DualNumber(self.value * value, self.derivatives * value + self.value * derivatives)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> DualNumber:
        value, derivatives = _parts(other)
        found = self.value / value
        return DualNumber(found, (self.derivatives - found * derivatives) / value)

    def __rtruediv__(self, other: Any) -> DualNumber:
        return DualNumber(other / self.value, -other / self.value**2 * self.derivatives)

    def __neg__(self) -> DualNumber:
        return DualNumber(-self.value, -self.derivatives)

    def __pos__(self) -> DualNumber:
        return self

    def __abs__(self) -> DualNumber:
        return -self if self.value < 0.0 else self

    def __pow__(self, other: Any) -> DualNumber:
        return power(self, other)  # type: ignore[no-any-return]

    def __rpow__(self, other: Any) -> DualNumber:
        return power(other, self)  # type: ignore[no-any-return]

    def __lt__(self, other: Any) -> bool:
        return self.value < _parts(other)[0]

    def __le__(self, other: Any) -> bool:
        return self.value <= _parts(other)[0]

    def __gt__(self, other: Any) -> bool:
        return self.value > _parts(other)[0]

    def __ge__(self, other: Any) -> bool:
        return self.value >= _parts(other)[0]

    def __eq__(self, other: object) -> bool:
        return self.value == _parts(other)[0]

    def __ne__(self, other: object) -> bool:
        return self.value != _parts(other)[0]

    __hash__ = None  # type: ignore[assignment]


def _parts(number: Any) -> tuple[float, Any]:
    return (number.value, number.derivatives) if isinstance(number, DualNumber) else (number, 0.0)


def _chain(value: float, *changes: tuple[float, Any]) -> Any:
    """Return a function's value, dual if an argument is; changes = (its derivative by an argument, the argument)."""
    duals = [slope * number.derivatives for slope, number in changes if isinstance(number, DualNumber)]
    return DualNumber(value, sum(duals[1:], start=duals[0])) if duals else value


def sqrt(x: Any) -> Any:
    """Return the square root."""
    found = math.sqrt(_parts(x)[0])
    return _chain(found, (0.5 / found if found else inf, x))


def exp(x: Any) -> Any:
    """Return the exponential."""
    found = math.exp(_parts(x)[0])
    return _chain(found, (found, x))


def log(x: Any) -> Any:
    """Return the natural logarithm; NaN if x is not positive, as in kernels."""
    value = _parts(x)[0]
    return _chain(math.log(value) if value > 0.0 else nan, (1.0 / value if value else inf, x))


def sin(x: Any) -> Any:
    """Return the sine."""
    value = _parts(x)[0]
    return _chain(math.sin(value), (math.cos(value), x))


def cos(x: Any) -> Any:
    """Return the cosine."""
    value = _parts(x)[0]
    return _chain(math.cos(value), (-math.sin(value), x))


def tan(x: Any) -> Any:
    """Return the tangent."""
    found = math.tan(_parts(x)[0])
    return _chain(found, (1.0 + found * found, x))


def asin(x: Any) -> Any:
    """Return the inverse sine."""
    value = _parts(x)[0]
    return _chain(math.asin(value), (1.0 / math.sqrt(1.0 - value * value), x))


def acos(x: Any) -> Any:
    """Return the inverse cosine."""
    value = _parts(x)[0]
    return _chain(math.acos(value), (-1.0 / math.sqrt(1.0 - value * value), x))


def atan(x: Any) -> Any:
    """Return the inverse tangent."""
    value = _parts(x)[0]
    return _chain(math.atan(value), (1.0 / (1.0 + value * value), x))


def sinh(x: Any) -> Any:
    """Return the hyperbolic sine."""
    value = _parts(x)[0]
    return _chain(math.sinh(value), (math.cosh(value), x))


def cosh(x: Any) -> Any:
    """Return the hyperbolic cosine."""
    value = _parts(x)[0]
    return _chain(math.cosh(value), (math.sinh(value), x))


def tanh(x: Any) -> Any:
    """Return the hyperbolic tangent."""
    found = math.tanh(_parts(x)[0])
    return _chain(found, (1.0 - found * found, x))


def hypot(x: Any, y: Any) -> Any:
    """Return the root of x^2 + y^2."""
    a, b = _parts(x)[0], _parts(y)[0]
    found = math.hypot(a, b)
    return _chain(found, (a / found if found else nan, x), (b / found if found else nan, y))


def atan2(y: Any, x: Any) -> Any:
    """Return the angle of the vector (x, y)."""
    b, a = _parts(y)[0], _parts(x)[0]
    square = a * a + b * b
    return _chain(math.atan2(b, a), (a / square if square else nan, y), (-b / square if square else nan, x))


def power(x: Any, exponent: Any) -> Any:
    """Return x ** exponent."""
    a, b = _parts(x)[0], _parts(exponent)[0]
    found = a**b
    by_base = b * a ** (b - 1.0) if b != 0.0 and isinstance(x, DualNumber) else 0.0
    by_exponent = found * math.log(a) if isinstance(exponent, DualNumber) else 0.0
    return _chain(found, (by_base, x), (by_exponent, exponent))


def fabs(x: Any) -> Any:
    """Return the absolute value."""
    return abs(x)


def copysign(x: Any, y: Any) -> Any:
    """Return x with the sign of y."""
    a = abs(x)
    return -a if math.copysign(1.0, _parts(y)[0]) < 0.0 else a


def minimum(x: Any, y: Any) -> Any:
    """Return the smaller of two numbers."""
    return y if y < x else x


def maximum(x: Any, y: Any) -> Any:
    """Return the larger of two numbers."""
    return y if y > x else x


def where(condition: bool, x: Any, y: Any) -> Any:
    """Return x if a condition holds, else y."""
    return x if condition else y


def isnan(x: Any) -> bool:
    """Return whether a value is NaN."""
    return math.isnan(_parts(x)[0])


# NumPy's names for them
absolute, arcsin, arccos, arctan, arctan2 = fabs, asin, acos, atan, atan2


def seeds(values: Any) -> list[DualNumber]:
    """Return numbers, each of which is a direction itself."""
    unit = np.eye(len(values))
    return [DualNumber(float(value), unit[i]) for i, value in enumerate(values)]
