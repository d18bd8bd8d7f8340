"""Where the work of published contact forces comes from, step by step (docs/theory/contact-energy.md).

python benchmarks/studies/contact_power.py [SCENE] [CELLS OF THE BLOCK]

Closing, rows at predicted instead of reached positions, turning normals, and changing weights; sums in mJ at the end.
"""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np

import contactlab
from contactlab.api import Floats
from contactlab.api.surface import SurfacePositions
from contactlab.errors import SimulationFailure
from contactlab.model.build import build
from contactlab.run.prepare import prepare_run

TERMS = ("closing", "predicted", "normals", "weights", "all")


class ContactPower:
    """Called in place of the contact system's `solve`; `work` (5,) sums the terms [mJ]."""

    def __init__(self, contact: Any) -> None:
        (self.pair,) = contact.pairs
        self.contact, self.solve, self.work = contact, contact.solve, np.zeros(len(TERMS))
        self.before: tuple[Floats, ...] | None = None
        self.enforced = np.zeros(self.pair.slots)

    def __call__(self, predicted: Floats, current: Floats, compliance: Floats, force: Floats) -> Any:
        """One solve, and what it does to the gaps of one step before."""
        pair = self.pair
        pair.update(current, self.contact.memories[0].copy())
        kept = np.zeros(pair.slots, np.bool_)
        kept[pair.coupling.order] = True
        now = current.copy(), pair.gaps[:, 0].copy(), pair.separation.copy(), pair.normals.copy(), kept
        done = self.solve(predicted, current, compliance, force)
        y = self.contact.multipliers[0]
        if self.before is not None:
            self._book(y, *self.before)
        self.before = (*now, np.where(kept, self.enforced, 0.0))
        # rows of the enforcement, at the positions that they lead to
        _, gap = self._separations(predicted + compliance * force)
        self.enforced = np.where(gap < 1e100, gap, 0.0)
        return done

    def _separations(self, x: Floats) -> tuple[Floats, Floats]:
        pair = self.pair
        separation, gap = np.zeros((pair.slots, 2)), np.full((pair.slots, 2), 1e300)
        sides = SurfacePositions(x[pair.slave.nodes], x[pair.master.nodes])
        pair.separations(sides, pair.normals, separation, gap)
        return separation, gap[:, 0]

    def _book(
        self, y: Floats, x: Floats, gap: Floats, apart: Floats, normal: Floats, kept: Floats, enforced: Floats
    ) -> None:
        """Work of forces y by what was one step before: positions, gaps, separations, normals, enforced gaps."""
        pair = self.pair
        moved, _ = self._separations(x)
        pressed = (y > 0.0) & kept
        y, present = y[pressed], pair.normals[pressed]
        terms = (
            enforced[pressed],
            (gap - enforced)[pressed],
            ((present - normal[pressed]) * apart[pressed]).sum(axis=1),
            (present * (moved - apart)[pressed]).sum(axis=1),
        )
        sums = [-0.5 * float(y @ term) for term in terms]
        self.work += [*sums, sum(sums)]


def measured(name: str, changes: dict[str, Any]) -> tuple[Floats, Floats]:
    """Sums of the terms, and the energy ledger at the end."""
    scene = contactlab.load_scene(name).with_(changes)
    model = build(scene, scene.registry)
    assert model.contact is not None
    power = ContactPower(model.contact)
    model.contact.solve = power  # type: ignore[method-assign]
    run = prepare_run(model, scene, scene.registry, None, False)
    advance, schedule = model.bound_integrator().step, run.schedule
    run.store_start()
    while not schedule.done():
        step = advance(schedule.dt)
        for sample in run.every_step:
            sample(step, schedule.dt)
        if model.state.step % 50 == 0:
            schedule.adapt()
    try:
        schedule.verdict()
    except SimulationFailure as failure:
        print(failure)
    return power.work, model.state["work"]


def main() -> None:
    """Print the sums."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("scene", nargs="?", default="disc-on-block")
    arguments.add_argument("cells", nargs="*", type=int, default=[72, 12])
    given = arguments.parse_args()
    changes: dict[str, Any] = {"bodies.block.mesh.cells": given.cells} if given.scene == "disc-on-block" else {}
    terms, ledger = measured(given.scene, changes)
    print(*(f"{name} {value:.4g}" for name, value in zip(TERMS, terms, strict=True)), sep=", ")
    print(f"ledger: contact {ledger[3]:.4g}, stresses {ledger[0]:.4g}, supports {ledger[1]:.4g}")


if __name__ == "__main__":
    main()
