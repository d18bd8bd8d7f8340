"""Loops over constraints, completed by the formulas of a normal law."""

from __future__ import annotations

from contactlab.api.compiled.dual import derivatives, seed, value
from contactlab.api.compiled.formulas import slots
from contactlab.api.compiled.kernel import kernel
from contactlab.api.compiled.records import column, put_column

FORMULA, PARAMETERS, NAMED = slots("FORMULA", "PARAMETERS", "NAMED")


@kernel
def pressure(gap, stiffness, size, pressure, slope, values):
    """Fill the pressure and its derivative by the gap."""
    p = column(values, 0, PARAMETERS)
    for i in range(gap.size):
        found = FORMULA(seed(gap[i], 0, 4), stiffness[i], size[i], p)
        pressure[i] = value(found)
        slope[i] = derivatives(found, 4)[0]


@kernel
def pressure_of_named(gap, stiffness, size, pressure, slope, rows, values):
    """Fill `pressure` for a law that needs or remembers numbers: `rows` of a constraint."""
    p = column(values, 0, PARAMETERS)
    for i in range(gap.size):
        found = FORMULA(seed(gap[i], 0, 4), stiffness[i], size[i], p, column(rows, i, NAMED))
        pressure[i] = value(found)
        slope[i] = derivatives(found, 4)[0]


@kernel
def evolve(gap, pressure, stiffness, size, out, rows, values):
    """Compute memory after a step."""
    p = column(values, 0, PARAMETERS)
    for i in range(gap.size):
        put_column(out, i, FORMULA(gap[i], pressure[i], stiffness[i], size[i], p, column(rows, i, NAMED)))


@kernel
def with_traction(first, stiffness, size, result, by_first, traction, by_traction, values):
    """Evaluate a formula of two numbers, as gap or pressure and the traction, and its derivatives by both."""
    p = column(values, 0, PARAMETERS)
    for i in range(first.size):
        found = FORMULA(seed(first[i], 0, 4), seed(traction[i], 1, 4), stiffness[i], size[i], p)
        result[i] = value(found)
        by_first[i], by_traction[i] = derivatives(found, 4)[0], derivatives(found, 4)[1]
