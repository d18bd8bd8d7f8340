"""Cell of a matrix: the plan of its runs, and its verdict."""

from __future__ import annotations

import hashlib
import traceback
from collections.abc import Generator, Sequence
from dataclasses import dataclass, field
from math import isfinite
from typing import Any

from contactlab.api import Job, Measure
from contactlab.cases.run_case import case_plan, declined, evaluated, unfit
from contactlab.cases.verdict import Finding, judge
from contactlab.errors import ContactlabError
from contactlab.jobs.archive import Archive
from contactlab.jobs.keys import case_sources
from contactlab.jobs.run import Run
from contactlab.jobs.system import machine
from contactlab.parts.registry import Registry
from contactlab.scene.scene import Scene
from contactlab.verdicts.plan import Cell


@dataclass
class CellResult:
    """Result of a cell: its verdict, the measures with their verdicts, and the keys of its runs.

    whole  False if it was interrupted, so that the verdict is void
    """

    verdict: str
    status: str
    reason: str
    measures: list[dict[str, Any]] = field(default_factory=list)
    runs: list[str] = field(default_factory=list)
    cpu_s: float = 0.0
    machine: str = field(default_factory=machine)
    whole: bool = True

    @property
    def number(self) -> str:
        """Value and unit of the first measure with the verdict of the cell, errors first; empty without one."""
        known = [m for m in self.measures if m["value"] is not None and isfinite(m["value"])]
        same = [m for m in known if m["verdict"] == self.verdict]
        first = min(same, key=lambda m: m["role"] != "error", default=None)
        return "" if first is None else f"{first['value']:.2g} {first['unit']}".strip()

    def as_data(self) -> dict[str, Any]:
        """Columns of a table: without the machine."""
        return {name: value for name, value in vars(self).items() if name not in ("machine", "whole")}


def cell_plan(cell: Cell, registry: Registry) -> Generator[Sequence[Run], Sequence[Any], CellResult]:
    """Run and judge one cell."""
    keys: list[str] = []

    def asked(job: Job, scene: Scene) -> Run:
        run = Run(job, scene, f"{cell.name} {job.name}")
        keys.append(run.key)
        return run

    try:
        case = cell.case(registry)
        why = unfit(case, cell.setup, registry)
        if why:
            return CellResult("not-applicable", "", why)
        _, done = yield from case_plan(case, cell.setup, registry, asked)
        if any(record.status == "interrupted" for record in done.values()):
            return CellResult("not-judged", "interrupted", "stopped before it ended", whole=False)
        if why := declined(cell.setup, done):
            return CellResult("not-applicable", "", why)
        finding = judge(case, cell.setup, done, evaluated(case, cell.setup, done))
    except ContactlabError as error:
        finding, done = Finding("failed", "failed", str(error), ()), {}
    except Exception as error:  # the case raised
        told = f"{type(error).__name__}: {error}\n{traceback.format_exc()}"
        finding, done = Finding("failed", "failed", told, ()), {}
    cpu = sum(float(record.summary.get("cost", {}).get("run_cpu_s", 0.0)) for record in done.values())
    measures = [_row(j.measure, j.value, j.verdict) for j in finding.judged]
    at = next((record.summary["machine"] for record in done.values() if "machine" in record.summary), machine())
    return CellResult(finding.verdict, finding.status, finding.reason, measures, keys, cpu, at)


def keep(archive: Archive | None, cell: Cell, result: CellResult, registry: Registry) -> None:
    """Put a cell into the archive."""
    if archive is not None and result.whole:
        # hash of the choices, of the sources of the case, and of the runs
        texts = [*cell.choices.values(), case_sources(cell.name, registry), *sorted(result.runs)]
        key = hashlib.sha256("\0".join(texts).encode()).hexdigest()[:32]
        archive.add_cell(key, result.machine, cell.choices, result.as_data())


def _row(measure: Measure, value: float, verdict: str) -> dict[str, Any]:
    return {
        "measure": measure.name, "role": measure.role, "value": value, "least": measure.least, "most": measure.most,
        "unit": measure.unit, "verdict": verdict, "why": measure.why, "order": measure.order,
    }  # fmt: skip
