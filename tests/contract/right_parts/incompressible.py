# kind material cls Nearly
import math
from dataclasses import dataclass

from contactlab.api import UNIT, Material, formula


@dataclass(frozen=True)
class Nearly(Material):
    """Nearly incompressible: mu/2 (I1 J^-2/3 - 3) + K/4 (J^2 - 1 - 2 ln J), K 500 times mu.

    mu       shear modulus [MPa]
    factor   K over mu [-]
    density  [t/mm3]
    """

    density: float = 1e-9
    mu: float = 1.0
    factor: float = 500.0

    @formula
    def stress(F, p):
        J = F.det()
        b = F @ F.T() * J ** (-2.0 / 3.0)
        return p.mu / J * b.deviator() + 0.5 * p.factor * p.mu * (J - 1.0 / J) * UNIT

    @formula
    def energy(F, p):
        J = F.det()
        b = F @ F.T() * J ** (-2.0 / 3.0)
        return (0.5 * p.mu * (b.trace() - 3.0) + 0.25 * p.factor * p.mu * (J * J - 1.0 - 2.0 * math.log(J))) / J
