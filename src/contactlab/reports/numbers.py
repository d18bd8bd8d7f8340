"""Format of numbers in tables and plots."""

from __future__ import annotations

import math

MISSING = "\N{EN DASH}"


def significant(value: float, digits: int = 3) -> str:
    """`digits` significant digits, powers of ten outside 1e-3 .. 1e6; whole numbers if `digits` is 0."""
    if math.isnan(value):
        return MISSING
    if math.isinf(value):
        return "∞" if value > 0 else "-∞"
    if value == 0.0 or digits == 0:
        return f"{value:.0f}"
    mantissa, _, power = f"{value:.{digits - 1}e}".partition("e")
    exponent = int(power)
    if not -3 <= exponent < 6:
        return f"{mantissa}e{exponent}"
    return f"{value:.{max(0, digits - 1 - exponent)}f}"


def percent(value: float, digits: int = 2) -> str:
    """A share in per cent, without the sign: 0.0123 -> "1.2"."""
    return significant(100.0 * value, digits)


def uncertain(value: float, error: float) -> str:
    """A value to the digits that its error leaves: 60.3214, 0.002 -> "60.321 ± 0.002"."""
    if not error > 0.0:
        return significant(value, 6)
    power = int(f"{error:.0e}".partition("e")[2])
    decimals = max(0, -power)
    return f"{value:.{decimals}f} ± {error:.{decimals}f}"


def quantity(value: object, unit: str, digits: int) -> str:
    """A value of a column: shares in per cent, texts as they are."""
    if not isinstance(value, int | float):
        return str(value)
    return percent(value, digits) if unit == "share" else significant(float(value), digits)


def heading_unit(unit: str, name: str) -> str:
    """The unit under a heading: "%" for shares, else the unit's `name`."""
    return "%" if unit == "share" else name
