"""Announcement of a run before its first step: its end, its steps, their cost, and the key that makes it long."""

from __future__ import annotations

from collections.abc import Callable
from time import thread_time
from typing import TextIO

from contactlab.explanation.estimate import expected_length
from contactlab.run.run import Run
from contactlab.scene.scene import Scene

LONG = 3.0  # times the loading that the program would choose
STEP, NODE, SLAVE, RUBBING = 3e-5, 3.5e-8, 6e-7, 1.5e-6  # s of an explicit step without stresses: each, by node, ...
ITERATION, UNKNOWN = 8e-3, 1.2e-5  # s of an iteration: each, and by node


def announced(stream: TextIO) -> Callable[[Run], None]:
    """A function that prints the `announcement` of a run to a stream."""
    return lambda run: print(announcement(run), file=stream, flush=True)


def announcement(run: Run) -> str:
    """Line on the length of a run that is about to begin, after a line on an integrator that failed before it."""
    scene, timing, steps = run.schedule.scene, run.model.timing, run.schedule.estimated_steps()
    because = f" ({timing.because})" if timing.because else ""
    settles = ", then until it settles" if timing.end is None else ""
    controlled = run.model.integrator.control() is not None
    about = "at least" if controlled and run.model.explicit else "about"
    many = f"{about} {_thousands(steps)} {{}}{'s' * (steps > 1)}"
    before = run.attempts.tried if run.attempts is not None else ()
    line = "".join(f"{attempt.brief}\n" for attempt in before[-1:])
    line += f"{scene.integrator['use']} " if run.attempts is not None else ""
    if run.model.integrator.inertia:
        line += f"simulates {timing.last:.4g} s{because}{settles}: {many.format('step')}"
    else:
        line += f"applies the load in {many.format('increment')}"
    if controlled:
        line += ", whose length follows their error: how many it takes, and their cost, shows on the way"
    elif not run.model.state.step:
        line += f", {_duration(cost_of(run, scene, steps))} of CPU time"
    if timing.end is None and timing.because and timing.last > LONG * timing.ramp:
        fewer = max(1, round(steps * (timing.ramp + timing.period) / timing.last))
        line += (
            f"; {timing.because} makes it long: without it the loading takes {timing.ramp:.3g} s, about "
            f'{_thousands(fewer)} steps; for statics write integrator = "newton"'
        )
    return line


def cost_of(run: Run, scene: Scene, steps: int) -> float:
    """CPU time of all steps [s], within a factor of two or three."""
    model, nodes = run.model, len(run.model.reference)
    if not model.explicit:
        iterations = expected_length(scene, model, run.schedule).usual.iterations
        return iterations * (ITERATION + UNKNOWN * nodes)
    slave = SLAVE + (RUBBING if any(contact.friction for contact in scene.contacts) else 0.0)
    slaves = sum(len(pair.slave.nodes) for pair in model.contact.pairs) if model.contact is not None else 0
    # CPU time [s] of the stresses of the undeformed bodies
    seconds, found = model.seconds, []
    for _ in range(3):
        began = thread_time()
        model.internal_force(0.0)
        found.append(thread_time() - began)
    model.seconds = seconds
    stresses = min(found)
    return steps * (stresses + STEP + NODE * nodes + slave * slaves)


def _thousands(count: int) -> str:
    return f"{count:,}".replace(",", " ")


def _duration(value: float) -> str:
    """A rough time in words."""
    for unit, size in (("days", 86400.0), ("hours", 3600.0), ("minutes", 60.0)):
        if value >= 2.0 * size:
            return f"roughly {value / size:.2g} {unit}"
    return f"roughly {float(f'{value:.2g}'):g} s" if value >= 1.0 else "less than 1 s"
