"""Hooke's law in rate form: Cauchy stress with the Jaumann rate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Floats, Material, Tensor, formula
from contactlab_solids.elastic_constants import check_elastic, elastic_limit, lame, lame_constants


@dataclass(frozen=True)
class Hypoelastic(Material):
    """Jaumann rate of the Cauchy stress = lambda tr(d) I + 2 mu d, on the current geometry.

    Integrated with the rotation of Hughes & Winget (1980), half of it before and half of it after the
    step's strain: rigid rotations are exact for any step, shear is second order. Large rotations, small
    elastic strains: the law has no stored energy, and a closed cycle of strain can leave work behind.

    young    Young's modulus [MPa]
    poisson  Poisson's ratio, -1 < poisson < 0.5
    density  of the undeformed body [t/mm3]
    yield_stress  of the material [MPa]: not used, but a run that exceeds it warns
    """

    young: float
    poisson: float
    density: float
    yield_stress: float | None = None

    history_size: ClassVar[int] = 4
    history_names: ClassVar[tuple[str, ...]] = ("stress_xx", "stress_yy", "stress_zz", "stress_xy")
    without: ClassVar[Mapping[str, str]] = {"finite strain": "linear-elastic"}
    beyond: ClassVar[Mapping[str, str]] = {"plasticity": "linear-hardening"}

    def __post_init__(self) -> None:
        check_elastic(self.young, self.poisson, self.density, self.yield_stress)

    def elastic_limit(self) -> float:
        """The yield stress [MPa]; inf if none is given."""
        return elastic_limit(self.yield_stress)

    def stiffening(self, gradient: Floats, stress: Floats, out: Floats) -> None:
        """Tension stiffens like a string, and the turning of a stress adds at most its principal difference."""
        mean, radius = 0.5 * (stress[0] + stress[1]), np.hypot(0.5 * (stress[0] - stress[1]), stress[3])
        _, shear = lame_constants(self.young, self.poisson)
        out[:] = 1.0 + (np.maximum(mean + radius, 0.0) + 2.0 * radius) / shear

    @formula
    def stress(G: Any, history: Any, p: Any) -> Any:
        """sigma = R (R sigma_old R^T + lambda tr(d) I + 2 mu d) R^T, R R = Q; `G`: increment at mid-step.

        G is referred to the middle of the step, so that with d = sym G and w = skew G the rotation
        Q = (I - w/2)^-1 (I + w/2) is exact for a rigid rotation of any angle below 180 degrees. Hooke's increment
        belongs to the middle of the step: added at its end it would be first order only.
        """
        first, shear = lame(p)
        h = 0.25 * (G.xy - G.yx)
        scale = 1.0 / (1.0 + h * h)
        c, s = (1.0 - h * h) * scale, 2.0 * h * scale  # of twice half the angle: what turns a stress half the way
        trace = G.xx + G.yy
        mean = 0.5 * (history.stress_xx + history.stress_yy) + (first + shear) * trace
        half, shearing = 0.5 * (history.stress_xx - history.stress_yy), history.stress_xy
        half, shearing = (
            c * half + s * shearing + shear * (G.xx - G.yy),
            c * shearing - s * half + shear * (G.xy + G.yx),
        )
        half, shearing = c * half + s * shearing, c * shearing - s * half
        zz = history.stress_zz + first * trace
        stress = Tensor(mean + half, shearing, shearing, mean - half, zz)
        return stress, (mean + half, mean - half, zz, shearing)
