"""Pressure laws: pressure as a function of the gap of surfaces that overlap or come close."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Floats, NormalLaw, formula

STEEPEST = 6.0  # clearances of overlap: an exponential continues along its tangent from there


@dataclass(frozen=True)
class LinearPressure(NormalLaw):
    """Pressure proportional to the overlap: penalty in pressures (Wriggers 2006, ch. 10.3).

    factor     stiffness over the stiffness of the cells behind both surfaces [-], if `stiffness` is 0
    stiffness  [MPa/mm] pressure per overlap; 0: from the cells behind
    """

    factor: float = 10.0
    stiffness: float = 0.0

    def __post_init__(self) -> None:
        _above_zero("factor", self.factor)
        _from_zero("stiffness", self.stiffness)

    @formula
    def pressure(gap: Any, stiffness: float, p: Any) -> Any:
        """Proportional to the overlap."""
        k = p.stiffness if p.stiffness > 0.0 else p.factor * stiffness
        return max(0.0, -k * gap)


@dataclass(frozen=True)
class ExponentialPressure(NormalLaw):
    """Softened contact: p0/(e - 1) (u e^u - u) with u = 1 - gap/c0, which is p0 at no gap and nothing from c0 on.

    Where surfaces overlap by more than six times c0 the pressure continues along its tangent.

    clearance  c0 [mm], gap at which pressure begins
    pressure_at_zero  p0 [MPa]; 0: `factor` times c0 times the stiffness of the cells behind both surfaces
    factor     [-] of `pressure_at_zero` if that is 0
    """

    pressure_before_contact: ClassVar[bool] = True
    length_scale: ClassVar[str] = "clearance"

    clearance: float
    pressure_at_zero: float = 0.0
    factor: float = 10.0

    def __post_init__(self) -> None:
        _above_zero("clearance", self.clearance)
        _above_zero("factor", self.factor)
        _from_zero("pressure_at_zero", self.pressure_at_zero)

    @formula
    def pressure(gap: Any, stiffness: float, p: Any) -> Any:
        """An exponential of the gap, its tangent at deep overlaps."""
        at_zero = p.pressure_at_zero if p.pressure_at_zero > 0.0 else p.factor * stiffness * p.clearance
        u = 1.0 - gap / p.clearance
        if u <= 0.0:
            return 0.0
        last = min(u, 1.0 + STEEPEST)
        growth = math.exp(last)
        along = (growth * (1.0 + last) - 1.0) * (u - last)
        return at_zero / (math.e - 1.0) * (last * (growth - 1.0) + along)

    def begins(self) -> float:
        """The clearance."""
        return self.clearance


@dataclass(frozen=True)
class TabularPressure(NormalLaw):
    """Pressure between given values, linear from each to the next; beyond the smallest gap along the last line.

    gaps       [mm] from the smallest, often an overlap (negative), to the one at which pressure begins
    pressures  [MPa] at these gaps, falling; the last is 0
    """

    gaps: tuple[float, ...]
    pressures: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.gaps) < 2 or not np.all(np.diff(self.gaps) > 0.0) or not np.isfinite(self.gaps).all():
            raise ValueError(f"gaps: got {self.gaps}, allowed: two or more rising values")
        falls = len(self.pressures) == len(self.gaps) and np.all(np.diff(self.pressures) < 0.0)
        if not falls or self.pressures[-1] != 0.0:
            raise ValueError(f"pressures: got {self.pressures}, allowed: falling values down to 0, one for each gap")

    def pressure(self, gap: Floats, stiffness: Floats, size: Floats, pressure: Floats, slope: Floats) -> None:
        """Linear between the entries."""
        gaps, values = np.array(self.gaps), np.array(self.pressures)
        part = np.clip(np.searchsorted(gaps, gap, side="right") - 1, 0, len(gaps) - 2)
        slope[:] = (np.diff(values) / np.diff(gaps))[part]
        pressure[:] = values[part] + slope * (gap - gaps[part])
        beyond = gap >= gaps[-1]
        slope[beyond] = pressure[beyond] = 0.0

    def begins(self) -> float:
        """The last gap."""
        return self.gaps[-1]


def _above_zero(name: str, value: float) -> None:
    if not 0.0 < value < math.inf:
        raise ValueError(f"{name}: got {value}, allowed: above 0, and finite")


def _from_zero(name: str, value: float) -> None:
    if not 0.0 <= value < math.inf:
        raise ValueError(f"{name}: got {value}, allowed: at least 0, and finite")
