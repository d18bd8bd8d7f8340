"""The content of `summary.json`."""

from __future__ import annotations

import resource
import sys
from dataclasses import dataclass, field
from time import perf_counter, process_time
from typing import Any

import numpy as np

from contactlab.model.model import Model
from contactlab.results.contact_report import ContactReport
from contactlab.results.frame import Frame

FORMAT = 1


@dataclass
class Clock:
    """Where the time of a run goes [s]."""

    build_s: float = 0.0
    import_s: float = 0.0
    compile_s: float = 0.0
    wall: float = field(default_factory=perf_counter)
    cpu: float = field(default_factory=process_time)
    run_wall_s: float = 0.0
    run_cpu_s: float = 0.0

    def start(self) -> None:
        """The steps begin now."""
        self.wall, self.cpu = perf_counter(), process_time()

    def stop(self) -> None:
        """The steps have ended."""
        self.run_wall_s, self.run_cpu_s = perf_counter() - self.wall, process_time() - self.cpu


@dataclass
class Counts:
    """Work done: accepted steps, Newton iterations, contact sweeps, steps with a contact solve."""

    steps: int = 0
    iterations: int = 0
    sweeps: int = 0


def summarise(
    scene: Any,
    parts: dict[str, str],
    versions: dict[str, str],
    model: Model,
    frame: Frame | None,
    status: str,
    reason: str,
    counts: Counts,
    clock: Clock,
) -> dict[str, Any]:
    """Everything of `summary.json` (docs/scene-format.md)."""
    return {
        "format": FORMAT,
        "scene": scene.name,
        "resolved": model.pace.resolved(),
        "status": status,
        "reason": reason,
        "parts": parts,
        "versions": versions,
        "steps": counts.steps,
        "iterations": counts.iterations,
        "contact_sweeps": counts.sweeps,
        "cost": _cost(model, clock),
        "reactions": {} if frame is None else {on: list(force) for on, force in frame.reactions.items()},
        "reaction_mismatch": reaction_mismatch(model),
        "contacts": {} if frame is None else {name: _contact(c) for name, c in frame.contacts.items()},
        "balance": {} if frame is None else _balance(frame),
    }


def reaction_mismatch(model: Model) -> float:
    """|sum of all support reactions| over the largest of them: zero in statics without loads."""
    reactions = list(model.reactions().values())
    largest = max((float(np.hypot(*force)) for force in reactions), default=0.0)
    if largest == 0.0 or len(reactions) < 2:
        return float("nan")
    return float(np.hypot(*np.sum(reactions, axis=0)) / largest)


def _contact(report: ContactReport) -> dict[str, Any]:
    return {
        "resultant": list(report.resultant),
        "pressure_integral": list(report.pressure_integral),
        "intervals": report.intervals,
        "max_pressure": float(report.curve.pressure.max(initial=0.0)),
        "max_penetration": report.max_penetration,
        "penetrating_side": report.penetrating_side,
        "cone_violation": report.cone_violation,
        "complementarity": report.complementarity,
        "most_negative": report.most_negative,
        "active": report.active,
        "sticking": report.sticking,
    }


def _balance(frame: Frame) -> dict[str, float]:
    e = frame.energies
    stored = e["stored"]
    scale = max(abs(e["kinetic"]) + abs(e["internal"]) + abs(e["external"]), 1e-300)
    return {
        "kinetic": e["kinetic"],
        "stored": stored,
        "internal": e["internal"],
        "plastic": e["plastic"],
        "friction": -e["friction"],
        "external": e["external"],
        "damping": e["damping"],
        "contact": e["contact"],
        "numerical": e["numerical"],
        "ledger_error": e["error"],
        "stored_against_work": abs(e["internal"] - stored - e["plastic"]) / scale,
    }


def _cost(model: Model, clock: Clock) -> dict[str, Any]:
    contact = model.contact.seconds if model.contact is not None else 0.0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return {
        "import_s": clock.import_s,
        "build_s": clock.build_s,
        "compile_s": clock.compile_s,
        "run_wall_s": clock.run_wall_s,
        "run_cpu_s": clock.run_cpu_s,
        "phases": {
            "elements": model.seconds,
            "contact": contact,
            "rest": max(0.0, clock.run_wall_s - model.seconds - contact),
        },
        "peak_memory_mib": peak / 1024.0 if sys.platform != "darwin" else peak / 1048576.0,
    }
