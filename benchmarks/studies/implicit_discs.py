"""Two discs with spin that hit each other, in implicit steps: what contact takes and gives, and the momenta.

    python benchmarks/studies/implicit_discs.py        # the table of docs/theory/contact-energy.md

Each algorithm with four and eight segments to a quarter of the circle, without and with friction; conjugate and
published forces.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from contactlab.api import WORK
from contactlab.model.build import build
from contactlab.model.model import Model
from contactlab.scene.scene import Scene

ALGORITHMS = ("mortar-p0", "mortar-p1", "node-on-segment")
END, STEPS, SPEED, SPIN, MU = 1e-4, 100, 20000.0, 2e4, 0.3
DENSITY = 1e-9
BROUGHT = 0.5 * np.pi * DENSITY * SPEED**2
"""Kinetic energy [mJ] that the upper disc brings, its spin aside."""


class Found(NamedTuple):
    """What a run gave, energies over `BROUGHT`, spin over sum m |v| times 1 mm.

    contact, rubbing  all that contact and friction gave
    largest           largest gift of contact in a step
    rise              largest rise of kinetic and stored energy in a step
    spin              largest change of the angular momentum
    """

    contact: float
    rubbing: float
    largest: float
    rise: float
    spin: float


def discs(algorithm: str, segments: int, friction: bool, forces: str) -> Scene:
    """A disc that falls on another, 0.3 mm off centre, and spins."""
    rings = 3 * segments // 4

    def disc(cells: int, **more: Any) -> dict[str, Any]:
        return {
            "element": "q1", "material": "soft", "mesh": {"use": "disc", "radius": 1.0, "cells": [cells, rings]}, **more
        }  # fmt: skip

    contact: dict[str, Any] = {
        "slave": "upper.bottom", "master": "lower.top", "algorithm": algorithm,
        "enforcement": {"use": "active-set", "forces": forces},
    }  # fmt: skip
    return Scene.from_data(
        {
            "format": 1,
            "name": "discs that meet off centre",
            "integrator": {"use": "implicit-dynamics", "steps": STEPS},
            "time": {"end": END},
            "materials": {"soft": {"use": "neo-hookean", "young": 1000.0, "poisson": 0.3, "density": DENSITY}},
            "bodies": {
                "upper": disc(segments, velocity=[0.0, -SPEED], spin=SPIN),
                "lower": disc(segments + 1, shift=[0.3, -2.0]),
            },
            "contacts": [contact | ({"friction": {"use": "coulomb", "mu": MU}} if friction else {})],
        }
    )


def run(scene: Scene) -> Found:
    """All steps of a scene."""
    model = build(scene, scene.registry)
    advance, state = model.bound_integrator().step, model.state
    contact, rubbing, energy, spin = [0.0], [0.0], [model.kinetic_energy()], [spin_of(model)]
    scale = float(model.mass @ np.hypot(*state["velocity"].T))
    for _ in range(STEPS):
        step = advance(END / STEPS)
        if step.reason:
            raise RuntimeError(f"{scene.contacts[0].algorithm}: {step.reason}")
        work = dict(zip(WORK, state["work"].tolist(), strict=True))
        contact.append(work["contact"] / BROUGHT)
        rubbing.append(work["friction"] / BROUGHT)
        energy.append(model.kinetic_energy() + work["internal"])
        spin.append(spin_of(model))
    return Found(
        contact[-1], rubbing[-1], float(np.diff(contact).max()), float(np.diff(energy).max()) / BROUGHT,
        float(np.abs(np.subtract(spin, spin[0])).max()) / scale,
    )  # fmt: skip


def spin_of(model: Model) -> float:
    """Angular momentum [N mm s] about the origin."""
    (x, y), (vx, vy) = (model.reference + model.state["displacement"]).T, model.state["velocity"].T
    return float(model.mass @ (x * vy - y * vx))


def main() -> None:
    """Print the rows of the table."""
    for algorithm in ALGORITHMS:
        for segments in (4, 8):
            for friction in (False, True):
                found = run(discs(algorithm, segments, friction, "consistent"))
                published = run(discs(algorithm, segments, friction, "frozen"))
                rubbing = f"{-found.rubbing:.1%}" if friction else ""
                print(
                    f"| {algorithm} | {segments} | {MU if friction else 'none'} | {-found.contact:.1%} | {rubbing} "
                    f"| {max(found.rise, 0.0):.0e} | {found.spin:.0e} | {published.largest:.2g} |"
                )


if __name__ == "__main__":
    main()
