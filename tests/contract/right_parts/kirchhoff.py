# kind material cls Kirchhoff
from dataclasses import dataclass

from contactlab.api import UNIT, Material, formula


@dataclass(frozen=True)
class Kirchhoff(Material):
    """Saint Venant and Kirchhoff: S = lambda tr(E) I + 2 mu E.

    young [MPa]
    poisson [-]
    density [t/mm3]
    """

    young: float
    poisson: float
    density: float

    @formula
    def strain(F):
        return 0.5 * (F.T() @ F - UNIT)

    @formula
    def stress(F, p, strain):
        shear = 0.5 * p.young / (1.0 + p.poisson)
        lame = 2.0 * shear * p.poisson / (1.0 - 2.0 * p.poisson)
        E = strain(F)
        S = lame * E.trace() * UNIT + 2.0 * shear * E
        return F @ S @ F.T() / F.det()

    @formula
    def energy(F, p, strain):
        shear = 0.5 * p.young / (1.0 + p.poisson)
        lame = 2.0 * shear * p.poisson / (1.0 - 2.0 * p.poisson)
        E = strain(F)
        return (0.5 * lame * E.trace() * E.trace() + shear * E.dot(E)) / F.det()
