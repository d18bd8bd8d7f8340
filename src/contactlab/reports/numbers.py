"""How numbers are written in tables and plots."""

from __future__ import annotations

import math
from typing import Any

MISSING = "\N{EN DASH}"


def significant(value: float, digits: int = 3) -> str:
    """`digits` significant digits without needless zeros; powers of ten outside 1e-3 .. 1e6."""
    if math.isnan(value):
        return MISSING
    if math.isinf(value):
        return "∞" if value > 0 else "-∞"
    if value != 0.0 and not 1e-3 <= abs(value) < 1e6:
        mantissa, _, exponent = f"{value:.{max(0, digits - 1)}e}".partition("e")
        return f"{mantissa}e{int(exponent)}"
    if value == int(value) and abs(value) < 1e6:
        return str(int(value))
    decimals = digits - 1 - math.floor(math.log10(abs(value)))
    return f"{value:.{max(0, decimals)}f}"


def percent(value: float, digits: int = 2) -> str:
    """A share in per cent, without the sign: 0.0123 -> "1.2"."""
    return significant(100.0 * value, digits)


def quantity(value: Any, unit: str, digits: int) -> str:
    """A value of a column: shares in per cent, texts as they are."""
    if not isinstance(value, int | float):
        return str(value)
    return percent(value, digits) if unit == "share" else significant(float(value), digits)


def heading_unit(unit: str, name: str) -> str:
    """The unit under a heading: "%" for shares, else the unit's `name`."""
    return "%" if unit == "share" else name
