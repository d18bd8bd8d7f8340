"""Another name for the installed cases: each as a function of the name of an algorithm, which gives figures.

    from contactlab.testing.cases import CASES
    for figure in CASES["spinning pair"]("my-algorithm", False): ...

`full` asks for the next level. Raises SimulationFailure where a run does not come to its end. What cases are stands in
`contactlab.api.case`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from contactlab.api import Setup
from contactlab.cases.run_case import evaluated, run_case
from contactlab.errors import SimulationFailure
from contactlab.parts.registry import default_registry
from contactlab.testing.cases.figures import Figure

Case = Callable[[str, bool], list[Figure]]

__all__ = ["CASES", "Case", "Figure"]


def _figures(name: str) -> Case:
    def run(algorithm: str, full: bool) -> list[Figure]:
        case = default_registry().make("case", name)
        setup = Setup(algorithm, False, case.elements[0], case.integrators[0], 2 if full else 1)
        _, done = run_case(case, setup)
        for record in done.values():
            if not record.finished:
                raise SimulationFailure(record.status, record.reason)
        values = evaluated(case, setup, done)
        return [
            Figure(f"{m.name} [{m.unit}]" if m.unit else m.name, values.get(m.name, float("nan")), m.least, m.most)
            for m in case.measures(setup)
        ]

    return run


def __getattr__(name: str) -> Any:
    """`CASES` by title, found when it is asked for: cases are imported then."""
    if name != "CASES":
        raise AttributeError(name)
    registry = default_registry()
    return {registry.part_class("case", n).title: _figures(n) for n in registry.names("case")}
