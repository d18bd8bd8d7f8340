"""Mesh ratios from 1:1 to 1:8 either way: what contact makes of energy, and what disc-on-block carries.

python benchmarks/studies/contact_ladder.py [--forces conjugate|published] [--element q1|q2|q2-lagrange] [--largest 8]

One line for each ratio, finer side, algorithm and slave: status, energy made by contact over what is stored, largest
rise between frames over the same, and the reaction (docs/theory/contact-energy.md).
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from itertools import product
from typing import Any, NamedTuple

import numpy as np

import contactlab

RATIOS = (1, 2, 3, 5, 8)
COARSER_FROM = 5  # both meshes have half as many cells there, so that the finer one stays affordable


class Rung(NamedTuple):
    """One run of the ladder; `slave` is the body whose surface carries the multipliers."""

    ratio: int
    finer: str
    algorithm: str
    slave: str

    def changes(self, element: str, forces: str) -> dict[str, Any]:
        """Keys of disc-on-block."""
        base = 24 if self.ratio < COARSER_FROM else 12
        if element != "q1":
            base //= 2  # as many nodes along the surface
        disc = base * (self.ratio if self.finer == "disc" else 1)
        # segments of the block, 1.8 long, as long as those of the disc, whose chord is 1.6
        block = round(base * 1.8 / 1.6 * (self.ratio if self.finer == "block" else 1))
        return {
            "bodies.disc.element": element,
            "bodies.block.element": element,
            "bodies.disc.mesh.cells": [disc, max(2, disc // 4)],
            "bodies.block.mesh.cells": [block, max(2, block // 6)],
            "contacts.0.algorithm": self.algorithm,
            "contacts.0.swap": self.slave == "block",
            "contacts.0.enforcement": {"use": "forward-increment", "forces": forces},
        }


def rungs(largest: int) -> Iterator[Rung]:
    """All of them, coarse ones first."""
    for ratio in (r for r in RATIOS if r <= largest):
        sides = ("block",) if ratio == 1 else ("block", "disc")
        yield from (Rung(ratio, *rest) for rest in product(sides, ("mortar-p0", "mortar-p1"), ("disc", "block")))


def main() -> None:
    """Run the ladder and print it."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--forces", choices=("consistent", "frozen"), default="consistent")
    arguments.add_argument("--element", default="q1")
    arguments.add_argument("--largest", type=int, default=RATIOS[-1])
    given = arguments.parse_args()
    print("| ratio | finer | algorithm | slave | status | made by contact | largest rise | reaction [N/mm] |")
    print("|---|---|---|---|---|---|---|---|")
    for rung in rungs(given.largest):
        scene = contactlab.load_scene("disc-on-block").with_(rung.changes(given.element, given.forces))
        results = contactlab.simulate(scene)
        stored, made = results.summary["balance"]["stored"], results.history["energy.contact"]
        print(
            f"| 1:{rung.ratio} | {rung.finer} | {rung.algorithm} | {rung.slave} | {results.status} "
            f"| {made[-1] / stored:.2g} | {np.diff(made).max() / stored:.2g} "
            f"| {results.summary['reactions']['block.bottom'][1]:.1f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
