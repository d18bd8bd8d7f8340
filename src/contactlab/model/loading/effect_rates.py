"""Rates of effects that limit explicit steps in addition to the bodies: stiffness and damping, by differences.

An effect is an unknown function of positions and velocities. Small motions of all nodes show
the largest eigenvalues of its stiffness and of its damping over the masses (power iteration, in the masses' norm).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from contactlab.api import Floats, State

ITERATIONS = 12  # the norm grows towards the largest eigenvalue: 1 % below it if its neighbours are a third lower
SMALL = 1e-6  # of the model's size: central differences of smooth forces then err by 1e-10 or so
MARGIN = 1.05  # on the share of effects: eigenvalues are found from below
WIDE, JUMP = 10.0, 3.0  # a jump of forces looks a tenth as stiff in a motion ten times as wide, a spring just as stiff
NOISE = 1e-9  # of the bodies' rates: round-off of differences of constant forces


@dataclass(frozen=True)
class EffectRates:
    """Largest eigenvalues of all effects, summed.

    square   of M^-1 K [1/s2], for both signs of K
    damping  of M^-1 C [1/s]
    """

    square: float = 0.0
    damping: float = 0.0

    def limit(self, bodies: float) -> float:
        """Return the largest stable step [s] with effects, `bodies` [s] without.

        Velocities of effects lag half a step. A mode with (w, c) in steps of central differences,
        z^2 - (2 - w^2 dt^2 - c dt) z + 1 - c dt = 0, is stable while w^2 dt^2 / 4 + c dt / 2 <= 1 (z = -1).
        """
        a, b = bodies**-2 + MARGIN * self.square / 4.0, MARGIN * self.damping / 2.0
        return float(2.0 / (b + np.sqrt(b * b + 4.0 * a)))


NO_EFFECTS = EffectRates()


def effect_rates(
    effects: Sequence[Callable[[float, Floats], None]],
    state: State,
    mass: Floats,
    size: float,
    bodies: float,
    times: Iterable[float],
) -> EffectRates:
    """Return rates of the effects at the present state, the largest at the given `times` [s].

    mass (N,) [t], size of the model [mm], stable step of the bodies [s]
    """
    square = damping = 0.0
    own = 4.0 / bodies**2
    for effect in effects:
        probe = _Probe(effect, mass)
        square += _kept(max(probe.largest(time, state["displacement"], SMALL * size) for time in times), own)
        damping += _kept(max(probe.largest(time, state["velocity"], SMALL * size / bodies) for time in times), own**0.5)
    return EffectRates(square, damping)


def _kept(found: float, of_bodies: float) -> float:
    """Return a rate, or 0 if it is round-off; the run reports a force that is not finite."""
    return found if np.isfinite(found) and found > NOISE * of_bodies else 0.0


class _Probe:
    """Changes of one effect's forces over the masses; nodes of rigid surfaces have none and do not move."""

    def __init__(self, effect: Callable[[float, Floats], None], mass: Floats) -> None:
        self.effect, self.mass = effect, mass[:, None]
        self.moving = self.mass > 0.0
        self.start = np.where(self.moving, np.random.default_rng(1).choice([-1.0, 1.0], size=(len(mass), 2)), 0.0)

    def largest(self, time: float, field: Floats, step: float) -> float:
        """Return the largest eigenvalue of -M^-1 dF/d(field) by modulus; 0 if forces jump without derivative."""
        motion, found = self.start, 0.0
        for _ in range(ITERATIONS):
            change = self._change(time, field, step, motion)
            length = self._norm(change)
            if not 0.0 < length < np.inf:
                return 0.0
            last, found = motion, length / self._norm(motion)
            motion = change / np.abs(change).max()  # entries of about one: steps have their chosen size
        wide = self._norm(self._change(time, field, WIDE * step, last)) / self._norm(last)
        return found if found < JUMP * wide else 0.0

    def _change(self, time: float, field: Floats, step: float, motion: Floats) -> Floats:
        """Return the change of the forces over the masses (N, 2) per unit of a motion (N, 2)."""
        before, change = field.copy(), np.zeros_like(field)
        try:
            for side in (1.0, -1.0):
                forces = np.zeros_like(before)
                field[:] = before + side * step * motion
                self.effect(time, forces)
                change += side * forces
        finally:
            field[:] = before
        return np.divide(change / (2.0 * step), self.mass, out=np.zeros_like(change), where=self.moving)

    def _norm(self, motion: Floats) -> float:
        return float(np.sqrt(np.sum(self.mass * motion**2)))
