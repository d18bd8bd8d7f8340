"""A run as the driver takes it: a job with its scene resolved, and how it is to be made."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from contactlab.api import Job, Record
from contactlab.jobs.keys import run_key
from contactlab.scene.scene import Scene

Plan = Generator[Sequence[Any], Sequence[Any], Any]
"""Generator of runs and further plans, which is sent their records and results in order and returns its own result."""


def always() -> str:
    """Let a run begin."""
    return ""


@dataclass(frozen=True)
class Run:
    """Run that a plan requests.

    name       shown while it runs, and kept in the archive
    place      its results folder below the folder of the command; "" for a run without files
    proof      a file in it without which the record of the archive does not serve
    number     0, or the number of a repetition, which is a run of its own
    timed      its cost counts: all that it calls is loaded before, and a fixed piece of work is timed with it
    cpu_limit  CPU time after which it is stopped [s]
    rank       runs that are waiting begin in this order
    unless     called when it could begin; a string is the reason why it does not: status "not-run"
    """

    job: Job
    scene: Scene
    name: str
    place: str = ""
    proof: str = ""
    number: int = 0
    timed: bool = False
    cpu_limit: float = math.inf
    rank: tuple[float, ...] = ()
    unless: Callable[[], str] = field(default=always, compare=False)

    @cached_property
    def key(self) -> str:
        """Identity of the run: scene, files, sources, what is kept, repetition."""
        return run_key(self.job, self.scene) + (f"-{self.number}" if self.number else "")

    @property
    def identity(self) -> tuple[str, str]:
        """Two runs that agree in it are made once."""
        return self.key, self.place

    @property
    def limit_key(self) -> str:
        """Key of the archive's record that the CPU time was not enough."""
        return f"{self.key}@{self.cpu_limit:g}"

    @cached_property
    def composition(self) -> frozenset[str]:
        """Names of all parts: what decides which kernels are called and what is imported."""
        return frozenset(_names(self.scene.data))


def _names(data: Any) -> Iterator[str]:
    if isinstance(data, Mapping):
        if "use" in data:
            yield str(data["use"])
        data = list(data.values())
    if isinstance(data, list | tuple):
        for item in data:
            yield from _names(item)


def here(plan: Plan, make: Callable[[Run], Record]) -> Any:
    """Carry out a plan in this process, one run after another."""
    answers: Sequence[Any] = ()
    try:
        asked = next(plan)
        while True:
            answers = [here(one, make) if isinstance(one, Generator) else make(one) for one in asked]
            asked = plan.send(answers)
    except StopIteration as end:
        return end.value
