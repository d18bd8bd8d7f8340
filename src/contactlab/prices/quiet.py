"""Runs that are timed while the machine does nothing else.

On a machine that others use, too, or whose cores share their units, the same steps take half as much CPU time again for
tenths of seconds to minutes. A few steps of one model, always the same, tell whether this is such a moment.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from statistics import fmean
from time import perf_counter, process_time, sleep

from contactlab.model.build import build
from contactlab.parts.machine import with_one_blas_thread
from contactlab.parts.registry import Registry
from contactlab.prices.measure import Measured, measure
from contactlab.prices.samples import base_scene
from contactlab.run.prepare import schedule_of
from contactlab.scene.scene import Scene

STEPS, TURNS = 40, 3  # of a look at the machine: about 5 ms
APART = 0.1  # s between looks during a run
WARM = 1000  # steps before the first look
SLOWER = 1.1  # times the fastest look so far: above it the machine is not quiet
PATIENCE, NAP = 5, 0.1  # naps [s] before a run is made all the same
TRIES = 3  # runs, until one lies between two quiet moments


@dataclass(frozen=True)
class Timed:
    """A run and how much slower than ever the machine was meanwhile: its CPU time is divided by that."""

    run: Measured
    slower: float

    def better_than(self, other: Timed) -> bool:
        """Whether it was made in a quieter moment; of two in quiet moments the faster, as others only add."""
        return (self.slower > SLOWER, self.run.cpu_s) < (other.slower > SLOWER, other.run.cpu_s)


class Quiet:
    """Looks at the machine, and times runs in quiet moments."""

    last = 0.0

    def __init__(self, registry: Registry) -> None:
        scene = base_scene(registry)
        model = build(scene, registry)
        self.step, self.dt = model.bound_integrator().step, schedule_of(model, scene).dt
        self.fastest = float("inf")
        for _ in range(WARM):
            self.step(self.dt)
        self.look()

    @with_one_blas_thread
    def look(self) -> float:
        """CPU time of the steps now over that of the fastest look so far."""
        spent = []
        for _ in range(TURNS):
            began = process_time()
            for _ in range(STEPS):
                self.step(self.dt)
            spent.append(process_time() - began)
        now, self.last = sorted(spent)[TURNS // 2], perf_counter()
        self.fastest = min(self.fastest, now)
        return now / self.fastest

    def wait(self) -> float:
        """Wait for a quiet moment, not for long; how much slower than ever it still is."""
        for _ in range(PATIENCE):
            if (slower := self.look()) <= SLOWER:
                return slower
            sleep(NAP)
        return self.look()

    def timed(self, scene: Scene, tries: int = TRIES, work: float = math.inf) -> Timed:
        """Run a scene until a run fell into a quiet moment; the quietest run, at the speed of such a moment.

        work  steps and iterations after which a run is cut. Raises RequestError where it cannot be run.
        """
        made: list[Timed] = []
        for _ in range(tries):
            looks = [self.wait()]
            run = measure(scene, lambda looks=looks: self._now_and_then(looks), work)  # type: ignore[misc]
            looks.append(self.look())
            slower = fmean(looks)
            made.append(Timed(replace(run, cpu_s=run.cpu_s / slower), slower))
            if slower <= SLOWER:
                break
        return min(made, key=lambda one: one.slower)

    def _now_and_then(self, looks: list[float]) -> float:
        """Look, unless that was just done; the CPU time [s] that it took."""
        began = process_time()
        if perf_counter() - self.last > APART:
            looks.append(self.look())
        return process_time() - began
