"""Times of a run: given in the scene, or found so that an explicit run is quasi-static."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from contactlab.api import Floats, Integrator, RunWarning
from contactlab.errors import SceneError
from contactlab.model.bodies.body import Body, Joints
from contactlab.model.history import History
from contactlab.model.loading.declared import NEARLY, beyond, last_of
from contactlab.model.loading.ramps import RampTime
from contactlab.model.loading.supports import SupportPlan
from contactlab.scene.scene import Scene


class Pace(NamedTuple):
    """Loading pace of a quasi-static run, by the frequency w1 of the lowest mode that the loading excites.

    periods     of that mode in a ramp
    damping     alpha / w1
    relaxation  times 1/w1: vibrations at w1 and above are damped, slower motion is not; 0: all is damped
    """

    periods: float
    damping: float
    relaxation: float


THE_WAY = Pace(100.0, 0.2, 3.0)  # every state on the path in equilibrium
LONGEST_HOLD = 50.0  # periods: contact that closes late needs its time at any ramp speed
LITTLE = 0.01  # of an initial motion
A_PERIOD = 2  # implicit steps of the lowest mode's period in a run until it settles: with one, vibrations do not fade
THE_END = Pace(6.0, 1.0, 0.0)  # any path: half of critical damping of w1 at the end


@dataclass(frozen=True)
class Timing:
    """Times of a run [s] and its mass-proportional damping [1/s].

    end      fixed end, None if the run ends when it has settled
    ramp     duration of ramps that name none
    last     end of all declarations in time: the fixed end, or the begin of the dwell
    because  the key that `last` follows from; "" if the program chose it
    hold     longest dwell after `last` (only without a fixed end)
    period   period of the lowest mode, over which settling is judged
    relaxation
             time constant with which the drift, exempt from damping, follows velocities; 0: damping acts on all motion
    until_settled
             False if the scene fixes the dwell: the run then takes all of it
    follows  True if states on the loading path are meant to be in equilibrium
    ramps    for ramps that name no duration; a path in equilibrium begins and ends without a jolt
    told     warnings of declarations beyond the end, or of important values left to the program
    """

    end: float | None
    ramp: float
    last: float
    because: str
    hold: float
    period: float
    damping: float
    relaxation: float
    until_settled: bool
    ramps: RampTime
    follows: bool = True
    told: tuple[RunWarning, ...] = ()

    def resolved(self) -> dict[str, float]:
        """Times chosen by `auto`, as keys of `[time]`; empty if the end is fixed."""
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
    history: History,
    joints: Callable[[], Joints],
) -> Timing:
    """Find the times of a scene: with `end = "auto"` from the lowest mode of the bodies as joints tie them.

    `THE_WAY` is the pace of a scene with a history, `THE_END` of others (docs/theory/explicit-scheme.md). No
    automatic end lies before the end of any declaration in time.
    """
    time = scene.time
    if time.end != "auto":
        end = float(time.end)
        ramps = RampTime(end, end=end) if time.ramp is None else RampTime(time.ramp)
        cut = tuple(beyond(scene, ramps, end))
        damping = time.damping or 0.0
        return Timing(end, ramps.duration, end, "time.end", 0.0, end, damping, 0.0, False, ramps, told=cut)
    if not integrator.inertia:
        ramps = RampTime(1.0 if time.ramp is None else time.ramp)
        end, because = _latest(scene, ramps)
        end += time.hold or 0.0
        told = tuple(_rated(bodies, end, because))
        return Timing(end, ramps.duration, end, because, 0.0, end, 0.0, 0.0, False, ramps, told=told)
    from contactlab.model.bodies.frequency import lowest_frequency

    # unit vectors along which supports move; both axes if none does
    directions = np.eye(2)[[c for c in range(2) if supports.moving[c]] or [0, 1]]
    frequency = lowest_frequency(bodies, positions, mass, supports.dof, directions, joints())
    if not math.isfinite(frequency):
        raise SceneError(
            "nothing can move: every degree of freedom is supported",
            where=scene.where("time.end"),
            got=scene.time.end,
            allowed="a number of seconds if no body can vibrate",
        )
    pace = THE_WAY if history else THE_END
    period = 2.0 * math.pi / frequency
    ramp = pace.periods * period if time.ramp is None else time.ramp
    ramps = RampTime(ramp, bool(history))
    last, because = _latest(scene, ramps)
    hold = max(ramp, LONGEST_HOLD * period) if time.hold is None else time.hold
    damping = pace.damping * frequency if time.damping is None else time.damping
    relaxation = pace.relaxation / frequency if time.relaxation is None else time.relaxation
    settles = time.hold is None
    told = (*_rated(bodies, last, because), *_thrown(scene, damping, last))
    return Timing(
        None, ramp, last, because, hold, period, damping, relaxation, settles, ramps, bool(history), told
    )  # fmt: skip


def _latest(scene: Scene, ramps: RampTime) -> tuple[float, str]:
    """Return the ramp time, or the later end of the scene's declarations, and its key."""
    last, key = last_of(scene, ramps)
    if last > (1.0 + NEARLY) * ramps.duration:
        return last, key
    return ramps.duration, "" if scene.time.ramp is None else "time.ramp"


def _rated(bodies: tuple[Body, ...], last: float, because: str) -> Iterator[RunWarning]:
    """Yield warnings of laws that depend on rate in a run without a given time."""
    for body in bodies:
        if body.material.rate_dependent and not because:
            yield RunWarning(
                "chosen-time", last, 0.0, "time.end",
                f"the law of body {body.name} depends on rate, and the scene does not say how long the run takes: its "
                f"stresses are for the {last:.3g} s that the program chose; write time.end in seconds",
            )  # fmt: skip


def _thrown(scene: Scene, damping: float, last: float) -> Iterator[RunWarning]:
    """Yield warnings of bodies whose initial motion is damped in a quasi-static run."""
    for name, spec in scene.bodies.items():
        key = "velocity" if any(spec.velocity) else "spin"
        if np.any(getattr(spec, key)) and damping * last > LITTLE:
            yield RunWarning(
                "damped-velocity", damping * last, LITTLE, f"bodies.{name}.{key}",
                f'bodies.{name}.{key}: a run with end = "auto" is quasi-static, and its damping ({damping:.3g} 1/s for '
                f"{last:.3g} s) takes the initial motion away; write time.end in seconds, or time.damping = 0",
            )  # fmt: skip
