"""What every effect must do."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contactlab.api import Effect, EffectView, Floats, Ints
from contactlab.testing.assertions import Check, agree, identical, require, untouched

TIMES = (0.0, 0.3, 0.7)  # s
ROUND_OFF = 1e-12  # of the largest force


@dataclass(frozen=True)
class Scenery:
    """Two bodies of six nodes each, "upper" and "lower", in some state of motion."""

    view: EffectView

    @classmethod
    def moving(cls, seed: int) -> Scenery:
        """A state of its own for each seed; shapes and masses are the same."""
        x: Floats = np.array([[i, j] for j in range(2) for i in range(3)], np.float64)
        reference: Floats = np.concatenate([x + np.array([0.0, 1.5]), x])
        rng = np.random.default_rng(seed)
        state = (rng.uniform(-0.1, 0.1, reference.shape), rng.uniform(-5.0, 5.0, reference.shape))
        mass: Floats = 1e-6 * np.arange(1.0, 1.0 + len(reference))
        return cls(EffectView(reference, mass, *state, ("upper", "lower"), _nodes))

    def forces(self, effect: Effect, times: tuple[float, ...] = TIMES) -> list[Floats]:
        """Nodal forces at the times, one after another, from one binding."""
        add, found = effect.bind(self.view), []
        for time in times:
            force = np.zeros_like(self.view.reference)
            add(time, force)
            found.append(force)
        return found


def _nodes(name: str) -> Ints:
    sides = {"bottom": [0, 1, 2], "top": [3, 4, 5], "": range(6)}
    body, _, side = name.partition(".")
    if body not in ("upper", "lower") or side not in sides:
        raise ValueError(f"on: got {name!r}, allowed: upper, lower, and .top or .bottom of them")
    return np.array([i + 6 * (body == "lower") for i in sides[side]], np.int32)


def gives_forces(effect: Effect) -> None:
    """Forces are finite, and some node feels one in some state and at some time."""
    found = [force for seed in range(3) for force in Scenery.moving(seed).forces(effect)]
    require(all(np.isfinite(force).all() for force in found), "a force is not finite")
    require(any(force.any() for force in found), "no node ever feels a force; a scene would better leave it out")


def adds_to_what_is_there(effect: Effect) -> None:
    """Other effects and loads have put their forces in before: they stay."""
    scenery = Scenery.moving(1)
    alone = scenery.forces(effect, (0.3,))[0]
    before = np.random.default_rng(2).uniform(-1.0, 1.0, alone.shape) * max(1.0, float(np.abs(alone).max()))
    together = before.copy()
    effect.bind(scenery.view)(0.3, together)
    within = ROUND_OFF * float(np.abs(before).max() + np.abs(alone).max())
    agree(together - before, alone, within, "forces added to others")


def follows_the_state(effect: Effect) -> None:
    """The view is always current: a state that changes after `bind` gives the forces of the new state."""
    begun, later = Scenery.moving(3), Scenery.moving(4)
    add = effect.bind(begun.view)
    add(0.1, np.zeros_like(begun.view.reference))
    begun.view.displacement[:], begun.view.velocity[:] = later.view.displacement, later.view.velocity
    force = np.zeros_like(begun.view.reference)
    add(0.3, force)
    expected = later.forces(effect, (0.3,))[0]
    agree(force, expected, ROUND_OFF * max(1.0, float(np.abs(expected).max())), "forces after the state has changed")


def remembers_nothing(effect: Effect) -> None:
    """Forces depend on the state and the time alone: in any order of times, to the last bit, as a restart needs."""
    forward = Scenery.moving(5).forces(effect)
    backward = Scenery.moving(5).forces(effect, TIMES[::-1])[::-1]
    for time, one, other in zip(TIMES, forward, backward, strict=True):
        identical(one, other, f"forces at {time} s, asked in another order")


def leaves_the_view_alone(effect: Effect) -> None:
    """Positions, masses and velocities are the model's own arrays."""
    view = Scenery.moving(6).view
    arrays = {"reference": view.reference, "mass": view.mass}
    with untouched(**arrays, displacement=view.displacement, velocity=view.velocity):
        Scenery(view).forces(effect)


CHECKS: tuple[Check, ...] = (
    gives_forces,
    adds_to_what_is_there,
    follows_the_state,
    remembers_nothing,
    leaves_the_view_alone,
)
"""All checks of effects."""
