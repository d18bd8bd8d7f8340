"""Derivatives of loads by node positions, for implicit integrators: follower loads exactly, effects by differences.

An effect is an unknown function of positions and velocities. Forces on a node mostly depend on
this node (springs, dampers, fields in space), so that moving all nodes together, each up or down by chance, shows its
2x2 block. The result is tested on another motion, and left out if it does not explain the forces there: an effect
that couples distant nodes then converges linearly, as it would without.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from contactlab.api import Floats, Ints
from contactlab.model.loading.loads import FollowerLoad
from contactlab.model.model import Model

STEP = 1e-6  # of the model's size: central differences of smooth forces then err by 1e-10 or so
TRUSTED = 0.1  # relative error of the forces' change in another motion, up to which differences are used


class LoadStiffness:
    """Loads of a run, bound to the pattern of the stiffness."""

    def __init__(self, model: Model, place: Callable[[Ints, Ints], Ints]) -> None:
        self.followers = [
            (load, _Entries(load, place)) for load in model.loading.loads if isinstance(load, FollowerLoad)
        ]
        self.nodes = [OwnNodes(effect, model, place) for effect in model.loading.effects]

    def add(self, time: float, share: float, rate: float, data: Floats) -> None:
        """Add `share` of minus the derivative of all loads at `time` to the stiffness's data.

        rate  change of velocities [1/s] with displacements; 0 in statics
        """
        for load, entries in self.followers:
            entries.add(share, *load.values(time), data)
        for effect in self.nodes:
            effect.add(time, share, rate, data)


class _Entries:
    """Pressure and shear on edges are linear in positions: two constant matrices."""

    def __init__(self, load: FollowerLoad, place: Callable[[Ints, Ints], Ints]) -> None:
        row, column, self.pressure, self.shear = load.derivatives()
        self.at = place(row, column)

    def add(self, share: float, pressure: float, shear: float, data: Floats) -> None:
        np.subtract.at(data, self.at, share * (pressure * self.pressure + shear * self.shear))


class OwnNodes:
    """2x2 blocks of the nodes loaded by an effect."""

    def __init__(self, effect: Any, model: Model, place: Callable[[Ints, Ints], Ints]) -> None:
        self.effect, state = effect, model.state
        self.displacement = state["displacement"]
        self.velocity = state["velocity"] if "velocity" in state else np.zeros((0, 2))
        draw = np.random.default_rng(1)
        self.signs, self.trial = (draw.choice([-1.0, 1.0], size=self.displacement.shape) for _ in range(2))
        self.step = STEP * float(np.ptp(model.reference, axis=0).max())
        # nodes of rigid surfaces move by prescription and are not in the pattern
        self.at = np.unique(np.concatenate([body.cells.ravel() for body in model.bodies]))
        row, column = np.meshgrid(np.arange(2, dtype=np.int32), np.arange(2, dtype=np.int32), indexing="ij")
        self.place = place(2 * self.at[:, None, None] + row, 2 * self.at[:, None, None] + column)

    def add(self, time: float, share: float, rate: float, data: Floats) -> None:
        """Add differences if forces depend on positions at all."""
        blocks = np.zeros((*self.displacement.shape, 2))
        for k in range(2):
            motion = np.zeros_like(self.signs)
            motion[:, k] = self.signs[:, k]
            blocks[:, :, k] = self._change(time, motion, rate) * self.signs[:, k, None]
        if not blocks.any():
            return
        wanted = self._change(time, self.trial, rate)
        found = np.einsum("nik,nk->ni", blocks, self.trial)
        if np.abs(wanted - found).max() <= TRUSTED * np.abs(wanted).max():
            data[self.place] -= share * blocks[self.at]

    def _change(self, time: float, motion: Floats, rate: float) -> Floats:
        """Return the change of the forces (N, 2) per unit of a motion (N, 2)."""
        before, speed = self.displacement.copy(), self.velocity.copy()
        change = np.zeros_like(before)
        for side in (1.0, -1.0):
            forces = np.zeros_like(before)
            self.displacement[:] = before + side * self.step * motion
            if rate and len(speed):
                self.velocity[:] = speed + side * self.step * rate * motion
            self.effect(time, forces)
            change += side * forces
        self.displacement[:], self.velocity[:] = before, speed
        return change / (2.0 * self.step)
