"""Parts with memory: a layer that is crushed, a layer that wears, and Maxwell's damper."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import Effect, NormalLaw, formula
from contactlab.api.plugin import Part, hookimpl


@dataclass(frozen=True)
class CrushedLayer(NormalLaw):
    """An elastic layer that is crushed from a pressure on, which grows with what is crushed of it.

    stiffness  [MPa/mm] of the layer
    limit      [MPa] pressure from which on it is crushed
    hardening  [MPa/mm] growth of this pressure with what is crushed
    """

    stiffness: float
    limit: float
    hardening: float = 0.0
    memory: ClassVar[tuple[str, ...]] = ("crushed",)

    @formula
    def pressure(gap, crushed, p):
        """The elastic pressure, or the one that crushes more of the layer; `crushed` [mm] is missing of it."""
        elastic = -p.stiffness * (gap + crushed)
        crushing = p.stiffness * (p.limit - p.hardening * gap) / (p.stiffness + p.hardening)
        return max(0.0, min(elastic, crushing))

    @formula
    def evolve(gap, pressure, crushed, p):
        """The overlap without its elastic part."""
        return max(crushed, -gap - pressure / p.stiffness)


@dataclass(frozen=True)
class WornLayer(NormalLaw):
    """An elastic layer of which pressure times slip takes away (Archard 1953).

    stiffness  [MPa/mm] of the layer
    wear       [1/MPa] thickness that is lost, over pressure and slip
    """

    stiffness: float
    wear: float
    needs: ClassVar[tuple[str, ...]] = ("slip_rate", "dt")
    memory: ClassVar[tuple[str, ...]] = ("worn",)

    @formula
    def pressure(gap, worn, p):
        """Proportional to the overlap of what is left; `worn` [mm] is missing."""
        return max(0.0, -p.stiffness * (gap + worn))

    @formula
    def evolve(pressure, slip_rate, dt, worn, p):
        """Archard's law, over a step."""
        return worn + p.wear * pressure * abs(slip_rate) * dt


@dataclass(frozen=True)
class Maxwell(Effect):
    """A spring and a dashpot in series between nodes and the ground, in both directions.

    stiffness   [N/mm] of the springs of all nodes together
    relaxation  [s] time in which the force of a held node falls to 37 %
    on          bodies or edge sets
    """

    stiffness: float
    relaxation: float
    on: tuple[str, ...]
    memory: ClassVar[tuple[str, ...]] = ("x", "y")

    def bind(self, view):
        """Forces of the springs; the ends of dashpots, x and y [mm], follow by implicit Euler steps."""
        nodes, share = view.shares(self.on)
        springs = self.stiffness * share[:, None]

        def add(time, force, dt, memory):
            end = np.stack([memory["x"], memory["y"]], axis=1)
            end[nodes] += (view.displacement[nodes] - end[nodes]) * (dt / (dt + self.relaxation))
            force[nodes] -= springs * (view.displacement[nodes] - end[nodes])
            return dict(zip("xy", end.T, strict=True))

        return add


@hookimpl
def contactlab_parts() -> list[Part]:
    """Two pressure laws and an effect."""
    return [
        Part("enforcement", "crushed-layer", f"{__name__}:CrushedLayer", "elastic until it is crushed"),
        Part("enforcement", "worn-layer", f"{__name__}:WornLayer", "loses thickness by pressure and slip"),
        Part("effect", "maxwell", f"{__name__}:Maxwell", "springs and dashpots in series to the ground"),
    ]
