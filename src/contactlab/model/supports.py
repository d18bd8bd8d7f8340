"""Prescribed motion: supports, their ramps, and the degrees of freedom they hold."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from contactlab.api import Floats, Ints
from contactlab.errors import SceneError, below
from contactlab.model.body import Body
from contactlab.model.edge_sets import edge_set

Ramp = Callable[[float], float]


def parabola(duration: float) -> Ramp:
    """d(t) = 1 - (1 - t/T)^2: starts at speed 2/T and ends with none (Baillet & Sassi 2005, 5.1)."""

    def value(time: float) -> float:
        rest = 1.0 - min(time, duration) / duration
        return 1.0 - rest * rest

    return value


def linear(duration: float) -> Ramp:
    """d(t) = t/T, then constant."""
    return lambda time: min(time, duration) / duration


def constant(duration: float) -> Ramp:
    """The full value from the start."""
    return lambda time: 1.0


RAMPS: dict[str, Callable[[float], Ramp]] = {"parabola": parabola, "linear": linear, "constant": constant}


@dataclass(frozen=True)
class SupportedSet:
    """The nodes of one support, for reactions: `on` as written in the scene."""

    on: str
    nodes: Ints


class Prescribed:
    """Implements `contactlab.api.PrescribedMotion`: displacement = scale * ramp value."""

    def __init__(self, dof: Ints, scale: Floats, ramp: Ints, ramps: tuple[Ramp, ...]) -> None:
        self.dof, self.scale, self.ramp, self.ramps = dof, scale, ramp, ramps
        self._values = np.zeros(max(1, len(ramps)))

    def values(self, time: float) -> Floats:
        """Ramp values at `time` [s]; the same array every call."""
        for i, ramp in enumerate(self.ramps):
            self._values[i] = ramp(time)
        return self._values


@dataclass(frozen=True)
class SupportPlan:
    """All supports of a scene before the pace of the run is known.

    dof, scale, ramp  as in `contactlab.api.PrescribedMotion`
    motions           shape and duration [s] of each ramp; None: the run's ramp time
    """

    dof: Ints
    scale: Floats
    ramp: Ints
    motions: tuple[tuple[str, float | None], ...]
    sets: tuple[SupportedSet, ...]

    def bind(self, ramp_time: float) -> Prescribed:
        """The prescribed motion when ramps that name no duration take `ramp_time` [s]."""
        ramps = tuple(RAMPS[shape](ramp_time if duration is None else duration) for shape, duration in self.motions)
        return Prescribed(self.dof, self.scale, self.ramp, ramps)


def plan_supports(scene: Any, bodies: tuple[Body, ...]) -> SupportPlan:
    """Which degrees of freedom the scene prescribes; SceneError where two supports disagree."""
    held: dict[int, tuple[float, int]] = {}
    motions: list[tuple[str, float | None]] = []
    sets = []
    for number, spec in enumerate(scene.supports):
        where = scene.where(f"supports.{number}")
        nodes = _support_nodes(bodies, spec.on, below(where, "on"))
        sets.append(SupportedSet(spec.on, nodes))
        for component, motion in enumerate((spec.ux, spec.uy)):
            if motion is None:
                continue
            to = motion if isinstance(motion, int | float) else motion.to
            motions.append(("constant", 1.0) if motion is to else (motion.ramp, motion.duration))
            for dof in 2 * nodes + component:
                _hold(held, int(dof), to, len(motions) - 1, below(where, ("ux", "uy")[component]))
    order = sorted(held)
    return SupportPlan(
        np.array(order, np.int32),
        np.array([held[dof][0] for dof in order], np.float64),
        np.array([held[dof][1] for dof in order], np.int32),
        tuple(motions),
        tuple(sets),
    )


def _hold(held: dict[int, tuple[float, int]], dof: int, to: float, ramp: int, where: Any) -> None:
    if dof in held and held[dof][0] != to:
        raise SceneError(
            f"node {dof // 2} is given two different displacements in {'xy'[dof % 2]}",
            where=where,
            got=f"{to:g} after {held[dof][0]:g}",
            hint="let supports overlap only where they agree",
        )
    held.setdefault(dof, (to, ramp))


def _support_nodes(bodies: tuple[Body, ...], on: str, where: Any) -> Ints:
    for body in bodies:
        if body.name == on:
            return np.arange(body.first, body.first + body.count, dtype=np.int32)
    _, edges = edge_set(bodies, on, where)
    return np.unique(edges)
