# kind material cls Perzyna
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import XX, XY, YY, ZZ, Material


@dataclass(frozen=True)
class Perzyna(Material):
    """J2 of small strains with a viscous overstress: d(ep)/dt = max(0, q - yield)/(3 G tau).

    young         [MPa]
    poisson       [-]
    density       [t/mm3]
    yield_stress  [MPa]
    tau           [s]
    """

    young: float = 2e5
    poisson: float = 0.3
    density: float = 8e-9
    yield_stress: float = 200.0
    tau: float = 1e-3
    kinematics: ClassVar[str] = "small"
    history_size: ClassVar[int] = 6
    history_names: ClassVar[tuple[str, ...]] = ("p_xx", "p_yy", "p_zz", "p_xy", "equivalent_plastic_strain", "lost")
    rate_dependent: ClassVar[bool] = True
    time_scale: ClassVar[str] = "tau"
    has_energy: ClassVar[bool] = True
    implicit_euler: ClassVar[bool] = True

    def moduli(self):
        shear = 0.5 * self.young / (1.0 + self.poisson)
        return shear, self.young / (3.0 - 6.0 * self.poisson)

    def wave_speeds(self):
        shear, bulk = self.moduli()
        return float(np.sqrt((bulk + 4.0 / 3.0 * shear) / self.density)), float(np.sqrt(shear / self.density))

    def elastic(self, gradient, history):
        shear, bulk = self.moduli()
        xx, xy, yx, yy = gradient
        volume = xx + yy
        dev = np.stack([xx - volume / 3.0, yy - volume / 3.0, -volume / 3.0, 0.5 * (xy + yx)]) - history[:4]
        return bulk * volume, 2.0 * shear * dev

    def stress(self, gradient, history, dt, stress, new_history):
        shear, _ = self.moduli()
        old = history.copy()
        mean, dev = self.elastic(gradient, old)
        q = np.sqrt(1.5 * (dev[0] ** 2 + dev[1] ** 2 + dev[2] ** 2 + 2.0 * dev[3] ** 2))
        over = np.maximum(q - self.yield_stress, 0.0)
        flow = over / (3.0 * shear) * dt / (self.tau + dt)
        end = q - 3.0 * shear * flow
        plastic = 1.5 * flow * dev / np.where(q > 0.0, q, 1.0)
        dev = dev - 2.0 * shear * plastic
        stress[XX], stress[YY], stress[ZZ], stress[XY] = dev[0] + mean, dev[1] + mean, dev[2] + mean, dev[3]
        new_history[:4] = old[:4] + plastic
        new_history[4] = old[4] + flow
        new_history[5] = old[5] + end * flow

    def energy(self, gradient, history, energy):
        shear, bulk = self.moduli()
        mean, dev = self.elastic(gradient, history)
        square = dev[0] ** 2 + dev[1] ** 2 + dev[2] ** 2 + 2.0 * dev[3] ** 2
        energy[:] = 0.5 * mean**2 / bulk + square / (4.0 * shear)

    def dissipation(self, gradient, history, dissipation):
        dissipation[:] = history[5]
