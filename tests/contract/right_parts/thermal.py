# kind material cls Thermal
from dataclasses import dataclass
from typing import ClassVar

from contactlab.api import UNIT, Material, formula


@dataclass(frozen=True)
class Thermal(Material):
    """Hooke's law less a thermal strain alpha dT I.

    young [MPa]
    poisson [-]
    density [t/mm3]
    alpha [1/K]
    heat  dT [K]
    """

    young: float = 2e5
    poisson: float = 0.3
    density: float = 8e-9
    alpha: float = 1.2e-5
    heat: float = 40.0
    stress_free: ClassVar[bool] = False

    @formula
    def stress(H, p):
        shear = 0.5 * p.young / (1.0 + p.poisson)
        lame = 2.0 * shear * p.poisson / (1.0 - 2.0 * p.poisson)
        return (
            lame * H.trace() * UNIT + 2.0 * shear * H.symmetric() - (3.0 * lame + 2.0 * shear) * p.alpha * p.heat * UNIT
        )

    @formula
    def energy(H, p):
        shear = 0.5 * p.young / (1.0 + p.poisson)
        lame = 2.0 * shear * p.poisson / (1.0 - 2.0 * p.poisson)
        e = H.symmetric() - p.alpha * p.heat * UNIT
        return 0.5 * lame * e.trace() * e.trace() + shear * e.dot(e)
