"""A pressure that is half the stress behind it and half a spring, as array method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import Floats, NormalLaw


@dataclass(frozen=True)
class HalfTraction(NormalLaw):
    """p = [-sigma/2 - k g]_+: where surfaces press evenly, sigma = -p, and the gap is -p/2k.

    factor  k over the stiffness of the cells behind the slave [-]
    """

    needs: ClassVar[tuple[str, ...]] = ("traction",)
    factor: float = 10.0

    def __post_init__(self) -> None:
        if not 0.0 < self.factor < float("inf"):
            raise ValueError(f"factor: got {self.factor}, allowed: above 0, and finite")

    def pressure(
        self,
        gap: Floats,
        stiffness: Floats,
        size: Floats,
        pressure: Floats,
        slope: Floats,
        traction: Floats | None = None,
        by_traction: Floats | None = None,
    ) -> None:
        """Fill pressures and their derivatives; the core gives the last two because they are needed."""
        assert traction is not None
        assert by_traction is not None
        wish = -0.5 * traction - self.factor * stiffness * gap
        pressure[:] = np.maximum(wish, 0.0)
        slope[:] = np.where(wish > 0.0, -self.factor * stiffness, 0.0)
        by_traction[:] = np.where(wish > 0.0, -0.5, 0.0)
