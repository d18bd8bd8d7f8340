"""One cell, in a process of its own: what is in the archive is not run again."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import process_time
from typing import Any

from contactlab.api import Job, Measure, Record
from contactlab.archive.archive import Archive, StoredRun
from contactlab.archive.keys import case_sources, run_key
from contactlab.cases.record import to_bytes
from contactlab.cases.run_case import evaluated, run_case, run_job
from contactlab.cases.verdict import Finding, judge
from contactlab.errors import ContactlabError
from contactlab.matrix.plan import Cell
from contactlab.parts.registry import Registry
from contactlab.scene.scene import Scene
from contactlab.studies.system import machine


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
    machine: str = field(default_factory=machine)

    def as_data(self) -> dict[str, Any]:
        """What a table says of it: without the runs themselves and the machine."""
        return {name: value for name, value in vars(self).items() if name not in ("made", "machine")}


def cell_key(cell: Cell, registry: Registry, runs: list[str]) -> str:
    """Hash of the choices, of the sources of the case, and of the runs."""
    texts = [*cell.choices.values(), case_sources(cell.name, registry), *sorted(runs)]
    return hashlib.sha256("\0".join(texts).encode()).hexdigest()[:32]


def run_cell(cell: Cell, registry: Registry, archive: Path | None, report: Callable[[Any], None]) -> CellResult:
    """Run and judge one cell."""
    known = Archive(archive, write=False) if archive is not None and archive.exists() else None
    made: list[StoredRun] = []

    def run(key: str, job: Job, scene: Scene) -> Record:
        record = known.record(key, machine()) if known is not None else None
        if record is None:
            began = process_time()
            record = run_job(job, scene)
            made.append(_stored(key, f"{cell.name} {job.name}", scene, record, process_time() - began))
        return record

    try:
        return replace(_judged(cell, registry, run), made=made)
    finally:
        if known is not None:
            known.__exit__()


def known_cell(cell: Cell, registry: Registry, archive: Path) -> CellResult | None:
    """The cell where all its runs are in the archive, whichever machine they were made on; None where one is not."""

    def run(key: str, job: Job, scene: Scene) -> Record:
        record = known.record(key, None)
        if record is None:
            raise _UnknownRunError
        return record

    with Archive(archive, write=False) as known:
        try:
            return _judged(cell, registry, run)
        except _UnknownRunError:
            return None


class _UnknownRunError(Exception):
    """A run that no archive holds."""


def _judged(cell: Cell, registry: Registry, run: Callable[[str, Job, Scene], Record]) -> CellResult:
    """What came of a cell whose runs come from `run`, which is given their keys as well."""
    case = cell.case(registry)
    why = case.applies(cell.setup)
    if why:
        return CellResult("not-applicable", "", why)
    taken: dict[str, Record] = {}

    def keyed(job: Job, scene: Scene) -> Record:
        key = run_key(job, scene)
        taken[key] = run(key, job, scene)
        return taken[key]

    try:
        _, done = run_case(case, cell.setup, registry, keyed)
        finding = judge(case, cell.setup, done, evaluated(case, cell.setup, done))
    except ContactlabError as error:
        finding = Finding("failed", "failed", str(error), ())
    cpu = sum(float(record.summary.get("cost", {}).get("run_cpu_s", 0.0)) for record in taken.values())
    measures = [_row(j.measure, j.value, j.verdict) for j in finding.judged]
    return CellResult(finding.verdict, finding.status, finding.reason, measures, list(taken), cpu)


def _stored(key: str, name: str, scene: Scene, record: Record, cpu: float) -> StoredRun:
    cost = cpu - float(record.summary.get("cost", {}).get("compile_s", 0.0))
    work = record.summary.get("steps", 0) + record.summary.get("iterations", 0)
    end = (record.status, record.reason, work, cost, to_bytes(record))
    return StoredRun(key, name, scene.toml(), *end, machine())


def _row(measure: Measure, value: float, verdict: str) -> dict[str, Any]:
    return {
        "measure": measure.name, "role": measure.role, "value": value, "least": measure.least, "most": measure.most,
        "unit": measure.unit, "verdict": verdict, "why": measure.why, "order": measure.order,
    }  # fmt: skip
