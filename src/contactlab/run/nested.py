"""Scenes whose end does not depend on the loading path: coarse meshes first, each from the last (docs/statics.md).

A load step from rest takes more iterations the finer its mesh is, as contact must find its edge segment by segment.
What a mesh with half of the cells found, interpolated, is right but for a few of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from time import process_time
from typing import Any, cast

from contactlab.api import Estimate, Floats, StepStatus
from contactlab.errors import RequestError, SimulationFailure, one_line
from contactlab.model.build import build
from contactlab.model.implicit_model import ImplicitModel
from contactlab.model.prolongation import Prolongation, pressures
from contactlab.parts.registry import Registry
from contactlab.run.load_steps import LoadSchedule
from contactlab.run.stability import unstable
from contactlab.scene.scene import Scene

FAILURES = 3  # attempts of a coarser level that may fail before it costs more than it saves

Found = dict[float, tuple[Floats, Floats]]
"""Displacement (N, 2) and pressure (r, k) of a solved model by time."""


@dataclass(frozen=True)
class CoarseLevel:
    """Cost of one coarser level; `reason` says why it was not solved, empty if it was."""

    level: int
    nodes: int
    steps: int = 0
    iterations: int = 0
    cpu_s: float = 0.0
    reason: str = ""

    def __str__(self) -> str:
        if self.reason:
            return f"level {self.level} was tried first, not solved: {self.reason}"
        return f"level {self.level} solved first: load steps {self.steps}, iterations {self.iterations}"


def coarser_levels(level: int) -> list[int]:
    """Halves of a level, the coarsest first: 1, 2, 4 before 8."""
    found: list[int] = []
    while level > 1:
        level //= 2
        found.insert(0, level)
    return found


class NestedStart:
    """Solves a scene on coarser levels, and gives the estimated end to the model of the finest level.

    levels   cost of each of them, so far
    solved   whether the last of them was solved: the model's end is then like its end
    stopped  called between steps: whether to give up
    """

    def __init__(self, scene: Scene, registry: Registry, model: ImplicitModel, stopped: Callable[[], bool]) -> None:
        self.scene, self.registry, self.model, self.stopped = scene, registry, model, stopped
        self.levels: list[CoarseLevel] = []
        self.solved = False
        self.integrator = model.integrator.for_coarser_levels() or model.integrator

    def prepare(self) -> None:
        """Fill the model's estimates; they stay empty if the last coarser level found none."""
        coarse, found = None, Found()
        for level in coarser_levels(self.scene.level):
            began = process_time()
            scene = replace(self.scene, level=level)
            try:
                model = cast("ImplicitModel", build(scene, self.registry))
                model.integrator = self.integrator
                _hand_over(coarse, found, model)
                found, steps, iterations = _solved(model, scene, self.stopped)
            except (SimulationFailure, RequestError) as failure:
                self.levels.append(CoarseLevel(level, 0, reason=one_line(failure)))
                coarse, found = None, Found()
                continue
            cost = process_time() - began
            self.levels.append(CoarseLevel(level, len(model.reference), steps, iterations, cost))
            coarse = model
        _hand_over(coarse, found, self.model)
        self.solved = coarse is not None
        if coarse is not None:
            self.model.warnings.add(*unstable(coarse, f" on the mesh of level {self.levels[-1].level}"))

    def summary(self) -> list[dict[str, Any]]:
        """The levels as plain tables; what they cost is part of the run's cost."""
        levels = [vars(level) for level in self.levels]
        return [{name: of[name] for name in of if of[name] != "" and name != "cpu_s"} for of in levels]


def _hand_over(coarse: ImplicitModel | None, found: Found, fine: ImplicitModel) -> None:
    if coarse is None or not found:
        return
    carried = Prolongation(coarse, fine)
    estimates: list[Estimate] = [carried.estimate(time, *values) for time, values in found.items()]
    fine.estimates = estimates


def _solved(model: ImplicitModel, scene: Scene, stopped: Callable[[], bool]) -> tuple[Found, int, int]:
    """States where the loading ends or turns, and the steps and iterations that they took.

    Raises SimulationFailure if the end is not reached.
    """
    schedule = LoadSchedule(model, scene)
    advance = model.bound_integrator().step
    found, count, failures = Found(), 0, 0
    while not schedule.done():
        if stopped():
            raise SimulationFailure("interrupted", "the run was stopped")
        stop = schedule.path.stop(model.state.time)
        step = advance(schedule.dt)
        count += step.iterations
        if step.status is not StepStatus.accepted:
            failures += 1
            said = schedule.cut(step)
            if failures > FAILURES:
                raise SimulationFailure("not-converged", said)
            model.estimates = ()
            continue
        for follow in schedule.every_step:
            follow(step, schedule.dt)
        if schedule.path.stop(model.state.time) > stop or schedule.done():
            found[stop] = (model.state["displacement"].copy(), pressures(model))
    return found, model.state.step, count
