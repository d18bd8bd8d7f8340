# kind material cls Hill
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import XX, XY, YY, ZZ, Material


@dataclass(frozen=True)
class Hill(Material):
    """Elastic, and plastic by a Hill-like norm of the deviator: shear of the axes yields `ratio` times as early.

    young         [MPa]
    poisson       [-]
    density       [t/mm3]
    yield_stress  [MPa]
    ratio         weight of the shear [-]
    """

    young: float = 7e4
    poisson: float = 0.3
    density: float = 2.7e-9
    yield_stress: float = 100.0
    ratio: float = 1.5
    kinematics: ClassVar[str] = "small"
    isotropic: ClassVar[bool] = False
    history_size: ClassVar[int] = 5
    history_names: ClassVar[tuple[str, ...]] = ("p_xx", "p_yy", "p_zz", "p_xy", "lost")
    has_energy: ClassVar[bool] = True

    def moduli(self):
        shear = 0.5 * self.young / (1.0 + self.poisson)
        return shear, self.young / (3.0 - 6.0 * self.poisson)

    def wave_speeds(self):
        shear, bulk = self.moduli()
        return float(np.sqrt((bulk + 4.0 / 3.0 * shear) / self.density)), float(np.sqrt(shear / self.density))

    def norm(self, dev):
        return np.sqrt(1.5 * (dev[0] ** 2 + dev[1] ** 2 + dev[2] ** 2 + 2.0 * self.ratio * dev[3] ** 2))

    def elastic(self, gradient, history):
        shear, bulk = self.moduli()
        xx, xy, yx, yy = gradient
        volume = xx + yy
        dev = np.stack([xx - volume / 3.0, yy - volume / 3.0, -volume / 3.0, 0.5 * (xy + yx)]) - history[:4]
        return bulk * volume, 2.0 * shear * dev

    def stress(self, gradient, history, dt, stress, new_history):
        shear, _ = self.moduli()
        old = history.copy()
        mean, trial = self.elastic(gradient, old)
        weight = np.array([1.0, 1.0, 1.0, self.ratio])[:, None]
        # s_i (1 + 3 G l w_i) = trial_i, with l the flow over the yield stress
        low, high = np.zeros(mean.shape), np.full(mean.shape, 1.0)
        over = self.norm(trial) > self.yield_stress
        for _ in range(200):
            wide = over & (self.norm(trial / (1.0 + 3.0 * shear * high * weight)) > self.yield_stress)
            if not wide.any():
                break
            high = np.where(wide, 2.0 * high, high)
        for _ in range(90):
            middle = 0.5 * (low + high)
            more = self.norm(trial / (1.0 + 3.0 * shear * middle * weight)) > self.yield_stress
            low, high = np.where(more, middle, low), np.where(more, high, middle)
        flow = np.where(over, high, 0.0)
        dev = trial / (1.0 + 3.0 * shear * flow * weight)
        plastic = (trial - dev) / (2.0 * shear)
        stress[XX], stress[YY], stress[ZZ], stress[XY] = dev[0] + mean, dev[1] + mean, dev[2] + mean, dev[3]
        new_history[:4] = old[:4] + plastic
        new_history[4] = (
            old[4] + dev[0] * plastic[0] + dev[1] * plastic[1] + dev[2] * plastic[2] + 2.0 * dev[3] * plastic[3]
        )

    def energy(self, gradient, history, energy):
        shear, bulk = self.moduli()
        mean, dev = self.elastic(gradient, history)
        square = dev[0] ** 2 + dev[1] ** 2 + dev[2] ** 2 + 2.0 * dev[3] ** 2
        energy[:] = 0.5 * mean**2 / bulk + square / (4.0 * shear)

    def dissipation(self, gradient, history, dissipation):
        dissipation[:] = history[4]
