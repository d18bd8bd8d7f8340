"""CPU time and length of one run, as the bill of effects counts them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from contactlab.errors import RequestError
from contactlab.model.build import build
from contactlab.prices.counts import Length
from contactlab.prices.samples import Sample
from contactlab.run.prepare import schedule_of
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene
from contactlab.studies.measure_run import without_compilation


@dataclass(frozen=True)
class Measured:
    """What a run took: CPU time of its steps [s] and memory of its arrays [MiB]."""

    length: Length
    cpu_s: float
    arrays_mib: float


def sample_scene(base: Scene, sample: Sample) -> Scene:
    """The scene of a sample; an explicit one ends after so many steps as it says."""
    scene = base.with_({**sample.changes, "record.frames": sample.frames})
    if not sample.steps:
        return scene
    return scene.with_({"time.end": sample.steps * schedule_of(build(scene, scene.registry), scene).dt})


def measure(scene: Scene, look: Callable[[], float] | None = None) -> Measured:
    """Run a scene once. Raises RequestError where it cannot be run, or does not come to an end.

    look  called at frames; gives the CPU time [s] that it took itself, which does not count
    """
    spent = 0.0

    def progress(*_: float) -> None:
        nonlocal spent
        spent += look() if look is not None else 0.0

    with TemporaryDirectory() as folder:
        results = simulate(scene, out=Path(folder) / "run", progress=progress)
    summary, cost = results.summary, results.summary["cost"]
    if results.status != "finished":
        raise RequestError(f"a run to measure it with ended as {results.status}: {results.reason}")
    length = Length(summary["steps"], summary.get("iterations", 0), len(results.history["time"]))
    return Measured(length, without_compilation(cost, "run_cpu_s") - spent, cost["arrays_mib"])
