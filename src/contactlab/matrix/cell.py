"""One cell, in a process of its own: what is in the archive is not run again."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from time import process_time
from typing import Any

from contactlab.api import Job, Measure, Record
from contactlab.cases.record import to_bytes
from contactlab.cases.run_case import evaluated, run_case, run_job
from contactlab.cases.verdict import Finding, judge
from contactlab.errors import ContactlabError
from contactlab.matrix.archive import Archive, StoredRun
from contactlab.matrix.keys import case_sources, machine, run_key
from contactlab.matrix.plan import Cell
from contactlab.parts.registry import Registry
from contactlab.scene.scene import Scene


@dataclass
class CellResult:
    """What came of a cell: its verdict, the measures with theirs, the keys of its runs, and those made now."""

    verdict: str
    status: str
    reason: str
    measures: list[dict[str, Any]] = field(default_factory=list)
    runs: list[str] = field(default_factory=list)
    cpu_s: float = 0.0
    made: list[StoredRun] = field(default_factory=list)

    def as_data(self) -> dict[str, Any]:
        """Without the runs themselves."""
        return {name: value for name, value in vars(self).items() if name != "made"}


def cell_key(cell: Cell, registry: Registry, runs: list[str]) -> str:
    """Hash of the choices, of the sources of the case, and of the runs."""
    texts = [*cell.choices.values(), case_sources(cell.name, registry), *sorted(runs)]
    return hashlib.sha256("\0".join(texts).encode()).hexdigest()[:32]


def run_cell(cell: Cell, registry: Registry, archive: Path | None, report: Callable[[Any], None]) -> CellResult:
    """Run and judge one cell."""
    case = cell.case(registry)
    why = case.applies(cell.setup)
    if why:
        return CellResult("not-applicable", "", why)
    known = Archive(archive, write=False) if archive is not None and archive.exists() else None
    taken: list[tuple[str, Record]] = []
    made: list[StoredRun] = []

    def run(job: Job, scene: Scene) -> Record:
        key = run_key(job, scene)
        record = known.record(key, machine()) if known is not None else None
        if record is None:
            began = process_time()
            record = run_job(job, scene)
            cost = process_time() - began - float(record.summary.get("cost", {}).get("compile_s", 0.0))
            work = record.summary.get("steps", 0) + record.summary.get("iterations", 0)
            name = f"{cell.name} {job.name}"
            made.append(StoredRun(key, name, scene.toml(), record.status, record.reason, work, cost, to_bytes(record)))
        taken.append((key, record))
        return record

    try:
        _, done = run_case(case, cell.setup, registry, run)
        finding = judge(case, cell.setup, done, evaluated(case, cell.setup, done))
    except ContactlabError as error:
        finding = Finding("failed", "failed", str(error), ())
    finally:
        if known is not None:
            known.__exit__()
    cpu = sum(float(record.summary.get("cost", {}).get("run_cpu_s", 0.0)) for _, record in taken)
    measures = [_row(j.measure, j.value, j.verdict) for j in finding.judged]
    return CellResult(
        finding.verdict, finding.status, finding.reason, measures, [key for key, _ in taken], cpu, made
    )  # fmt: skip


def _row(measure: Measure, value: float, verdict: str) -> dict[str, Any]:
    return {
        "measure": measure.name, "role": measure.role, "value": value, "least": measure.least, "most": measure.most,
        "unit": measure.unit, "verdict": verdict, "why": measure.why,
    }  # fmt: skip
