# kind measure cls PressureError
import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import RunMeasure


@dataclass(frozen=True)
class PressureError(RunMeasure):
    """L2 error of nodal pressures along x against the reference."""

    title: ClassVar[str] = "error of the pressure"
    unit: ClassVar[str] = "share"
    meaning: ClassVar[str] = "Root of the integral of the squared error of the pressure over that of the pressure."
    better: ClassVar[str] = "small"

    def evaluate(self, record, contact, reference):
        if reference is None:
            return math.nan
        curve = record.curve(contact)
        p = np.asarray(curve.nodal_pressure)
        if np.isnan(p).any() or not (p > 0.0).any():
            return math.nan
        order = np.argsort(curve.x)
        x, p = curve.x[order], p[order]
        exact = np.interp(x, reference.x, reference.pressure, 0.0, 0.0)
        norm = np.trapezoid(exact**2, x)
        return float(np.sqrt(np.trapezoid((p - exact) ** 2, x) / norm)) if norm > 0.0 else math.nan
