"""Springs to the ground."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import Effect, EffectView, Floats


@dataclass(frozen=True)
class Spring(Effect):
    """Nodal forces -k u that together have the stiffness k, spread evenly over the nodes.

    on         "body" or "body.edge_set"
    stiffness  along x and y, of all nodes together [N/mm]
    """

    conservative: ClassVar[bool] = True

    on: str
    stiffness: tuple[float, float]

    def __post_init__(self) -> None:
        if not all(0.0 <= k < math.inf for k in self.stiffness):
            raise ValueError(f"stiffness: got {list(self.stiffness)}, allowed: numbers of at least 0 [N/mm]")

    def bind(self, view: EffectView) -> Callable[[float, Floats], None]:
        """Attach the springs, which are without force at the undeformed positions."""
        nodes, displacement = view.nodes(self.on), view.displacement
        each = np.asarray(self.stiffness) / len(nodes)

        def pull(time: float, force: Floats) -> None:
            force[nodes] -= each * displacement[nodes]

        return pull
