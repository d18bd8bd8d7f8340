"""Damping that leaves rigid motion alone."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import Effect, EffectView, Floats


@dataclass(frozen=True)
class VibrationDamping(Effect):
    """Forces -rate m (v - v_rigid) on every body, v_rigid its rigid motion of the same momenta.

    They take neither linear nor angular momentum, so that a body falls, slides and turns freely while its
    vibrations die out as exp(-rate t / 2). A mode of circular frequency w is critically damped by rate = 2 w.

    rate   [1/s]; above a third of the inverse stable step of the bodies it makes explicit steps shorter
    on     bodies that are damped; empty: all
    until  end of the damping [s]
    """

    dissipates: ClassVar[bool] = True
    internal: ClassVar[bool] = True

    rate: float
    on: tuple[str, ...] = ()
    until: float = math.inf

    def __post_init__(self) -> None:
        if not 0.0 < self.rate < math.inf:
            raise ValueError(f"rate: got {self.rate}, allowed: a rate > 0 [1/s]")
        if not self.until > 0.0:
            raise ValueError(f"until: got {self.until}, allowed: a time > 0 [s], after the run has begun")

    def times(self) -> tuple[float, ...]:
        """The end of the damping, if it has one."""
        return (self.until,) if self.until < math.inf else ()

    def bind(self, view: EffectView) -> Callable[[float, Floats], None]:
        """Bodies keep the momenta that they have, each for itself."""
        from contactlab_effects.kernels import damp_vibration

        if not len(view.mass):
            raise ValueError("nothing vibrates in statics: take the damping out, or use an integrator with inertia")
        ranges = [view.nodes(name) for name in self.on or view.bodies]
        first = np.array([nodes[0] for nodes in ranges])
        last = np.array([nodes[-1] + 1 for nodes in ranges])

        def damp(time: float, force: Floats) -> None:
            if time <= self.until:
                damp_vibration(
                    first, last, view.reference, view.displacement, view.mass, view.velocity, self.rate, force
                )

        return damp
