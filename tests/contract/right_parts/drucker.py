# kind material cls Drucker
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import XX, XY, YY, ZZ, Material


@dataclass(frozen=True)
class Drucker(Material):
    """Drucker-Prager of small strains without dilatancy: q <= cohesion + slope * pressure, flow of the deviator alone.

    young     [MPa]
    poisson   [-]
    density   [t/mm3]
    cohesion  q without pressure [MPa]
    slope     of q by the pressure [-]
    """

    young: float = 500.0
    poisson: float = 0.25
    density: float = 2e-9
    cohesion: float = 1.0
    slope: float = 0.8
    kinematics: ClassVar[str] = "small"
    history_size: ClassVar[int] = 6
    history_names: ClassVar[tuple[str, ...]] = ("p_xx", "p_yy", "p_zz", "p_xy", "equivalent_plastic_strain", "lost")
    has_energy: ClassVar[bool] = True
    implicit_euler: ClassVar[bool] = False

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
        limit = np.maximum(self.cohesion - self.slope * mean, 0.0)
        flow = np.maximum(q - limit, 0.0) / (3.0 * shear)
        keep = 1.0 - 3.0 * shear * flow / np.where(q > 0.0, q, 1.0)
        plastic = (1.0 - keep) * dev / (2.0 * shear)
        dev = keep * dev
        stress[XX], stress[YY], stress[ZZ], stress[XY] = dev[0] + mean, dev[1] + mean, dev[2] + mean, dev[3]
        new_history[:4] = old[:4] + plastic
        new_history[4] = old[4] + flow
        new_history[5] = old[5] + np.minimum(q, limit) * flow

    def energy(self, gradient, history, energy):
        shear, bulk = self.moduli()
        mean, dev = self.elastic(gradient, history)
        square = dev[0] ** 2 + dev[1] ** 2 + dev[2] ** 2 + 2.0 * dev[3] ** 2
        energy[:] = 0.5 * mean**2 / bulk + square / (4.0 * shear)

    def dissipation(self, gradient, history, dissipation):
        dissipation[:] = history[5]
