"""What cases without an exact answer are compared with: own runs on finer meshes, with both mortars and either slave.

    python benchmarks/studies/case_references.py QUESTION ... [--finest LEVEL] [--most SECONDS] [--algorithms NAME ...]

makes runs of a question at its levels up to LEVEL; rows are kept in case_references.csv, and runs that are there are
not made again. A level is not begun that would take a run more than so many CPU seconds. `references_page.py` makes
the page of the rows.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from contactlab_cases.disc_with_friction import DEEP, SHALLOW, DiscWithFriction
from contactlab_cases.forging import Forging
from contactlab_cases.ironing import Ironing
from contactlab_cases.taylor_bar import TaylorBar
from contactlab_cases.tresca_block import TrescaBlock

from contactlab.api import Case, Job, Record, Setup
from contactlab.cases.run_case import run_job, scene_of
from contactlab.jobs.rows import Row, read_csv, write_csv

HERE = Path(__file__).parent
STORED = HERE / "case_references.csv"
COLUMNS = (
    "question", "quantity", "algorithm", "slave", "element", "steps", "level", "value", "status", "iterations",
    "cpu_s", "load", "date",
)  # fmt: skip
MORTARS = ("mortar-p0", "mortar-p1")
GROWTH = 8.0  # of the CPU time from a level to twice that: cells times four, and steps or a solver that grows as well

Quantities = Callable[[Case, Setup, Record], dict[str, float]]


@dataclass(frozen=True)
class Question:
    """A case with its fields, as its contributors run it.

    found       values by quantity from the record of a run
    integrator  of the contributors, without its number of steps
    steps       numbers of load steps; all levels are run with the first of them, the level `tried` with all
    changes     of the scene of the case
    """

    case: Case
    found: Quantities
    integrator: str
    levels: Sequence[int] = (1, 2, 4, 8)
    steps: Sequence[int] = ()
    tried: int = 1
    swaps: Sequence[bool] = (False, True)
    elements: Sequence[str] = ("q1",)
    job: str = ""
    changes: Mapping[str, Any] = field(default_factory=dict)
    drops: Sequence[str] = ()


@dataclass(frozen=True)
class Contributor:
    """One run: what tells it from the others of its question."""

    algorithm: str
    swap: bool
    element: str
    steps: int
    level: int

    @property
    def key(self) -> Row:
        """As in a row."""
        return {
            "algorithm": self.algorithm, "slave": "exchanged" if self.swap else "declared", "element": self.element,
            "steps": str(self.steps or ""), "level": str(self.level),
        }  # fmt: skip


# --- quantities -------------------------------------------------------------------------------------------


def reaction(case: Case, setup: Setup, record: Record) -> dict[str, float]:
    """What the disc is pressed with."""
    return {"reaction [N/mm]": abs(float(record.reaction("disc.top")[1]))}


def lift(case: Case, setup: Setup, record: Record) -> dict[str, float]:
    """Where contact ends, to a segment, and how far the corner beyond it lifts."""
    curve = record.curve()
    start = np.linspace(0.0, 1.3, len(curve.x))
    return {
        "lift of the free corner [mm]": float(np.nanmax(curve.gap)),
        "last closed node [mm]": float(start[np.asarray(curve.nodal_pressure) > 0.0].max()),
    }


def shape(case: Case, setup: Setup, record: Record) -> dict[str, float]:
    """What is left of the bar, and what flow has taken of its energy."""
    found = case.evaluate(setup, {"hit": record})
    taken = found["energy taken by flow over the kinetic one, less one"]
    return {
        "width at the wall [mm]": found["width at the wall"],
        "length in the end [mm]": found["length in the end"],
        "energy taken by flow over the kinetic one": 1.0 + taken,
    }


def floor(case: Case, setup: Setup, record: Record) -> dict[str, float]:
    """Force on the floor."""
    return {"force on the floor [N/mm]": abs(float(record.reaction("floor")[1]))}


def drawn(case: Case, setup: Setup, record: Record) -> dict[str, float]:
    """Forces at the end of press, and half-way of the published slide."""
    found = case.evaluate(setup, {"drawn": record})
    names = ("end of press", "vertical half-way", "horizontal half-way")
    return {f"{name} [N/mm]": found[name] for name in names if name in found}


def _rubbed(mu: float, depth: float) -> Question:
    return Question(
        DiscWithFriction(mu, depth),
        reaction,
        "newton",
        (1, 2, 4, 8),
        (80, 160),
        tried=2,
        job="pressed",
        drops=("time.ramp",),
    )


def _tresca(where: str) -> Question:
    return Question(TrescaBlock(where, 52), lift, "newton", (1, 2, 4, 8, 16), (1,), swaps=(False,))


def _taylor(speed: float) -> Question:
    return Question(
        TaylorBar(3, speed), shape, "central-difference", (1, 2, 4, 8), swaps=(False,),
        elements=("q1-fbar", "q1-reduced"),
    )  # fmt: skip


QUESTIONS: dict[str, Question] = {
    **{f"disc-with-friction, mu={mu}, depth={d}": _rubbed(mu, d) for d in (DEEP, SHALLOW) for mu in (0.2, 0.05)},
    **{f"tresca-block, {where}": _tresca(where) for where in ("everywhere", "closed")},
    **{f"taylor-bar, {1e-3 * speed:g} m/s": _taylor(speed) for speed in (227000.0, 150000.0, 113500.0)},
    "three-body-forging": Question(Forging(), floor, "newton", (1, 2, 4), (50, 100), elements=("q1-fbar",)),
    "ironing": Question(Ironing(5.0), drawn, "newton", (1, 2, 4), (80, 160)),
}


# --- runs -------------------------------------------------------------------------------------------------


def contributors(question: Question, level: int) -> Iterator[Contributor]:
    """All runs at a level: with every number of steps at one of the levels, with the first at all others."""
    numbers = question.steps or (0,)
    for steps in numbers if level == question.tried else numbers[:1]:
        for element in question.elements:
            for algorithm in MORTARS:
                for swap in question.swaps:
                    yield Contributor(algorithm, swap, element, steps, level)


def make(name: str, finest: int, most: float, algorithms: Sequence[str]) -> None:
    """Make the runs of a question that are not kept; print and keep them as they come."""
    question = QUESTIONS[name]
    for level in (level for level in question.levels if level <= finest):
        for run in contributors(question, level):
            rows = read_csv(STORED)
            own = [row for row in rows if row["question"] == name and run.key.items() <= row.items()]
            if own or run.algorithm not in algorithms:
                continue
            if (expected := _expected(rows, name, run)) > most:
                print(f"{name}: {run} is left out: {expected:.0f} s expected", flush=True)
                continue
            found = [{"question": name, **run.key, **row} for row in _run(question, run)]
            print(
                f"{name}: {run} {[(row['quantity'], row['value'], row['status'][:60], row['cpu_s']) for row in found]}"
            )
            write_csv(STORED, COLUMNS, [*read_csv(STORED), *found])


def _expected(rows: Sequence[Row], name: str, run: Contributor) -> float:
    """CPU seconds from the same run at half the level; 0 where it is not there."""
    coarser = {**run.key, "level": str(run.level // 2)}
    known = [float(row["cpu_s"]) for row in rows if row["question"] == name and coarser.items() <= row.items()]
    return GROWTH * max(known, default=0.0)


def _run(question: Question, run: Contributor) -> list[Row]:
    integrator: dict[str, Any] = {"use": question.integrator} | ({"steps": run.steps} if run.steps else {})
    setup = Setup(run.algorithm, run.swap, run.element, integrator, run.level)
    jobs = {job.name: job for job in question.case.plan(setup, {})}
    job = jobs[question.job or next(iter(jobs))]
    began = process_time()
    record = _record(job, question, integrator)
    seconds = process_time() - began
    told: Row = {
        "status": record.status if record.finished else f"{record.status}: {record.reason}",
        "iterations": str(record.summary.get("iterations", record.summary.get("steps", ""))),
        "cpu_s": f"{seconds:.3g}", "load": f"{os.getloadavg()[0]:.1f}", "date": datetime.now(UTC).date().isoformat(),
    }  # fmt: skip
    values = question.found(question.case, setup, record) if record.finished else {"": float("nan")}
    return [{**told, "quantity": quantity, "value": f"{value:.9g}"} for quantity, value in values.items()]


def _record(job: Job, question: Question, integrator: Mapping[str, Any]) -> Record:
    changes = {key: value for key, value in job.changes.items() if key not in question.drops}
    changes |= {"integrator": integrator, **question.changes} if isinstance(job.scene, str) else {}
    scene: Any = job.scene if isinstance(job.scene, str) else {**job.scene, "integrator": integrator}
    own = Job(job.name, scene, changes, fields=job.fields, frames=job.frames)
    return run_job(own, scene_of(own))


def main() -> int:
    """Make runs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("questions", nargs="+", choices=list(QUESTIONS), metavar="QUESTION")
    parser.add_argument("--finest", type=int, default=1 << 10)
    parser.add_argument("--most", type=float, default=120.0)
    parser.add_argument("--algorithms", nargs="+", default=MORTARS, choices=MORTARS)
    asked = parser.parse_args()
    for name in asked.questions:
        make(name, asked.finest, asked.most, asked.algorithms)
    return 0


if __name__ == "__main__":
    sys.exit(main())
