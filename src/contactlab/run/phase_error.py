"""How far motion that bodies make by themselves lags behind in implicit dynamics.

The midpoint rule makes a vibration of frequency w take longer by (w h)^2 / 12 in steps of h (Hughes 2000, The Finite
Element Method, sec. 9.1). Energy and amplitude stay right, but the lag adds up over many periods. w follows from the
mean velocity v of each step and its second difference v'':

    w^2 = -(v . M v'') / (v . M v)

Only motion counts whose kinetic energy stresses, springs or pressure laws give and take. What supports give does not:
driven motion has the lag of one period, which does not add up.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from contactlab.api import Floats, RunWarning, Step
from contactlab.model.model import Model
from contactlab.run.controlled_step import better_steps

HIGH = 0.05  # of the largest displacement: what peak pressures are held to
SPARE = 1.1  # steps more than the square of their length gives: coarse steps see a lower frequency
KINETIC, LARGEST, LAG, LENGTH, STEPS = range(5)
U, V, A = range(3)


class PhaseError:
    """Adds up how far the motion of each step is behind.

    Norms are those of the kinetic energy, |u|^2 = u . M u.

    numbers  kinetic energy at the end of the last step [mJ], largest norm of displacements so far, sum of the lags,
             length of the last step [s], and number of steps
    motion   (3, N, 2) displacements [mm] at the end of the last step, mean velocities [mm/s] in it, and accelerations
             [mm/s^2] between it and the step before
    """

    def __init__(self, model: Model) -> None:
        self.model, state = model, model.state
        self.mass: Floats = model.mass[:, None]
        self.numbers: Floats = np.zeros(5)
        self.numbers[KINETIC] = model.kinetic_energy()
        self.motion: Floats = np.array([state["displacement"], state["velocity"], np.zeros_like(state["velocity"])])

    @property
    def memory(self) -> dict[str, Floats]:
        """Arrays that change during the run, by name."""
        return {"phase_error": self.numbers, "phase_motion": self.motion}

    def follow(self, step: Step, dt: float, jumped: bool) -> None:
        """Look at the state after an accepted step of length dt [s]."""
        n, motion, u = self.numbers, self.motion, self.model.state["displacement"]
        moved, between = u - motion[U], 0.5 * (n[LENGTH] + dt)
        velocity = moved / dt
        acceleration = (velocity - motion[V]) / between
        kinetic = self.model.kinetic_energy()
        gained = kinetic - n[KINETIC]
        by_itself = gained - float(np.vdot(self.model.state["reaction"], moved))
        if n[STEPS] > 1.0 and gained * by_itself > 0.0:
            momentum = self.mass * velocity
            square = float(np.vdot(momentum, velocity))
            bend = -float(np.vdot(momentum, acceleration - motion[A])) / between
            lag = min(max(dt**2 / 12.0 * bend / max(square, 1e-300), 0.0), 1.0)
            free = min(abs(gained), abs(by_itself)) / max(abs(gained), abs(by_itself))
            n[LAG] += free * lag * dt * float(np.sqrt(square))
        n[KINETIC], n[LENGTH] = kinetic, dt
        n[LARGEST] = max(n[LARGEST], float(np.sqrt(np.vdot(self.mass * u, u))))
        n[STEPS] += 1.0
        motion[U], motion[V], motion[A] = u, velocity, acceleration

    def warnings(self, key: str, now: float) -> Iterator[RunWarning]:
        """Warn if the lag at the end is large; `key` of the scene says how many steps there are, or how long, `now`.

        In a period a vibration goes four amplitudes. Its lag (w h)^2/12 times 2 pi amplitudes is the error of the
        displacement.
        """
        share = 0.5 * np.pi * float(self.numbers[LAG]) / max(float(self.numbers[LARGEST]), 1e-300)
        if share > HIGH:
            yield RunWarning(
                "phase-error", share, HIGH, key,
                "bodies vibrate, and steps lengthen each period by (w h)^2/12: displacements at the end are off by "
                f"about {min(share, 2.0):.0%} of the largest (limit {HIGH:.0%}); "
                f"write {key} = {better_steps(key, now, SPARE * float(np.sqrt(share / HIGH)))}",
            )  # fmt: skip
