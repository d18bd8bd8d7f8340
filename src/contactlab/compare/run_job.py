"""One run of a comparison, as it happens in a process of its own."""

from __future__ import annotations

import statistics
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from contactlab.api.arrays import Floats
from contactlab.compare.shape import Shape, shapes_of
from contactlab.errors import RequestError
from contactlab.results.results import ContactCurve, Results
from contactlab.scene import Scene

Report = Callable[[Any], None]

# Far below the stable step of any scene and far above round-off in time: enough to call every kernel.
_WARM_UP = {"level": 1, "time.step": 1e-12, "time.end": 4e-12, "time.ramp": 1.0, "record.recorders": []}


@dataclass(frozen=True)
class Outcome:
    """How a run ended and what the comparison needs of it.

    summary    content of `summary.json`, with the median of the costs when the run was repeated
    curve      last curve of the compared contact
    shapes     deformed bodies at the end, by name
    history    columns of `history.csv` by name
    traceback  of what was raised, for authors of parts
    """

    status: str
    reason: str
    summary: dict[str, Any] = field(default_factory=dict)
    curve: ContactCurve | None = None
    shapes: dict[str, Shape] = field(default_factory=dict)
    history: dict[str, Floats] = field(default_factory=dict)
    traceback: str = ""


def run(scene: Scene, folder: Path | None, contact: int, repeat: int, report: Report) -> Outcome:
    """Simulate `scene` into `folder`, `repeat` times; `report` gets (fraction done, step).

    A request that only the model can see to be wrong is an outcome, too: "refused".
    """
    from contactlab.simulation import simulate

    first: Results | None = None
    costs: list[dict[str, Any]] = []
    for number in range(repeat):
        progress = _progress(report, number, repeat)
        try:
            results = simulate(scene, out=folder if number == 0 else None, registry=scene.registry, progress=progress)
        except RequestError as error:
            return Outcome("refused", str(error))
        first = first or results
        costs.append(results.summary.get("cost", {}))
    assert first is not None
    summary = {**first.summary, "cost": {**first.summary.get("cost", {}), **_medians(costs)}}
    curve = _last_curve(first, contact)
    return Outcome(first.status, first.reason, summary, curve, shapes_of(first), first.history)


def warm_up(scene: Scene, report: Report) -> None:
    """A few tiny steps, so that every kernel of the scene is compiled and in the cache on disk."""
    from contactlab.simulation import simulate

    simulate(scene.with_(_WARM_UP), registry=scene.registry)


def _progress(report: Report, number: int, repeat: int) -> Callable[[float, int, float, float], None]:
    def progress(fraction: float, step: int, time: float, energy_error: float) -> None:
        report(((number + fraction) / repeat, step))

    return progress


def _medians(costs: list[dict[str, Any]]) -> dict[str, float]:
    names = ("run_cpu_s", "run_wall_s", "compile_s")
    return {name: statistics.median(cost[name] for cost in costs) for name in names if all(name in c for c in costs)}


def _last_curve(results: Results, contact: int) -> ContactCurve | None:
    history = results.contact.get(f"contacts.{contact}")
    return history.last if history is not None and history.curves else None
