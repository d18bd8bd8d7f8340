"""Loops over the points of a block, completed by the formulas of a law."""

from __future__ import annotations

from contactlab.api.compiled.dual import derivatives, seed, value
from contactlab.api.compiled.formulas import slots
from contactlab.api.compiled.kernel import kernel, point
from contactlab.api.compiled.records import column, put_column
from contactlab.api.tensors import Tensor

FORMULA, MEASURE, MEMORY, STORED, PARAMETERS = slots("FORMULA", "MEASURE", "MEMORY", "STORED", "PARAMETERS")


@point
def finite(a, b, c, d):
    """Return F from the rows of its inverse."""
    scale = 1.0 / (a * d - b * c)
    return Tensor(d * scale, -b * scale, -c * scale, a * scale, 1.0)


@point
def small(a, b, c, d):
    """Return gradients in rate form and of small displacements unchanged."""
    return Tensor(a, b, c, d, 0.0)


@point
def nothing(history, number):
    """Return the memory of a law without memory."""
    return ()


@point
def remembered(history, number):
    """Return the memory of a point."""
    return column(history, number, STORED)


@kernel
def stress(gradient, stress, values):
    """Fill stress rows of a law without history."""
    p = column(values, 0, PARAMETERS)
    a, b, c, d = gradient[0], gradient[1], gradient[2], gradient[3]
    xx, yy, zz, xy = stress[0], stress[1], stress[2], stress[3]
    for i in range(a.size):
        found, _ = FORMULA(MEASURE(a[i], b[i], c[i], d[i]), (), 0.0, p)
        xx[i], yy[i], zz[i], xy[i] = found.xx, found.yy, found.zz, found.xy


@kernel
def step(gradient, stress, values, history, dt):
    """Fill stress rows, and replace the history by the new one."""
    p = column(values, 0, PARAMETERS)
    a, b, c, d = gradient[0], gradient[1], gradient[2], gradient[3]
    xx, yy, zz, xy = stress[0], stress[1], stress[2], stress[3]
    for i in range(a.size):
        found, new = FORMULA(MEASURE(a[i], b[i], c[i], d[i]), MEMORY(history, i), dt, p)
        xx[i], yy[i], zz[i], xy[i] = found.xx, found.yy, found.zz, found.xy
        put_column(history, i, new)


@kernel
def tangent(gradient, history, dt, tangent, values):
    """Fill d(stress row)/d(gradient row)."""
    p = column(values, 0, PARAMETERS)
    for i in range(gradient.shape[1]):
        measure = MEASURE(
            seed(gradient[0, i], 0, 4), seed(gradient[1, i], 1, 4), seed(gradient[2, i], 2, 4),
            seed(gradient[3, i], 3, 4),
        )  # fmt: skip
        found, _ = FORMULA(measure, MEMORY(history, i), dt, p)
        xx, yy, zz, xy = (
            derivatives(found.xx, 4), derivatives(found.yy, 4), derivatives(found.zz, 4), derivatives(found.xy, 4)
        )  # fmt: skip
        tangent[0, 0, i], tangent[0, 1, i], tangent[0, 2, i], tangent[0, 3, i] = xx
        tangent[1, 0, i], tangent[1, 1, i], tangent[1, 2, i], tangent[1, 3, i] = yy
        tangent[2, 0, i], tangent[2, 1, i], tangent[2, 2, i], tangent[2, 3, i] = zz
        tangent[3, 0, i], tangent[3, 1, i], tangent[3, 2, i], tangent[3, 3, i] = xy


@kernel
def density(gradient, history, out, values):
    """Fill a number per volume."""
    p = column(values, 0, PARAMETERS)
    for i in range(gradient.shape[1]):
        measure = MEASURE(gradient[0, i], gradient[1, i], gradient[2, i], gradient[3, i])
        out[i] = value(FORMULA(measure, MEMORY(history, i), 0.0, p))
