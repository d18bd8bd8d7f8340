"""A force between two bodies."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from contactlab.api import Effect, EffectView, Floats


@dataclass(frozen=True)
class Attraction(Effect):
    """A constant force that draws two bodies together along the line of their centres of mass.

    Each node takes its share by mass, so that neither body is turned, and the pair feels nothing from outside.

    between  two bodies
    force    [N]; below zero they are driven apart
    """

    needs_mass: ClassVar[bool] = True
    conservative: ClassVar[bool] = True
    internal: ClassVar[bool] = True

    between: tuple[str, str]
    force: float

    def __post_init__(self) -> None:
        if self.between[0] == self.between[1]:
            raise ValueError(f"between: got {list(self.between)}, allowed: two different bodies")
        if not math.isfinite(self.force):
            raise ValueError(f"force: got {self.force}, allowed: a finite force [N]")

    def bind(self, view: EffectView) -> Callable[[float, Floats], None]:
        """A function that adds the forces along the line between both centres of mass."""
        from contactlab_effects.kernels import attract

        for name in self.between:
            if name not in view.bodies:
                raise ValueError(f"between: got {name!r}, allowed: {', '.join(view.bodies)}")
        first, second = (view.nodes(name) for name in self.between)

        def pull(time: float, force: Floats) -> None:
            attract(first, second, view.reference, view.displacement, view.mass, self.force, force)

        return pull
