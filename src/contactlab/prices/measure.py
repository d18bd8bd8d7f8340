"""CPU time and length of one run, as the bill of effects counts them."""

from __future__ import annotations

import math
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

ENDED_AS = "a run to measure it with ended as "


@dataclass(frozen=True)
class Measured:
    """What a run took: CPU time of its steps [s] and memory of its arrays [MiB].

    ended  "" where it came to its end; "cut" where it was stopped after so much work as it was given
    done   the share of its loading that is done then
    """

    length: Length
    cpu_s: float
    arrays_mib: float
    ended: str = ""
    done: float = 1.0


def sample_scene(base: Scene, sample: Sample) -> Scene:
    """The scene of a sample; an explicit one ends after so many steps as it says."""
    scene = base.with_({**sample.changes, "record.frames": sample.frames})
    if not sample.steps:
        return scene
    return scene.with_({"time.end": sample.steps * schedule_of(build(scene, scene.registry), scene).dt})


def measure(scene: Scene, look: Callable[[], float] | None = None, work: float = math.inf) -> Measured:
    """Run a scene once. Raises RequestError where it cannot be run, or does not come to an end.

    look  called at frames; gives the CPU time [s] that it took itself, which does not count
    work  steps and iterations after which the run is cut
    """
    spent = done = 0.0

    def progress(fraction: float, *_: float) -> None:
        nonlocal spent, done
        spent, done = spent + (look() if look is not None else 0.0), fraction

    with TemporaryDirectory() as folder:
        results = simulate(scene, out=Path(folder) / "run", progress=progress, work=work)
    summary, cost = results.summary, results.summary["cost"]
    cut = results.status == "timed-out"
    if not cut and results.status != "finished":
        raise RequestError(f"{ENDED_AS}{results.status}: {results.reason}")
    length = Length(summary["steps"], summary.get("iterations", 0), len(results.history["time"]))
    cpu_s = without_compilation(cost, "run_cpu_s") - spent
    return Measured(length, cpu_s, cost["arrays_mib"], "cut" if cut else "", done if cut else 1.0)
