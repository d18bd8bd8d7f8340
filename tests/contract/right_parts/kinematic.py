# kind material cls Kinematic
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import XX, XY, YY, ZZ, Material


@dataclass(frozen=True)
class Kinematic(Material):
    """J2 of small strains with Prager's kinematic hardening: |s - 2/3 H ep| <= yield.

    young         [MPa]
    poisson       [-]
    density       [t/mm3]
    yield_stress  [MPa]
    hardening     H [MPa]
    """

    young: float = 2e5
    poisson: float = 0.3
    density: float = 8e-9
    yield_stress: float = 200.0
    hardening: float = 5e3
    kinematics: ClassVar[str] = "small"
    history_size: ClassVar[int] = 5
    history_names: ClassVar[tuple[str, ...]] = ("p_xx", "p_yy", "p_zz", "p_xy", "equivalent_plastic_strain")
    has_energy: ClassVar[bool] = True

    def moduli(self):
        shear = 0.5 * self.young / (1.0 + self.poisson)
        return shear, self.young / (3.0 - 6.0 * self.poisson)

    def wave_speeds(self):
        shear, bulk = self.moduli()
        return float(np.sqrt((bulk + 4.0 / 3.0 * shear) / self.density)), float(np.sqrt(shear / self.density))

    def deviator(self, gradient):
        xx, xy, yx, yy = gradient
        volume = xx + yy
        return volume, np.stack([xx - volume / 3.0, yy - volume / 3.0, -volume / 3.0, 0.5 * (xy + yx)])

    def stress(self, gradient, history, dt, stress, new_history):
        shear, bulk = self.moduli()
        old = history.copy()
        volume, strain = self.deviator(gradient)
        dev = 2.0 * shear * (strain - old[:4])
        shifted = dev - 2.0 / 3.0 * self.hardening * old[:4]
        q = np.sqrt(1.5 * (shifted[0] ** 2 + shifted[1] ** 2 + shifted[2] ** 2 + 2.0 * shifted[3] ** 2))
        flow = np.maximum(q - self.yield_stress, 0.0) / (3.0 * shear + self.hardening)
        direction = 1.5 * shifted / np.where(q > 0.0, q, 1.0)
        plastic = flow * direction
        dev = dev - 2.0 * shear * plastic
        mean = bulk * volume
        stress[XX], stress[YY], stress[ZZ], stress[XY] = dev[0] + mean, dev[1] + mean, dev[2] + mean, dev[3]
        new_history[:4] = old[:4] + plastic
        new_history[4] = old[4] + flow

    def energy(self, gradient, history, energy):
        shear, bulk = self.moduli()
        volume, strain = self.deviator(gradient)
        e, p = strain - history[:4], history[:4]

        def size(t):
            return t[0] ** 2 + t[1] ** 2 + t[2] ** 2 + 2.0 * t[3] ** 2

        energy[:] = 0.5 * bulk * volume**2 + shear * size(e) + self.hardening / 3.0 * size(p)

    def dissipation(self, gradient, history, dissipation):
        dissipation[:] = self.yield_stress * history[4]
