"""Helpers of the dynamic cases: rates along a series, changes of momenta, and scenes of plain bars and blocks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from contactlab.api import Floats, Memory, StepView, Watch

WORK = 60_000
"""Steps and iterations after which a dynamic case is given up: several times what any of them needs."""


def pushed(forces: str) -> dict[str, str]:
    """The enforcement of explicit runs with these forces."""
    return {"use": "forward-increment", "forces": forces}


def strip(x: tuple[float, float], y: tuple[float, float], cells: list[int], **more: Any) -> dict[str, Any]:
    """Data of a rectangular body of the material m, meshed evenly."""
    return {"material": "m", "mesh": {"use": "rectangle", "x": list(x), "y": list(y), "cells": cells}, **more}


def largest(values: Floats) -> float:
    """Largest magnitude among the values, 0 for none."""
    return float(np.abs(values).max())


def rise(energy: Floats) -> float:
    """Largest rise from one step to the next."""
    return float(np.diff(energy).max())


def energy_under_weight(found: Mapping[str, Floats], body: str, weight: float) -> Floats:
    """Energy [mJ] after every step: kinetic, of the stresses by their work, and of the weight [N], which acts along -y.

    `found` has rows of kinetic, work.internal and position.BODY.y. Velocities of leapfrog are half a step back, and so
    are both works: an energy of this kind stays to round-off if nothing gives or takes any.
    """
    y = found[f"position.{body}.y"]
    return np.asarray(found["kinetic"] + found["work.internal"] + 0.5 * weight * (y + np.append(y[:1], y[:-1])))[1:]


def momentum_change(found: Mapping[str, Floats], scale: float) -> float:
    """Largest change of the linear momentum since the first row, over `scale`."""
    return max(largest(found[f"momentum.{axis}"] - found[f"momentum.{axis}"][0]) for axis in "xy") / scale


@dataclass(frozen=True)
class ContactChanges(Watch):
    """Number of conditions that open or close in every step, with the largest pull, the push, and energies."""

    most: int = 40000

    def begin(self, view: StepView) -> Memory:
        """Start with no closed condition and no row."""
        return {"count": np.zeros(1), "rows": np.zeros((self.most, 5)), "closed": np.zeros(len(view.normal_forces()))}

    def step(self, view: StepView, memory: Memory) -> None:
        """Keep one row: changes of status, sums of forces, and energies of the step."""
        y, work = view.normal_forces(), view.field("work")
        closed = (y > 0.0).astype(float)
        changes = float(np.count_nonzero(closed != memory["closed"]))
        count = int(memory["count"][0])
        memory["rows"][count] = changes, y.sum(), -y.min(), work[3], work[0]
        memory["closed"][:], memory["count"][0] = closed, count + 1

    def end(self, memory: Mapping[str, Floats]) -> Mapping[str, Floats]:
        """Return the kept rows as columns by name."""
        rows = memory["rows"][: int(memory["count"][0])].T
        return dict(zip(("changes", "push", "pull", "work.contact", "work.internal"), rows, strict=True))


@dataclass(frozen=True)
class Slips(Watch):
    """Largest slip [mm] that any condition adds up to from `begin_time` on."""

    begin_time: float = 0.0

    def begin(self, view: StepView) -> Memory:
        """Start with no slip."""
        return {"total": np.zeros(len(view.normal_forces())), "largest": np.zeros(1)}

    def step(self, view: StepView, memory: Memory) -> None:
        """Add the slips of an accepted step to their sums."""
        if view.time > self.begin_time + 0.5 * view.dt:
            memory["total"] += view.slips()
            memory["largest"][0] = max(memory["largest"][0], largest(memory["total"]))


@dataclass(frozen=True)
class Overlap(Watch):
    """Largest area [mm2] between two surfaces, one over the other, over |x| < reach [mm]."""

    reach: float = 2.0
    points: int = 2001

    def begin(self, view: StepView) -> Memory:
        """Start with no overlap."""
        return {"largest": np.zeros(1)}

    def step(self, view: StepView, memory: Memory) -> None:
        """Find by how much the lower body stands above the upper one."""
        x = np.linspace(-self.reach, self.reach, self.points)
        sides = sorted((view.position[nodes] for nodes in (view.slave(), view.master())), key=lambda p: p[:, 1].mean())
        lower, upper = (np.interp(x, *side[np.argsort(side[:, 0])].T) for side in sides)
        area = float(np.maximum(lower - upper, 0.0).sum() * (x[1] - x[0]))
        memory["largest"][0] = max(memory["largest"][0], area)


@dataclass(frozen=True)
class Tip(Watch):
    """Displacement along x of the first node of one side, with the energy of all bodies.

    side  "slave" or "master"
    """

    most: int = 20000
    side: str = "slave"

    def __post_init__(self) -> None:
        if self.side not in ("slave", "master"):
            raise ValueError(f"side: got {self.side!r}, allowed: slave, master")

    def begin(self, view: StepView) -> Memory:
        """Start without a row."""
        return {"count": np.zeros(1), "rows": np.zeros((self.most, 3))}

    def step(self, view: StepView, memory: Memory) -> None:
        """Keep one row of the step."""
        count = int(memory["count"][0])
        energy = view.kinetic_energy() + view.stored_energy()
        node = (view.slave() if self.side == "slave" else view.master())[0]
        memory["rows"][count] = view.time, view.field("displacement")[node, 0], energy
        memory["count"][0] = count + 1

    def end(self, memory: Mapping[str, Floats]) -> Mapping[str, Floats]:
        """Return the kept rows as columns by name."""
        rows = memory["rows"][: int(memory["count"][0])].T
        return {**dict(zip(("time", "tip", "energy"), rows, strict=True)), "left out": np.zeros(1)}


@dataclass(frozen=True)
class NodalForces(Watch):
    """Contact forces [N] across the surface on every slave node, along y, one row each.

    every  steps between rows
    most   rows there is room for; later ones are left out, and `table` raises
    """

    every: int = 1
    most: int = 2000

    def begin(self, view: StepView) -> Memory:
        """Start without a row; `x` [mm] of the nodes stays what it is before the run."""
        count = len(view.slave())
        return {
            "count": np.zeros(1), "time": np.zeros(self.most), "x": np.array(view.reference[view.slave(), 0]),
            "force": np.zeros((self.most, count)),
        }  # fmt: skip

    def step(self, view: StepView, memory: Memory) -> None:
        """Keep one row of the step."""
        if view.step % self.every:
            return
        row = int(memory["count"][0])
        memory["count"][0] = row + 1
        if row < self.most:
            memory["time"][row] = view.time
            memory["force"][row] = view.field("contact_force")[view.slave(), 1]

    def end(self, memory: Mapping[str, Floats]) -> Mapping[str, Floats]:
        """Return the kept rows: time (r,), x (n,), force (r, n); and how many were left out."""
        count = int(memory["count"][0])
        found = {"x": memory["x"], "time": memory["time"][:count], "force": memory["force"][:count]}
        return {**found, "left out": np.array([max(0.0, count - self.most)])}
