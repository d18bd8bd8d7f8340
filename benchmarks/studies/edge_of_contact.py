"""How the efficiency of a pressure depends on where the edge of contact lies in its segment: the section of
docs/accuracy.md.

    python benchmarks/studies/edge_of_contact.py         # runs the cylinder of `hertz` at growing depth
    python benchmarks/studies/edge_of_contact.py page    # writes the section from the rows that are kept

Efficiency is the error of the best continuous piecewise linear function on the slave's nodes over that of the run, in
L2 (docs/accuracy.md). Beside the multipliers, nodal forces over the lengths that belong to them are measured.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import kept_rows
import numpy as np
from contactlab_cases.circles import disc_on_block, hertz, hertz_pressure, hertz_values
from contactlab_cases.hertz import DEPTH, HALF_WIDTH, RADIUS, YOUNG
from contactlab_cases.statics import force_of, l2_error, plane_strain

from contactlab.api import Record, Setup
from contactlab.cases.run_case import run_job, scene_of
from contactlab.studies.best_approximation import best_error
from contactlab.studies.profile import Profile

HERE = Path(__file__).parent
STORED = HERE / "edge_of_contact.csv"
PAGE = HERE.parents[1] / "docs" / "accuracy.md"
BEGIN, END = "<!-- edges: begin -->\n", "<!-- edges: end -->"
KEYS = ("slave", "algorithm", "segments", "edge_off", "error", "forces_error", "best")
ALGORITHMS = ("mortar-p0", "mortar-p1")
SIZE = HALF_WIDTH / 16.0
"""Length of the block's segments, in radii: level 2 of the case."""
EIGHTHS = 9
POWER = 1.85
"""Of the half-width with which the depth of these finite bodies grows."""


def measured() -> Iterator[dict[str, str]]:
    """A row per slave, depth and algorithm."""
    for swap, segments in ((False, 11.86), (True, 16.06)):
        for eighth in range(EIGHTHS):
            depth = DEPTH * (1.0 + 0.125 * eighth / segments) ** POWER
            for algorithm in ALGORITHMS:
                setup = Setup(algorithm, swap, "q1", "newton", 2)
                job = disc_on_block(setup, RADIUS, (YOUNG, YOUNG), depth, SIZE)
                yield {"slave": "block" if swap else "disc", "algorithm": algorithm} | _row(run_job(job, scene_of(job)))


def _row(record: Record) -> dict[str, str]:
    """Errors of a run, and of the best approximation; lengths in segments of the slave."""
    modulus, curve = plane_strain(YOUNG) / 2.0, record.curve()
    values, exact = hertz_values(record, RADIUS, modulus), hertz_pressure(record, RADIUS, modulus)
    a, _, pressure = hertz(force_of(record), RADIUS, modulus)
    best = best_error(
        np.asarray(curve.x, float), Profile(np.asarray(exact.x), np.asarray(exact.pressure)), exact.window
    )
    found = {
        "segments": values["segments in the half-width"], "edge_off": values["half-width in segments"],
        "error": values["L2 of the pressure"], "best": best,
        "forces_error": l2_error(curve.x, curve.nodal_pressure, pressure, 2.0 * a),
    }  # fmt: skip
    return {name: f"{value:.5g}" for name, value in found.items()}


def section(rows: list[dict[str, str]]) -> str:
    """A row per depth with the block as slave, whose segments are of one length; the ranges with the disc."""
    lines = [
        "| segments in the half-width | edge found, segments off | P0 | P1 | nodal forces of P0 |",
        "|---|---|---|---|---|",
    ]
    for row, *shares in zip(_of(rows, "block", "mortar-p0"), *_efficiencies(rows, "block"), strict=True):
        told = " | ".join(f"{share:.2f}" for share in shares)
        lines.append(f"| {float(row['segments']):.2f} | {float(row['edge_off']):+.2f} | {told} |")
    p0, p1, forces = (f"{min(found):.2f} to {max(found):.2f}" for found in _efficiencies(rows, "disc"))
    ranges = f"With the disc as slave: P0 {p0}, P1 {p1}, nodal forces {forces}."
    return "\n".join([*lines, "", ranges, ""])


def _of(rows: list[dict[str, str]], slave: str, algorithm: str) -> list[dict[str, str]]:
    return [row for row in rows if (row["slave"], row["algorithm"]) == (slave, algorithm)]


def _efficiencies(rows: list[dict[str, str]], slave: str) -> list[list[float]]:
    """Of P0, of P1, and of the nodal forces of P0, at all depths."""
    columns = ("mortar-p0", "error"), ("mortar-p1", "error"), ("mortar-p0", "forces_error")
    return [[float(row["best"]) / float(row[name]) for row in _of(rows, slave, which)] for which, name in columns]


def page(rows: list[dict[str, str]]) -> str:
    """docs/accuracy.md with the section of these rows."""
    head, rest = PAGE.read_text(encoding="utf-8").split(BEGIN, 1)
    return head + BEGIN + section(rows) + END + rest.split(END, 1)[1]


def main() -> None:
    """Measure, or write the section."""
    if sys.argv[1:] != ["page"]:
        kept_rows.write(STORED, KEYS, measured())
    PAGE.write_text(page(kept_rows.read(STORED)), encoding="utf-8")


if __name__ == "__main__":
    main()
