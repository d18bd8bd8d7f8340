# kind material cls MooneyRivlin
from dataclasses import dataclass

from contactlab.api import UNIT, Material, formula


@dataclass(frozen=True)
class MooneyRivlin(Material):
    """c1 (I1 J^-2/3 - 3) + c2 (I2 J^-4/3 - 3) + K/2 (J - 1)^2 per undeformed volume.

    c1       [MPa]
    c2       [MPa]
    bulk     K [MPa]
    density  [t/mm3]
    """

    density: float = 1e-9
    c1: float = 0.4
    c2: float = 0.1
    bulk: float = 50.0

    @formula
    def stress(F, p):
        J = F.det()
        b = F @ F.T() * J ** (-2.0 / 3.0)
        first = b.trace()
        second = b @ b
        dev = (p.c1 + p.c2 * first) * b.deviator() - p.c2 * second.deviator()
        return 2.0 / J * dev + p.bulk * (J - 1.0) * UNIT

    @formula
    def energy(F, p):
        J = F.det()
        b = F @ F.T() * J ** (-2.0 / 3.0)
        first = b.trace()
        second = 0.5 * (first * first - (b @ b).trace())
        return (p.c1 * (first - 3.0) + p.c2 * (second - 3.0) + 0.5 * p.bulk * (J - 1.0) ** 2) / J
