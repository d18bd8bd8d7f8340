"""Cost of a run: times of its phases and of the parts in them, and memory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from time import perf_counter, process_time
from typing import Any

from contactlab.api.compiled.compiler import COMPILATION
from contactlab.api.frame import Layout
from contactlab.model.held_arrays import held_arrays
from contactlab.model.model import Model
from contactlab.model.part_times import contact_times, element_times
from contactlab.results.peak_memory import peak_memory_mib

CORE = "contactlab"
SOUND = ("finished", "not-converged", "interrupted")
"""Ends of a run after which elements can be called again: in the others a part may have raised."""


@dataclass
class Clock:
    """Times of a run by phase [s]; `before` is the cost of the parts of a run that was interrupted.

    `arrays_mib` is the size of the run's arrays, and `elements` the times of elements: to measure all of them costs
    more than to save them, so it is done when the run begins and again at its end (`None` requests it).
    """

    build_s: float = 0.0
    import_s: float = 0.0
    recording_s: float = 0.0
    wall: float = field(default_factory=perf_counter)
    cpu: float = field(default_factory=process_time)
    compiled: float = field(default_factory=lambda: COMPILATION.seconds)
    before: Mapping[str, Any] = field(default_factory=dict)
    arrays_mib: float | None = None
    elements: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    def start(self) -> None:
        """Start the clocks, as the steps begin now."""
        self.wall, self.cpu, self.compiled = perf_counter(), process_time(), COMPILATION.seconds

    @property
    def compile_s(self) -> float:
        """CPU time since `start` that went into kernels of machine code, compiled or loaded."""
        return COMPILATION.seconds - self.compiled

    @property
    def run_wall_s(self) -> float:
        """Wall time since `start`."""
        return perf_counter() - self.wall

    @property
    def run_cpu_s(self) -> float:
        """Processor time since `start`."""
        return process_time() - self.cpu


def cost_of(model: Model, clock: Clock, layout: Layout, status: str) -> dict[str, Any]:
    """The `cost` of `summary.json`; see docs/results-in-paraview-and-python.md."""
    contact = model.contact.seconds if model.contact is not None else 0.0
    wall = clock.run_wall_s
    cost = {
        "import_s": clock.import_s,
        "build_s": clock.build_s,
        "compile_s": clock.compile_s,
        "run_wall_s": wall,
        "run_cpu_s": clock.run_cpu_s,
        "phases": {
            "elements": model.seconds,
            "contact": contact,
            "recording": clock.recording_s,
            "rest": max(0.0, wall - model.seconds - contact - clock.recording_s),
        },
    }
    if clock.arrays_mib is None:
        clock.arrays_mib = sum(array.bytes for array in held_arrays(model)) / 2.0**20
        clock.elements = of_elements(model, layout) if status in SOUND and model.seconds else {}
    parts = {"elements": clock.elements, "contact": of_contact(model, layout)}
    cost["parts"] = {phase: times for phase, times in parts.items() if times}
    return _sum(cost, clock.before) | {
        "peak_memory_mib": max(peak_memory_mib(), clock.before.get("peak_memory_mib", 0.0)),
        "arrays_mib": clock.arrays_mib,
    }


def of_elements(model: Model, layout: Layout) -> dict[str, dict[str, float]]:
    """Seconds in laws, elements and stiffness, by the part's name and distribution."""
    found: dict[str, dict[str, float]] = {}
    times = element_times(model)
    for body in layout.bodies:
        # the law with its distribution, as the layout names it
        known = (text for key, text in layout.parts.items() if key.startswith("materials."))
        law = next((text for text in known if text.partition(" (")[0] == body.material), body.material)
        names = {"law": law, "stiffness": CORE}
        names["element"] = layout.parts.get(f"bodies.{body.name}.element", body.element)
        for what, seconds in times.get(body.name, {}).items():
            of = found.setdefault(what, {})
            of[names[what]] = of.get(names[what], 0.0) + seconds
    return found


def of_contact(model: Model, layout: Layout) -> dict[str, dict[str, float]]:
    """Seconds of search, integration and solution; pairs of different algorithms share the second."""
    if model.contact is None:
        return {}
    algorithms = dict.fromkeys(layout.parts.get(f"{c.name}.algorithm", c.algorithm) for c in layout.contacts)
    usual = model.integrator.default_enforcement
    solvers = dict.fromkeys(layout.parts.get(f"{c.name}.enforcement", usual) for c in layout.contacts)
    names = {"search": CORE, "integration": ", ".join(algorithms), "solution": ", ".join(solvers)}
    return {what: {names[what]: seconds} for what, seconds in contact_times(model.contact).items()}


def _sum(a: Mapping[str, Any], b: Mapping[str, Any]) -> dict[str, Any]:
    """Costs of the parts of an interrupted run add up."""
    return {
        name: _sum(value, b.get(name, {})) if isinstance(value, Mapping) else value + b.get(name, 0.0)
        for name, value in a.items()
    }
