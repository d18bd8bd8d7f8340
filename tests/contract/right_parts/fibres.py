# kind material cls Fibres
import math
from dataclasses import dataclass
from typing import ClassVar

from contactlab.api import UNIT, Material, Tensor, formula


@dataclass(frozen=True)
class Fibres(Material):
    """Hooke's law and fibres along one direction that stiffen it (small strains).

    young   of the matrix [MPa]
    poisson [-]
    density [t/mm3]
    fibre   modulus of the fibres [MPa]
    angle   of the fibres to x [degree]
    """

    young: float = 1000.0
    poisson: float = 0.3
    density: float = 1e-9
    fibre: float = 3000.0
    angle: float = 30.0
    isotropic: ClassVar[bool] = False

    @formula
    def stress(H, p):
        shear = 0.5 * p.young / (1.0 + p.poisson)
        lame = 2.0 * shear * p.poisson / (1.0 - 2.0 * p.poisson)
        e = H.symmetric()
        c, s = math.cos(p.angle * math.pi / 180.0), math.sin(p.angle * math.pi / 180.0)
        M = Tensor(c * c, c * s, c * s, s * s, 0.0)
        return lame * e.trace() * UNIT + 2.0 * shear * e + p.fibre * e.dot(M) * M

    @formula
    def energy(H, p):
        shear = 0.5 * p.young / (1.0 + p.poisson)
        lame = 2.0 * shear * p.poisson / (1.0 - 2.0 * p.poisson)
        e = H.symmetric()
        c, s = math.cos(p.angle * math.pi / 180.0), math.sin(p.angle * math.pi / 180.0)
        M = Tensor(c * c, c * s, c * s, s * s, 0.0)
        return 0.5 * lame * e.trace() * e.trace() + shear * e.dot(e) + 0.5 * p.fibre * e.dot(M) * e.dot(M)
