"""Gravity."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import Effect, EffectView, Floats, Profile


@dataclass(frozen=True)
class Gravity(Effect):
    """Weight m g of every node.

    acceleration  along x and y [mm/s2]; on earth [0, -9810] in mm and s
    on            bodies that have weight; empty: all
    ramp          time in which it rises from nothing, without a jolt [s]; 0: there from the start
    profile       how the acceleration varies over the bodies; not written: it is uniform
    """

    needs_mass: ClassVar[bool] = True
    conservative: ClassVar[bool] = True
    vectors: ClassVar[tuple[str, ...]] = ("acceleration",)

    acceleration: tuple[float, float]
    on: tuple[str, ...] = ()
    ramp: float = 0.0
    profile: Profile | None = None

    def __post_init__(self) -> None:
        if not 0.0 <= self.ramp < math.inf:
            raise ValueError(f"ramp: got {self.ramp}, allowed: a time of at least 0 [s]")

    def times(self) -> tuple[float, ...]:
        """The end of the ramp."""
        return (self.ramp,) if self.ramp else ()

    def bind(self, view: EffectView) -> Callable[[float, Floats], None]:
        """Compute the weights once; a step adds them."""
        nodes = np.concatenate([view.nodes(name) for name in self.on or view.bodies])
        # of all nodes, even without weight: picking some out costs twenty times the sum
        weight = np.zeros((len(view.mass), 2))
        weight[nodes] = view.mass[nodes, None] * np.asarray(self.acceleration)
        if self.profile is not None:
            weight[nodes] *= view.factors(self.profile, nodes)[:, None]

        def pull(time: float, force: Floats) -> None:
            force += weight if time >= self.ramp else _smooth(time / self.ramp) * weight

        return pull


def _smooth(s: float) -> float:
    """3 s^2 - 2 s^3: no slope at either end."""
    return s * s * (3.0 - 2.0 * s)
