# kind material cls Visco
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import XX, XY, YY, ZZ, Material


@dataclass(frozen=True)
class Visco(Material):
    """Hooke's law and a Maxwell branch of shear modulus `share` G: s' + s/tau = 2 share G e'.

    young, poisson  of the equilibrium [MPa], [-]
    share    stiffness of the branch over that of the equilibrium [-]
    tau      relaxation time [s]
    density  [t/mm3]
    """

    young: float = 1000.0
    poisson: float = 0.3
    share: float = 1.5
    tau: float = 0.02
    density: float = 1e-9
    kinematics: ClassVar[str] = "small"
    history_size: ClassVar[int] = 9
    history_names: ClassVar[tuple[str, ...]] = ("s_xx", "s_yy", "s_zz", "s_xy", "e_xx", "e_yy", "e_zz", "e_xy", "lost")
    rate_dependent: ClassVar[bool] = True
    time_scale: ClassVar[str] = "tau"
    has_energy: ClassVar[bool] = True

    def moduli(self):
        shear = 0.5 * self.young / (1.0 + self.poisson)
        return shear, 2.0 * shear * self.poisson / (1.0 - 2.0 * self.poisson)

    def wave_speeds(self):
        shear, lame = self.moduli()
        whole = shear * (1.0 + self.share)
        bulk = lame + 2.0 / 3.0 * shear
        return float(np.sqrt((bulk + 4.0 / 3.0 * whole) / self.density)), float(np.sqrt(whole / self.density))

    @staticmethod
    def deviator(gradient):
        xx, xy, yx, yy = gradient
        volume = xx + yy
        third = volume / 3.0
        return volume, np.stack([xx - third, yy - third, -third, 0.5 * (xy + yx)])

    def stress(self, gradient, history, dt, stress, new_history):
        shear, lame = self.moduli()
        volume, dev = self.deviator(gradient)
        old, before, lost = history[:4].copy(), history[4:8].copy(), history[8].copy()
        keep = np.exp(-dt / self.tau)
        mean = -np.expm1(-dt / self.tau) * self.tau / dt if dt > 0.0 else 1.0
        branch = keep * old + mean * 2.0 * self.share * shear * (dev - before)
        pressure = (lame + 2.0 / 3.0 * shear) * volume
        total = 2.0 * shear * dev + branch
        stress[XX] = total[0] + pressure
        stress[YY] = total[1] + pressure
        stress[ZZ] = total[2] + pressure
        stress[XY] = total[3]
        new_history[:4] = branch
        new_history[4:8] = dev
        done = 0.5 * (branch + old) * (dev - before)
        work = done[0] + done[1] + done[2] + 2.0 * done[3]
        new_history[8] = lost + np.maximum(work - self.stored(branch) + self.stored(old), 0.0)

    def stored(self, branch):
        shear, _ = self.moduli()
        square = branch[0] ** 2 + branch[1] ** 2 + branch[2] ** 2 + 2.0 * branch[3] ** 2
        return square / (4.0 * self.share * shear)

    def tangent(self, gradient, history, dt, tangent):
        shear, lame = self.moduli()
        mean = -np.expm1(-dt / self.tau) * self.tau / dt if dt > 0.0 else 1.0
        whole = shear * (1.0 + self.share * mean)
        bulk = lame + 2.0 / 3.0 * shear
        first = bulk - 2.0 / 3.0 * whole
        tangent[:] = 0.0
        for row in (XX, YY, ZZ):
            tangent[row, 0] = tangent[row, 3] = first
        tangent[XX, 0] += 2.0 * whole
        tangent[YY, 3] += 2.0 * whole
        tangent[XY, 1] = tangent[XY, 2] = whole

    def energy(self, gradient, history, energy):
        shear, lame = self.moduli()
        volume, dev = self.deviator(gradient)
        square = dev[0] ** 2 + dev[1] ** 2 + dev[2] ** 2 + 2.0 * dev[3] ** 2
        energy[:] = 0.5 * (lame + 2.0 / 3.0 * shear) * volume**2 + shear * square + self.stored(history[:4])

    def dissipation(self, gradient, history, dissipation):
        dissipation[:] = history[8]
