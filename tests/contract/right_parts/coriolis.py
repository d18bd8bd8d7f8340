# kind effect cls Coriolis
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import Effect


@dataclass(frozen=True)
class Coriolis(Effect):
    """2 m w v turned by -90 degrees: of a frame that turns by w.

    speed  w [1/s]
    """

    speed: float = 100.0
    needs_mass: ClassVar[bool] = True

    def bind(self, view):
        factor = 2.0 * self.speed * view.mass[:, None]

        def add(time, force):
            v = view.velocity
            force += factor * np.stack([v[:, 1], -v[:, 0]], axis=1)

        return add
