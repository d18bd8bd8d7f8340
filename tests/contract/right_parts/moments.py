# kind measure cls Spread
import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import RunMeasure


@dataclass(frozen=True)
class Spread(RunMeasure):
    """Radius of gyration of the pressure along the slave."""

    title: ClassVar[str] = "radius of the pressure"
    unit: ClassVar[str] = "length"
    meaning: ClassVar[str] = "Root of the second moment of the pressure about its centre, along the slave."

    def evaluate(self, record, contact, reference):
        curve = record.curve(contact)
        p = np.nan_to_num(curve.nodal_pressure)
        if len(p) < 2 or not (p > 0.0).any():
            return math.nan
        same = curve.chain[:-1] == curve.chain[1:]
        w = np.zeros(len(p))
        half = 0.5 * np.hypot(np.diff(curve.x), np.diff(curve.y)) * same
        w[:-1] += half
        w[1:] += half
        s = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(curve.x), np.diff(curve.y)))])
        total = float((w * p).sum())
        if total <= 0.0:
            return math.nan
        centre = float((w * p * s).sum()) / total
        return math.sqrt(float((w * p * (s - centre) ** 2).sum()) / total)
