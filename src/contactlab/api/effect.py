"""Effects: anything else that pushes on nodes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import NamedTuple

from contactlab.api.arrays import Floats


class EffectView(NamedTuple):
    """What an effect may see: reference positions (N, 2) [mm], mass (N,) [t], displacement (N, 2)
    and velocity (N, 2), the last two always current."""

    reference: Floats
    mass: Floats
    displacement: Floats
    velocity: Floats


class Effect(ABC):
    """Gravity, springs, follower pressure ... Subclasses are frozen dataclasses."""

    @abstractmethod
    def bind(self, view: EffectView) -> Callable[[float, Floats], None]:
        """A function (time, force (N, 2)) that adds the effect's nodal forces [N]."""
