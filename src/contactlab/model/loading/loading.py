"""What acts on a model from outside: loads, effects, and the supports that hold it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from contactlab.api import Floats
from contactlab.model.loading.effect_rates import NO_EFFECTS, EffectRates
from contactlab.model.loading.supports import SupportedSet


@dataclass(frozen=True)
class Loading:
    """Loads, effects and supports of one model.

    supports  one per edge set or rigid surface that is held, in the order of the scene
    loads     calls (time, out) that add the forces [N] of a load or an effect to `out` (N, 2)
    effects   those of them that belong to effects
    rates     of the effects, which explicit steps have to follow
    """

    supports: tuple[SupportedSet, ...]
    loads: tuple[Callable[[float, Floats], None], ...]
    effects: tuple[Callable[[float, Floats], None], ...]
    rates: EffectRates = NO_EFFECTS

    @property
    def accepted(self) -> tuple[Callable[[float, float], None], ...]:
        """What to call with the end and the length [s] of each accepted step: effects that remember."""
        return tuple(effect.accept for effect in self.effects if hasattr(effect, "accept"))

    def external_force(self, time: float, out: Floats) -> bool:
        """Fill `out` (N, 2) with the forces [N] of all loads at `time` [s]; False where the scene has none."""
        if not self.loads:
            return False
        out[:] = 0.0
        for load in self.loads:
            load(time, out)
        return True

    def reactions(self, forces: Floats) -> dict[str, Floats]:
        """Sums (2,) [N] of nodal reactions `forces` (N, 2) by support; one that several hold counts for the first."""
        return {support.on: support.force(forces) for support in self.supports}
