"""How long a run takes: given in the scene, or found so that an explicit run is quasi-static."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from contactlab.api import Floats, Integrator
from contactlab.errors import SceneError
from contactlab.model.bodies.body import Body
from contactlab.model.loading.supports import SupportPlan

if TYPE_CHECKING:
    from contactlab.scene.scene import Scene

PERIODS = 50.0  # ramp in periods of the lowest mode that the loading excites
DAMPING = 0.2  # alpha / w1
RELAXATION = 3.0  # times 1/w1: vibrations at w1 and above are damped, what lasts longer is left alone


@dataclass(frozen=True)
class Timing:
    """Times of a run [s] and its mass-proportional damping [1/s].

    end      fixed end, None where the run ends when it has settled
    ramp     duration of ramps that name none
    hold     longest time after the ramp (only without a fixed end)
    period   period of the lowest mode, over which settling is judged
    relaxation
             time in which the drift, which damping leaves alone, follows velocities; 0: damping acts on all motion
    until_settled
             False where the scene fixes the hold: the run then takes all of it
    """

    end: float | None
    ramp: float
    hold: float
    period: float
    damping: float
    relaxation: float
    until_settled: bool

    def resolved(self) -> dict[str, float]:
        """What `auto` chose, as keys of `[time]`; empty where the scene fixed the end."""
        if self.end is not None:
            return {}
        return {
            "ramp": self.ramp,
            "hold": self.hold,
            "damping": self.damping,
            "relaxation": self.relaxation,
            "period": self.period,
        }


def find_timing(
    scene: Scene,
    bodies: tuple[Body, ...],
    positions: Floats,
    mass: Floats,
    supports: SupportPlan,
    integrator: Integrator,
) -> Timing:
    """Find the times of a scene: for `end = "auto"` a ramp of 50 periods of the lowest mode w1, and damping 0.2 w1."""
    time = scene.time
    if time.end != "auto":
        end = float(time.end)
        ramp = end if time.ramp is None else time.ramp
        return Timing(end, ramp, 0.0, end, time.damping or 0.0, 0.0, False)
    if not integrator.inertia:
        return Timing(1.0, 1.0, 0.0, 1.0, 0.0, 0.0, False)
    from contactlab.model.bodies.frequency import loaded_frequency

    directions = _directions(supports)
    frequency = min(loaded_frequency(body, positions, mass, supports.dof, directions) for body in bodies)
    if not math.isfinite(frequency):
        raise SceneError(
            "nothing can move: every degree of freedom is supported",
            where=scene.where("time.end"),
            got=scene.time.end,
            allowed="a number of seconds where no body can swing",
        )
    period = 2.0 * math.pi / frequency
    ramp = PERIODS * period if time.ramp is None else time.ramp
    hold = ramp if time.hold is None else time.hold
    damping = DAMPING * frequency if time.damping is None else time.damping
    relaxation = RELAXATION / frequency if time.relaxation is None else time.relaxation
    return Timing(None, ramp, hold, period, damping, relaxation, time.hold is None)


def _directions(supports: SupportPlan) -> Floats:
    """Unit vectors (d, 2) along which supports move; both axes where none does."""
    return np.eye(2)[[c for c in range(2) if supports.moving[c]] or [0, 1]]
