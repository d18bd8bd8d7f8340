# kind effect cls Drag
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import Effect


@dataclass(frozen=True)
class Drag(Effect):
    """-c |v| v on each node, shared by area.

    c   of all bodies together [N s2/mm2]
    on  bodies; empty: all
    """

    c: float = 1e-9
    on: tuple[str, ...] = ()
    dissipates: ClassVar[bool] = True

    def bind(self, view):
        nodes, shares = view.shares(self.on or view.bodies)

        def add(time, force):
            v = view.velocity[nodes]
            force[nodes] -= self.c * (shares * np.hypot(v[:, 0], v[:, 1]))[:, None] * v

        return add
