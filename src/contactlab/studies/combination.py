"""The runs of one combination of a study, and their record."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Generator, Sequence
from dataclasses import replace

from contactlab.api import Job, Record
from contactlab.jobs.run import Run
from contactlab.studies.plan import Combination
from contactlab.studies.recordings import RUNS


def combination_plan(
    one: Combination,
    repeat: int,
    proof: str | None = None,
    over: Callable[[Combination, Record], None] = lambda one, record: None,
) -> Generator[Sequence[Run], Sequence[Record], Record]:
    """The record of one combination, with the medians of the costs of its repetitions.

    proof  the file that the first one leaves in any case; None for no files
    """
    job = Job(one.name, "", fields=True, curves="last")
    first, *others = yield [
        Run(
            job, one.scene, one.name, place="" if proof is None or number else f"{RUNS}/{one.name}",
            proof=proof or "", number=number,
            # the study's own runs first, then the longest, so that no core waits at the end
            rank=(float(one.refines), -float(one.scene.level)), timed=True,
        )
        for number in range(repeat)
    ]  # fmt: skip
    costs = [record.summary.get("cost", {}) for record in (first, *others) if record.status == first.status]
    names = ("run_cpu_s", "run_wall_s", "compile_s")
    medians = {name: statistics.median(c[name] for c in costs) for name in names if all(name in c for c in costs)}
    cost = {**first.summary.get("cost", {}), **medians}
    record = replace(first, summary={**first.summary, "cost": cost}) if cost else first
    over(one, record)
    return record
