"""What disc-on-block, deep, costs at the same error of the pressure: explicit, by load steps, from coarse to fine.

    python benchmarks/studies/equal_error.py [LEVEL ...]

Neo-Hookean, without friction, mortar-p0 with the disc and mortar-p1 with the block as slave. Every level is run by each
way in turn, in one process; seconds are CPU seconds of the whole run without compiling. Costs between levels are
interpolated, both logarithms straight; an error that no two levels enclose has none.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from nested_cost import WAYS, timed

from contactlab.studies.measures import pressure_error
from contactlab.studies.profile import Profile
from contactlab.studies.reference import Reference, load_reference

SETUPS = (("mortar-p0", False), ("mortar-p1", True))
TARGETS = (0.01, 0.005, 0.003, 0.0015)  # the reference is known to 0.11 %: less cannot be told
FINEST = {"nested": 16, "5 load steps": 8, "explicit": 6}
"""Levels up to which a way is run: what is finer takes minutes."""
Points = list[tuple[float, float]]


def cost_at(target: float, points: Points) -> float:
    """CPU seconds at an error, from (error, seconds) by level; not a number where no two levels enclose it."""
    for (coarse, cheap), (fine, dear) in pairwise(points):
        if fine <= target <= coarse:
            share = np.log(target / coarse) / np.log(fine / coarse)
            return float(cheap * (dear / cheap) ** share)
    return float("nan")


def points_of(levels: list[int], algorithm: str, swap: bool, reference: Reference) -> dict[str, Points]:
    """(error, seconds) by level, for each way."""
    found: dict[str, Points] = {way: [] for way in WAYS}
    for level in levels:
        for way, points in found.items():
            if level > FINEST[way]:
                continue
            seconds, results = timed(level, way, algorithm, swap)
            curve = Profile.of_curve(results.contact["contacts.0"].last)
            points.append((pressure_error(curve, reference.profile, reference.window), seconds))
            print(f"<!-- {algorithm} {level} {way}: {100 * points[-1][0]:.3f} %, {seconds:.2f} s -->", flush=True)
    return found


def rows(levels: list[int]) -> Iterator[str]:
    """The table, line by line."""
    reference = load_reference("disc-on-block-deep")
    yield "| algorithm, slave | way | " + " | ".join(f"CPU s at {100 * target:g} %" for target in TARGETS) + " |"
    yield "|---" * (2 + len(TARGETS)) + "|"
    for algorithm, swap in SETUPS:
        for way, points in points_of(levels, algorithm, swap, reference).items():
            costs = [cost_at(target, points) for target in TARGETS]
            texts = ["outside" if np.isnan(cost) else f"{cost:.2g}" for cost in costs]
            yield f"| {algorithm}, {'block' if swap else 'disc'} | {way} | {' | '.join(texts)} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("levels", nargs="*", type=int, default=[1, 2, 3, 4, 6, 8, 16])
    options = parser.parse_args()
    for way in WAYS:
        timed(1, way, "mortar-p0", False)
        timed(1, way, "mortar-p1", True)
    for line in rows(options.levels):
        print(line, flush=True)


if __name__ == "__main__":
    main()
