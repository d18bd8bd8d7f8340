# kind mesh cls Annulus
import math
from dataclasses import dataclass

import numpy as np

from contactlab.api import MeshSource
from contactlab.api.meshing import renamed, structured


@dataclass(frozen=True)
class Annulus(MeshSource):
    """Sector of a ring. Edge sets inner, outer, first, last.

    inner, outer  radii [mm]
    first, last   angles [degree]
    centre        [mm]
    cells         along the angle and along the radius at level 1
    """

    inner: float = 2.0
    outer: float = 3.0
    first: float = -30.0
    last: float = 60.0
    centre: tuple[float, float] = (0.5, -1.0)
    cells: tuple[int, int] = (6, 2)

    def mesh(self, element, level):
        columns, rows = (level * count for count in self.cells)
        made = structured(element, (columns, rows), self.place)
        return renamed(made, {"bottom": "outer", "top": "inner", "left": "first", "right": "last"})

    def place(self, s, t):
        angle = math.radians(self.first) + s * math.radians(self.last - self.first)
        radius = self.outer + t * (self.inner - self.outer)
        return self.centre[0] + radius * np.cos(angle), self.centre[1] + radius * np.sin(angle)
