"""Explicit central differences with contact forces in the same step (docs/theory/explicit-scheme.md)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

from contactlab.api import ExplicitIntegrator, Motion


@dataclass(frozen=True)
class CentralDifference(ExplicitIntegrator):
    """Leapfrog with lumped mass; velocities live half a step before positions.

    forces  of contacts that name no enforcement: "consistent" or "frozen", see `forward-increment`; "auto" leaves it to
            that part. Consistent ones cost 1.3 to 1.9 times as much contact (docs/theory/contact-energy.md)
    """

    default_enforcement: ClassVar[str] = "forward-increment"
    order: ClassVar[int] = 2
    without: ClassVar[Mapping[str, str]] = {"inertia": "newton"}
    by_default: ClassVar[bool] = True

    forces: Literal["auto", "consistent", "frozen", "conjugate", "published"] = "auto"

    def enforcement(self) -> Mapping[str, Any]:
        """Multipliers by forward increments, with the forces that the scene requests."""
        own: dict[str, Any] = {"use": self.default_enforcement}
        return own if self.forces == "auto" else own | {"forces": self.forces}

    def step(self, motion: Motion, dt: float) -> None:
        """Advance from the middle of the last step to the middle of this: v_0 is half a step before v_1/2."""
        motion.kick(0.5 * (motion.last_dt + dt))
        motion.contact(ahead=dt)
        motion.drift(dt)
