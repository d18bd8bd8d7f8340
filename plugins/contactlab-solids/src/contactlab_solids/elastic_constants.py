"""Young's modulus and Poisson's ratio: checks and conversions that all laws share."""

from __future__ import annotations

import math
from functools import cache
from typing import Any, NamedTuple

from contactlab.api import formula


class Lame(NamedTuple):
    """Lame's constants [MPa]: `lame` (first) and `shear`."""

    lame: float
    shear: float


def check_elastic(young: float, poisson: float, density: float, yield_stress: float | None = None) -> None:
    """Raise ValueError for constants outside the thermodynamic range."""
    if not young > 0.0:
        raise ValueError(f"young: got {young}, allowed: a modulus > 0 [MPa]")
    if not -1.0 < poisson < 0.5:
        hint = " (incompressible: try 0.499 with an element that does not lock)" if poisson == 0.5 else ""
        raise ValueError(f"poisson: got {poisson}, allowed: -1 < poisson < 0.5{hint}")
    if not density > 0.0:
        raise ValueError(f"density: got {density}, allowed: a density > 0 [t/mm3]")
    if yield_stress is not None and not yield_stress > 0.0:
        raise ValueError(f"yield_stress: got {yield_stress}, allowed: a stress > 0 [MPa]")


def elastic_limit(yield_stress: float | None) -> float:
    """Return the yield stress [MPa] given to an elastic law; inf for none."""
    return math.inf if yield_stress is None else yield_stress


@formula
def lame(p: Any) -> Any:
    """Lame's constants lambda and mu [MPa] of an isotropic solid with p.young and p.poisson, in formulas."""
    return p.young * p.poisson / ((1.0 + p.poisson) * (1.0 - 2.0 * p.poisson)), p.young / (2.0 * (1.0 + p.poisson))


@cache
def lame_constants(young: float, poisson: float) -> Lame:
    """Lame's constants lambda and mu [MPa] of an isotropic solid."""
    return Lame(young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)), young / (2.0 * (1.0 + poisson)))


def elastic_wave_speeds(young: float, poisson: float, density: float) -> tuple[float, float]:
    """Dilatational and shear speed [mm/s] in plane strain (c_p^2 = (lambda + 2 mu)/rho)."""
    lame, shear = lame_constants(young, poisson)
    return math.sqrt((lame + 2.0 * shear) / density), math.sqrt(shear / density)
