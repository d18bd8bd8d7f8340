"""Watches: numbers of every step, kept as a table."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from contactlab.api import Floats, Memory, Record, StepView, Watch

# --- what can be requested: the name of a quantity, and what it is of ------------------------------


def mean(view: StepView, field: Floats, body: str) -> Floats:
    """Mean by mass (2,) of a nodal field (N, 2) over a body."""
    own = view.nodes(body)
    mass = view.mass[own]
    return np.asarray(mass @ field[own] / mass.sum())


def tilt(view: StepView, body: str) -> float:
    """Angle [rad] by which a body is turned: of the rotation nearest to its deformation."""
    own = view.nodes(body)
    mass = view.mass[own][:, None]
    before, now = (x[own] - mean(view, x, body) for x in (view.reference, view.position))
    covariance = (mass * now).T @ before
    return float(np.arctan2(covariance[1, 0] - covariance[0, 1], covariance[0, 0] + covariance[1, 1]))


def _momentum(view: StepView, axis: int) -> float:
    return float(view.mass @ view.field("velocity")[:, axis])


def _angular(view: StepView) -> float:
    """Angular momentum about the origin, with positions half a step after velocities, which leapfrog keeps."""
    r, v = view.position, view.field("velocity")
    return float(view.mass @ (r[:, 0] * v[:, 1] - r[:, 1] * v[:, 0]))


_PLAIN: dict[str, Callable[[StepView], float]] = {
    "time": lambda view: view.time,
    "sweeps": lambda view: float(view.sweeps),
    "momentum.x": lambda view: _momentum(view, 0),
    "momentum.y": lambda view: _momentum(view, 1),
    "angular-momentum": _angular,
    "kinetic": lambda view: view.kinetic_energy(),
    "stored": lambda view: view.stored_energy(),
    "energy": lambda view: view.kinetic_energy() + view.stored_energy(),
    "work.internal": lambda view: float(view.field("work")[0]),
    "work.contact": lambda view: float(view.field("work")[3]),
    "push": lambda view: float(view.normal_forces().sum()),
    "pull": lambda view: float(-view.normal_forces().min()),
}
_AXES = {"x": 0, "y": 1}


@cache
def quantity(name: str) -> Callable[[StepView], float]:
    """Return the function of a step for a plain name, `WHAT.BODY.AXIS` for a mean over a body (velocity,
    displacement, position), `force.BODY.AXIS` for the contact force on it, `tilt.BODY`. Raises ValueError."""
    if name in _PLAIN:
        return _PLAIN[name]
    what, _, rest = name.partition(".")
    if what == "tilt":
        return lambda view: tilt(view, rest)
    body, _, axis = rest.rpartition(".")
    if axis not in _AXES or what not in ("force", "velocity", "displacement", "position"):
        raise ValueError(f"quantities: got {name}, allowed: {', '.join(_PLAIN)}, tilt.BODY, force.BODY.x ...")
    k = _AXES[axis]
    if what == "force":
        return lambda view: float(view.field("contact_force")[view.nodes(body), k].sum())
    return lambda view: float(mean(view, view.position if what == "position" else view.field(what), body)[k])


@dataclass(frozen=True)
class Series(Watch):
    """Quantities of every step from `begin` to `end` [s], one row each.

    quantities  names, see `quantity`
    every       steps between rows
    most        rows there is room for; what comes later is left out, and `table` raises
    """

    quantities: tuple[str, ...]
    begin_time: float = -math.inf
    end_time: float = math.inf
    every: int = 1
    most: int = 20000

    def __post_init__(self) -> None:
        for name in self.quantities:
            quantity(name)

    def begin(self, view: StepView) -> Memory:
        """An empty table; bodies that do not exist are found here."""
        for name in self.quantities:
            quantity(name)(view)
        return {"count": np.zeros(1), "rows": np.zeros((self.most, len(self.quantities)))}

    def step(self, view: StepView, memory: Memory) -> None:
        """Append one row: the quantities after the step, if it is one that is kept."""
        if view.step % self.every or not self.begin_time - 0.5 * view.dt <= view.time <= self.end_time + 0.5 * view.dt:
            return
        count = int(memory["count"][0])
        if count < self.most:
            memory["rows"][count] = [quantity(name)(view) for name in self.quantities]
        memory["count"][0] = count + 1

    def end(self, memory: Mapping[str, Floats]) -> Mapping[str, Floats]:
        """Return the rows that were kept, by quantity."""
        count = int(memory["count"][0])
        rows = memory["rows"][: min(count, self.most)]
        found = {name: rows[:, k] for k, name in enumerate(self.quantities)}
        return {**found, "left out": np.array([max(0.0, count - self.most)])}


def series(*quantities: str, **fields: Any) -> dict[str, Any]:
    """Write a series as a job names it."""
    return {"use": "series", "quantities": list(quantities), **fields}


def table(record: Record, name: str = "series") -> Mapping[str, Floats]:
    """Return the rows of a series. Raises LookupError if it did not have room for all."""
    found = record.watched[name]
    if found["left out"][0]:
        raise LookupError(f"{found['left out'][0]:.0f} rows of the series {name} do not fit: increase `most`")
    return found


@dataclass(frozen=True)
class LeapfrogEnergy(Watch):
    """The energy that leapfrog keeps if nothing touches: H = v M v/2 + u_n K u_(n+1)/2 - w (u_n + u_(n+1))/2.

    Linear elastic bodies under a constant weight w; with it the contact force on `body` along the bars.
    """

    body: str
    most: int = 40000

    def begin(self, view: StepView) -> Memory:
        """Keep the weight, and what the last step left."""
        return {
            "count": np.zeros(1), "rows": np.zeros((self.most, 3)), "weight": view.external_force(),
            "force": view.field("internal_force"), "moved": view.field("displacement"),
        }  # fmt: skip

    def step(self, view: StepView, memory: Memory) -> None:
        """Append time, force and energy of the step."""
        now, force = view.field("displacement"), view.field("contact_force")[view.nodes(self.body)].sum(axis=0)
        stored = 0.5 * float((memory["force"] * now).sum() - (memory["weight"] * (now + memory["moved"])).sum())
        count = int(memory["count"][0])
        memory["rows"][count] = view.time, force[np.abs(force).argmax()], view.kinetic_energy() + stored
        memory["count"][0] = count + 1
        memory["force"][:], memory["moved"][:] = view.field("internal_force"), now

    def end(self, memory: Mapping[str, Floats]) -> Mapping[str, Floats]:
        """Return the kept rows as columns by name."""
        rows = memory["rows"][: int(memory["count"][0])]
        return {"time": rows[:, 0], "force": rows[:, 1], "energy": rows[:, 2], "left out": np.zeros(1)}
