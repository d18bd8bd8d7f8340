"""One run of a comparison, as it happens in a process of its own."""

from __future__ import annotations

import json
import shutil
import statistics
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from contactlab.api.arrays import Floats
from contactlab.errors import RequestError
from contactlab.results.result_file import FILE
from contactlab.results.results import ContactCurve, Results
from contactlab.scene.scene import Scene
from contactlab.studies.call import Report
from contactlab.studies.shape import Shape, shapes_of
from contactlab.studies.system import machine, system_facts
from contactlab.studies.worker import BEGUN

COSTS = "costs.json"
"""In the folder of a run: the cost of each repetition."""

# Far below the stable step of any scene and far above round-off in time: enough to call every kernel.
_WARM_UP = {"level": 1, "time.step": 1e-12, "time.end": 4e-12, "time.ramp": 1.0}

_ready: set[frozenset[str]] = set()
"""Compositions of scenes that this process has imported and loaded all for."""


@dataclass(frozen=True)
class Outcome:
    """How a run ended and what the comparison needs of it.

    summary    content of `summary.json`, with the median of the costs when the run was repeated
    curve      last curve of the compared contact
    shapes     deformed bodies at the end, by name
    history    columns of `history.csv` by name
    traceback  of what was raised, for authors of parts
    system     facts about the machine that made it
    machine    its name
    """

    status: str
    reason: str
    summary: dict[str, Any] = field(default_factory=dict)
    curve: ContactCurve | None = None
    shapes: dict[str, Shape] = field(default_factory=dict)
    history: dict[str, Floats] = field(default_factory=dict)
    traceback: str = ""
    system: dict[str, str | int] = field(default_factory=system_facts)
    machine: str = field(default_factory=machine)


def run(scene: Scene, folder: Path | None, contact: int, repeat: int, report: Report) -> Outcome:
    """Simulate `scene` into `folder`, `repeat` times; `report` gets (fraction done, step).

    A run that was stopped there goes on, and one that is over is read back; one without results to go on
    from (nothing was recorded, or the files were not kept) is made anew.
    A request that only the model can see to be wrong is an outcome, too: "refused"; so is a run that was stopped.
    """
    from contactlab.run.interruption import Interrupted
    from contactlab.run.simulation import simulate

    def once(number: int, place: Path | None) -> Results:
        begun = place is not None and place.exists()
        if place is not None and begun and not (place / FILE).is_file():
            begun = False
            shutil.rmtree(place)
        progress = _progress(report, number, repeat)
        return simulate(scene, out=place, registry=scene.registry, progress=progress, resume=begun)

    if folder is None or not folder.exists():
        be_ready(scene)
    report(BEGUN)
    try:
        first = once(0, folder)
        costs = costs_in(folder, first)
        for number in range(len(costs), repeat):
            costs.append(once(number, None).summary.get("cost", {}))
            if folder is not None:
                (folder / COSTS).write_text(json.dumps(costs), encoding="utf-8")
    except RequestError as error:
        return Outcome("refused", str(error))
    except Interrupted as stop:
        return outcome_of(stop.results, contact, [stop.results.summary.get("cost", {})])
    return outcome_of(first, contact, costs)


def costs_in(folder: Path | None, results: Results) -> list[dict[str, Any]]:
    """What every repetition of a run cost that was made so far, the one that left `results` first."""
    if folder is not None and (folder / COSTS).is_file():
        found: list[dict[str, Any]] = json.loads((folder / COSTS).read_text(encoding="utf-8"))
        return found
    return [results.summary.get("cost", {})]


def outcome_of(results: Results, contact: int, costs: Sequence[Mapping[str, Any]]) -> Outcome:
    """What a comparison needs of a run that was made as often as there are `costs`."""
    summary = {**results.summary, "cost": {**results.summary.get("cost", {}), **_medians(costs)}}
    curve = _last_curve(results, contact)
    return Outcome(results.status, results.reason, summary, curve, shapes_of(results), results.history)


def warm_up(scene: Scene, report: Report) -> None:
    """A few tiny steps, so that every kernel of the scene is compiled and in the cache on disk; tells which one."""
    from contactlab.run.compiling import compilation_told
    from contactlab.run.simulation import simulate

    with TemporaryDirectory() as folder, compilation_told(scene, report):
        simulate(scene.with_(_WARM_UP), out=Path(folder) / "run", registry=scene.registry)
    _ready.add(composition(scene))


def be_ready(scene: Scene) -> None:
    """What the first run of a process pays for all that follow (imports, loading of kernels) is no cost of this one."""
    if composition(scene) not in _ready:
        _ready.add(composition(scene))
        with suppress(Exception):  # what is wrong is wrong in the run itself, and told there
            warm_up(scene, lambda message: None)


def composition(scene: Scene) -> frozenset[str]:
    """Names of all parts: what decides which kernels are called and what is imported."""
    return frozenset(_names(scene.data))


def _names(data: Any) -> Iterator[str]:
    if isinstance(data, Mapping):
        if "use" in data:
            yield str(data["use"])
        data = list(data.values())
    if isinstance(data, list | tuple):
        for item in data:
            yield from _names(item)


def _progress(report: Report, number: int, repeat: int) -> Callable[[float, int, float, float], None]:
    def progress(fraction: float, step: int, time: float, energy_error: float) -> None:
        report(((number + fraction) / repeat, step))

    return progress


def _medians(costs: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    names = ("run_cpu_s", "run_wall_s", "compile_s")
    return {name: statistics.median(cost[name] for cost in costs) for name in names if all(name in c for c in costs)}


def _last_curve(results: Results, contact: int) -> ContactCurve | None:
    history = results.contact.get(f"contacts.{contact}")
    return history.last if history is not None and history.curves else None
