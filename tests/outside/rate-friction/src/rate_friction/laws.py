"""Friction that follows the motion: Stribeck's curve, rate and state with ageing (Dieterich 1979), and stress."""

from dataclasses import dataclass

import numpy as np

from contactlab.api import FrictionBound, FrictionLaw
from contactlab.api.plugin import Part, hookimpl


@dataclass(frozen=True)
class Stribeck(FrictionLaw):
    """A coefficient that falls from `static` to `kinetic` with the rate of slip, by exp(-rate / speed).

    static   [-] coefficient at rest
    kinetic  [-] coefficient far above `speed`
    speed    [mm/s] rate at which 37 % of the fall is left
    viscous  [s/mm] what the coefficient rises by for each mm/s
    """

    static: float
    kinetic: float
    speed: float
    viscous: float = 0.0
    needs = ("slip_rate",)

    def bound(self, slip_rate):
        """Coulomb's bound with the coefficient of each multiplier."""
        rate = np.abs(slip_rate)
        falling = (self.static - self.kinetic) * np.exp(-rate / self.speed)
        return FrictionBound(self.kinetic + falling + self.viscous * rate, 0.0, 0.0)


@dataclass(frozen=True)
class RateAndState(FrictionLaw):
    """Coefficient mu + a ln(v / speed) + b ln(theta speed / length), with d(theta)/dt = 1 - v theta / length.

    Rates below a thousandth of `speed` count as this, as the logarithm needs one.

    mu      [-] coefficient of a steady slip at `speed`
    a       [-] direct effect
    b       [-] evolution effect
    length  [mm] slip over which contacts are renewed
    speed   [mm/s] rate of reference; at the start of a run contacts are as old as in a steady slip at it
    """

    mu: float
    a: float
    b: float
    length: float
    speed: float
    needs = ("slip_rate", "dt")
    memory = ("theta",)

    def start(self):
        """Age of contacts [s]."""
        return {"theta": self.length / self.speed}

    def bound(self, slip_rate, dt, theta):
        """Coulomb's bound with the coefficient of each multiplier."""
        rate = np.maximum(np.abs(slip_rate), 1e-3 * self.speed)
        direct, evolution = np.log(rate / self.speed), np.log(theta * self.speed / self.length)
        return FrictionBound(np.maximum(self.mu + self.a * direct + self.b * evolution, 0.0), 0.0, 0.0)

    def evolve(self, slip_rate, dt, theta):
        """Age after a step at this rate, exactly."""
        slid = np.abs(slip_rate) * dt / self.length
        # (1 - exp(-x)) / x, which is 1 at rest
        share = np.divide(-np.expm1(-slid), slid, out=np.ones_like(slid), where=slid > 0.0)
        return {"theta": theta * np.exp(-slid) + share * dt}


@dataclass(frozen=True)
class Bulk(FrictionLaw):
    """A share of the compression in the cells behind the contact, up to a shear that they bear.

    Neighbours share what single nodes press with: it is smooth where pressures of nodes are not.

    mu     [-] share of the compression
    shear  [MPa] largest shear
    """

    mu: float
    shear: float
    needs = ("traction",)

    def bound(self, traction):
        """The shear of each multiplier; `traction` is positive in tension."""
        return FrictionBound(0.0, np.minimum(self.mu * np.maximum(-traction, 0.0), self.shear), np.inf)


@hookimpl
def contactlab_parts() -> list[Part]:
    """Three friction laws."""
    return [
        Part("friction", "stribeck", f"{__name__}:Stribeck", "falls with the rate of slip"),
        Part("friction", "rate-and-state", f"{__name__}:RateAndState", "logarithms of rate and age of contacts"),
        Part("friction", "bulk", f"{__name__}:Bulk", "a share of the stress behind the contact"),
    ]
