"""Springs to the ground."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import Effect, EffectView, Floats, Profile


@dataclass(frozen=True)
class Spring(Effect):
    """Springs -k u that together have the stiffness k, spread evenly over the area of bodies or the length of edges.

    on         bodies or edge sets, one "body" or "body.edge_set" or a list
    stiffness  along x and y, of all springs together [N/mm]
    profile    what the share of each node is multiplied by; not written: they are even
    """

    conservative: ClassVar[bool] = True

    on: tuple[str, ...]
    stiffness: tuple[float, float]
    profile: Profile | None = None

    def __post_init__(self) -> None:
        if not all(0.0 <= k < math.inf for k in self.stiffness):
            raise ValueError(f"stiffness: got {list(self.stiffness)}, allowed: numbers of at least 0 [N/mm]")

    def bind(self, view: EffectView) -> Callable[[float, Floats], None]:
        """Attach the springs, which are without force at the undeformed positions."""
        (nodes, shares), displacement = view.shares(self.on), view.displacement
        each = np.outer(shares, self.stiffness)
        if self.profile is not None:
            each *= view.factors(self.profile, nodes)[:, None]

        def pull(time: float, force: Floats) -> None:
            force[nodes] -= each * displacement[nodes]

        return pull
