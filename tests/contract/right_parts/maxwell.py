# kind material cls Maxwell
from dataclasses import dataclass
from typing import ClassVar

from contactlab.api import UNIT, Material, Tensor, formula


@dataclass(frozen=True)
class Maxwell(Material):
    """K tr e 1 + 2 G (dev e) + 2 G1 (dev e - v), with dv/dt = (dev e - v) / tau, by implicit Euler.

    young    [MPa] of slow deformations
    poisson  [-] of slow deformations
    branch   [MPa] shear modulus of the Maxwell element
    tau      [s] its time of relaxation
    density  [t/mm3]
    """

    young: float
    poisson: float
    branch: float
    tau: float
    density: float
    history_names: ClassVar[tuple[str, ...]] = ("v_xx", "v_yy", "v_xy", "lost")
    history_size: ClassVar[int] = 4
    rate_dependent: ClassVar[bool] = True
    time_scale: ClassVar[str] = "tau"

    @formula
    def stress(H, history, dt, p):
        K, G = moduli(p.young, p.poisson)
        e = H.symmetric()
        d = e.deviator()
        share = dt / (p.tau + dt)
        old = Tensor(history.v_xx, history.v_xy, history.v_xy, history.v_yy, -history.v_xx - history.v_yy)
        new = old + share * (d - old)
        step = new - old
        driving = 2.0 * p.branch * (d - new)
        lost = history.lost + driving.dot(step)
        return K * e.trace() * UNIT + 2.0 * G * d + driving, (new.xx, new.yy, new.xy, lost)

    @formula
    def energy(H, history, p):
        K, G = moduli(p.young, p.poisson)
        e = H.symmetric()
        d = e.deviator()
        v = Tensor(history.v_xx, history.v_xy, history.v_xy, history.v_yy, -history.v_xx - history.v_yy)
        elastic = d - v
        return 0.5 * K * e.trace() ** 2 + G * d.dot(d) + p.branch * elastic.dot(elastic)

    @formula
    def dissipation(H, history, p):
        return history.lost


def moduli(young, poisson):
    return young / (3.0 * (1.0 - 2.0 * poisson)), 0.5 * young / (1.0 + poisson)
