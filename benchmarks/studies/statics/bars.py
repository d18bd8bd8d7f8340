"""Implicit dynamics with exact answers: a bar on a wall, a bouncing bar, two beams, a block that comes to rest."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from statics.common import INF, MORTARS, Figure, Rows, label, percent

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
            "integrator": "implicit-dynamics",
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


# --- two beams, one clamped: SDNL111 of Code_Aster --------------------------------------------------

BEAM = {"young": 2e11, "poisson": 0.3, "density": 7800.0}  # N, m, kg, s
PUBLISHED = {2e-4: -1.05e-4, 4e-4: -1.554199e-4, 6e-4: -5.541991e-5, 8e-4: 9.916018e-5, 1e-3: 2.991602e-4}


def two_beams(algorithm: str, cells: int, steps: int) -> Record:
    """The free one meets the clamped one at 1 m/s; the tip is its struck end."""
    bodies = {
        "free": strip((0.0, 1.0), (0.0, 0.01), [cells, 1], velocity=[-1.0, 0.0], shift=[1e-5, 0.0]),
        "clamped": strip((-1.0, 0.0), (0.0, 0.01), [cells, 1]),
    }
    return run(
        scene(
            bodies,
            BEAM,
            contacts=[{"slave": "free.left", "master": "clamped.right", "algorithm": algorithm}],
            supports=[{"on": "free", "uy": 0.0}, {"on": "clamped", "uy": 0.0}, {"on": "clamped.left", "ux": 0.0}],
        ),
        steps,
        1e-3 / steps,
    )


# --- a block that falls on a plane and comes to rest ------------------------------------------------


def dropped_block(algorithm: str, steps: int = 200) -> Record:
    """Weight 20, damped, dropped from 0.05; steps of 0.01 s."""
    block = strip((0.0, 2.0), (0.0, 1.0), [4, 2], shift=[0.0, 0.05])
    return run(
        scene(
            {"block": block},
            {"young": 1000.0, "poisson": 0.3, "density": 1.0},
            time={"end": 1e9, "damping": 20.0},
            rigid={"ground": {"line": [[4.0, 0.0], [-2.0, 0.0]]}},
            contacts=[{"slave": "block.bottom", "master": "ground", "algorithm": algorithm}],
            effects=[{"use": "gravity", "acceleration": [0.0, -10.0]}],
            supports=[{"on": "block.left", "ux": 0.0}],
        ),
        steps,
        0.01,
        axis=1,
        weight=10.0,
    )


# --- what is measured -------------------------------------------------------------------------------


def case_bars() -> Rows:
    """A bar on a wall: rho c v = 300 for 2 L/c, then flight; 100 cells, arrival at the end of a step and within one."""
    cells = 100
    for algorithm in (*MORTARS, "node-on-segment"):
        for courant, phase in ((1.0, 0.0), (1.0, 0.5), (0.9, 0.5), (5.0, 0.0)):
            found = wall_impact(courant, algorithm, phase, cells)
            active = np.flatnonzero(found.force > 1.0)
            middle = found.force[(found.time > 0.55) & (found.time < 1.1)]
            nodes = 1.0 if phase == 0.0 else float(np.sqrt(1.0 + courant**2))
            loss = 1.0 - found.energy[-1] / ENERGY
            yield (
                label(algorithm, f"Courant {courant:g}, phase {phase:g}"),
                [
                    percent("mean force", float(middle.mean()) / 300.0 - 1.0, 0.2),
                    percent("ripple (rms)", float(middle.std()) / 300.0),
                    percent("loss against that of the stopped nodes", loss / (nodes * 0.5 / cells) - 1.0, 1.0),
                    Figure("contacts after the first", float(np.count_nonzero(np.diff(active) > 1)), most=0.0),
                    Figure("largest rise of energy in a step", float(np.diff(found.energy).max()) / ENERGY, most=1e-9),
                ],
            )


def case_bouncing() -> Rows:
    """Three periods of 16/3 s, six impacts; phase from the momentum at the top."""
    start = 10.0 * LENGTH * 5.0
    for cells, courant in ((100, 0.7), (200, 0.7), (400, 0.7), (200, 2.0)):
        found = bouncing_bar(cells, courant, 3.0)
        dt = float(found.time[0])
        first = (found.time > 0.95) & (found.time < 2.0)
        impulse = float(found.force[first].sum()) * dt / (800.0 / 3.0) - 1.0
        tops = [round(k * 16.0 / 3.0 / dt) - 1 for k in (1, 2, 3)]
        phases = [float(found.momentum[top, 0]) / LENGTH / 10.0 / (16.0 / 3.0) for top in tops]
        yield (
            f"{cells} cells, Courant {courant:g}",
            [
                percent("impulse of the first contact", impulse, 0.5),
                *(percent(f"phase after {k + 1}", phase, 1.0 if k == 2 else INF) for k, phase in enumerate(phases)),
                percent("energy lost", -float(found.energy[-1]) / start),
                Figure("largest rise of energy in a step", float(np.diff(found.energy).max()) / start, most=1e-9),
            ],
        )


def case_beams() -> Rows:
    """Tip of the struck beam at five instants, aim 1 %, 5 % in the published test."""
    cells, variants = 200, [(algorithm, steps) for algorithm in MORTARS for steps in (600, 1200, 2400)]
    for algorithm, steps in (*variants, ("mortar-p0", 4800)):
        found = two_beams(algorithm, cells, steps)
        way = 5875.0 * 1e-3 / steps * cells
        yield (
            label(algorithm, f"{cells} cells, {way:.2g} cells a step"),
            [
                *(
                    percent(f"at {1e4 * time:g}e-4 s", float(np.interp(time, found.time, found.tip)) / exact - 1.0, 1.0)
                    for time, exact in PUBLISHED.items()
                ),
                Figure(
                    "largest rise of energy in a step",
                    float(np.diff(found.energy).max() / found.energy[0]),
                    most=1e-9,
                ),
            ],
        )


def case_rest() -> Rows:
    """A dropped block: no energy from contact, then rest with the weight as reaction."""
    for algorithm in (*MORTARS, "node-on-segment"):
        found = dropped_block(algorithm, 400)
        changes = np.flatnonzero(np.diff(found.closed.astype(int)))
        yield (
            label(algorithm),
            [
                Figure("largest rise of energy in a step", float(np.diff(found.energy).max()), most=1e-9),
                percent("reaction at rest", float(np.abs(found.force[-100:] / 20.0 - 1.0).max()), 0.1),
                Figure("openings and closings", float(len(changes))),
                Figure("of them in the last 100 steps", float(np.count_nonzero(changes > 299)), most=0.0),
                Figure("least force N", float(found.force.min()), least=0.0),
            ],
        )
