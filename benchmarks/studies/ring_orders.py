"""Orders of the pressure between two rings, from 24 cells a quarter on, with either side as slave.

    python benchmarks/studies/ring_orders.py [--cells 24 48 96] [--mean 0.05] [algorithm ...]

A run of each mesh, algorithm and slave; slopes of log error over log h with their 95 % intervals (Student's t) go into
docs/accuracy.md. The load is small, since geometry adds 0.6 p/E to the error of the small-strain answer; round-off of
positions adds 1e-15 mm to gaps. 768 cells take 13 GB.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from time import process_time

import numpy as np
from contactlab_cases.two_rings import RingsPressed

from contactlab.accuracy.orders import slope
from contactlab.api import Setup
from contactlab.cases.run_case import run_job, scene_of


def errors(algorithm: str, swap: bool, cells: int, mean: float) -> tuple[float, float]:
    """Errors in L2 of the carried and of the reported pressure, `cells` on a quarter of the coarser ring."""
    case = RingsPressed(mean=mean)
    job = case.job("pressed", Setup(algorithm, swap, "q1", "newton"), cells)
    record = run_job(job, scene_of(job))
    if not record.finished:
        raise SystemExit(f"{algorithm}, {cells} cells: {record.status}, {record.reason}")
    carried, told, _ = case.errors(record, cells)
    return carried, told


def order(cells: Sequence[int], found: Sequence[float]) -> str:
    """Slope and the half-width of its interval."""
    value, half = slope(np.log(cells), np.log(found))
    return f"{-value:.3f} ± {half:.3f}"


def main() -> None:
    """Run and print one line after the other."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("algorithm", nargs="*", default=["mortar-p0", "mortar-p1"])
    arguments.add_argument("--cells", nargs="+", type=int, default=[24, 48, 96, 192, 384])
    arguments.add_argument("--mean", type=float, default=0.05)
    given = arguments.parse_args()
    for algorithm in given.algorithm:
        for swap, slave in ((False, "coarser"), (True, "finer")):
            rows = []
            for cells in given.cells:
                began = process_time()
                rows.append(errors(algorithm, swap, cells, given.mean))
                spent = process_time() - began
                print(f"{algorithm}, {slave} slave, {cells} cells: {rows[-1][0]:.3e} carried, {rows[-1][1]:.3e} "
                      f"reported, {spent:.0f} CPU s", flush=True)  # fmt: skip
            if len(rows) > 1:
                carried, told = (order(given.cells, column) for column in zip(*rows, strict=True))
                print(f"  orders: {carried} carried, {told} reported", flush=True)


if __name__ == "__main__":
    main()
