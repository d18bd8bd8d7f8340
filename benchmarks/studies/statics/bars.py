"""Implicit dynamics with exact answers: a bar on a wall, and one that falls and bounces."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from contactlab.api import Floats
from contactlab.model.build import build
from contactlab.parts.registry import default_registry
from contactlab.scene.scene import Scene


@dataclass
class Record:
    """After every step: time, contact force on the first body, energy, momentum of each body, displacement of a node,
    whether there is contact; closure of the ledger and displacements at the end."""

    time: Floats
    force: Floats
    energy: Floats
    momentum: Floats
    tip: Floats
    closed: Floats
    ledger: float
    end: Floats


def strip(x: tuple[float, float], y: tuple[float, float], cells: list[int], **more: Any) -> dict[str, Any]:
    """A rectangle of the only material."""
    return {"element": "q1", "material": "m", "mesh": {"use": "rectangle", "x": x, "y": y, "cells": cells}, **more}


def scene(bodies: dict[str, Any], material: dict[str, Any], **more: Any) -> Scene:
    """Without an end of its own."""
    return Scene.from_data(
        {
            "name": "impact",
            "time": {"end": 1e9},
            "integrator": {"use": "implicit-dynamics", "impacts": False},  # steps are made one by one
            "materials": {"m": {"use": "linear-elastic"} | material},
            "bodies": bodies,
        }
        | more
    )


def run(scene: Scene, steps: int, dt: float, axis: int = 0, weight: float = 0.0) -> Record:
    """`weight` is the acceleration of gravity against the axis, whose potential counts as energy."""
    model = build(scene, default_registry())
    advance, state = model.bound_integrator().step, model.state
    bodies = [slice(b.first, b.first + b.count) for b in model.bodies]
    tip = model.contact.pairs[0].slave.nodes[0] if model.contact is not None else -1
    rows = []
    for _ in range(steps):
        step = advance(dt)
        assert step.status.name == "accepted", step.reason
        u, force = state["displacement"], 0.0
        if model.contact is not None:
            force = float(state["contact_force"][bodies[0], axis].sum())
        energy = model.kinetic_energy() + sum(part.stored_energy() for part in model.forces)
        energy += weight * float(model.mass @ u[:, axis])
        momenta = [float(model.mass[b] @ state["velocity"][b, axis]) for b in bodies]
        rows.append((state.time, force, energy, momenta, u[tip, axis], force > 0.0))
    internal, external, damping, contact, friction, numerical, _ = state["work"]
    change = model.kinetic_energy() + internal + damping + numerical - external - contact - friction
    time, force_, energy_, momentum, moved, closed = (np.array(column) for column in zip(*rows, strict=True))
    balance = float(change) - model.initial_energy
    return Record(time, force_, energy_, momentum, moved, closed, balance, state["displacement"])


# --- a bar against a wall: L = 10, E = 900, rho = 1, c = 30, arrives at 10 after 0.5 s --------------

LENGTH, SPEED, SOUND = 10.0, 10.0, 30.0
CELLS = 50
BAR = {"young": SOUND**2, "poisson": 0.0, "density": 1.0}
ENERGY = 0.5 * LENGTH * SPEED**2  # per unit of height, which is 1


@cache
def wall_impact(courant: float, algorithm: str = "mortar-p0", phase: float = 0.0, cells: int = CELLS) -> Record:
    """One cell of unit height across; `phase` is the part of a step that is left when the bar arrives."""
    dt = courant * LENGTH / cells / SOUND
    arrival = (round(0.5 / dt) - phase) * dt
    return run(
        scene(
            {"bar": strip((0.0, LENGTH), (0.0, 1.0), [cells, 1], velocity=[-SPEED, 0.0], shift=[SPEED * arrival, 0.0])},
            BAR,
            rigid={"wall": {"line": [[0.0, -1.0], [0.0, 2.0]]}},
            contacts=[{"slave": "bar.left", "master": "wall", "algorithm": algorithm}],
            supports=[{"on": "bar", "uy": 0.0}],
        ),
        round(1.4 / dt),
        dt,
    )


# --- a bar that falls and bounces, period 16/3 s ----------------------------------------------------


def bouncing_bar(cells: int, courant: float, periods: float) -> Record:
    """Dropped from 5 at rest."""
    dt = courant * LENGTH / cells / SOUND
    return run(
        scene(
            {"bar": strip((0.0, 1.0), (0.0, LENGTH), [1, cells], shift=[0.0, 5.0])},
            BAR,
            rigid={"ground": {"line": [[2.0, 0.0], [-1.0, 0.0]]}},
            contacts=[{"slave": "bar.bottom", "master": "ground", "algorithm": "mortar-p0"}],
            supports=[{"on": "bar", "ux": 0.0}],
            effects=[{"use": "gravity", "acceleration": [0.0, -10.0]}],
        ),
        round(periods * 16.0 / 3.0 / dt),
        dt,
        axis=1,
        weight=10.0,
    )
