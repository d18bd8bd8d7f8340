"""What a run really does: started in a process of its own, with every call of a part counted.

Reads a scene and a number of steps as JSON from standard input, runs it until then, and prints what was
called, imported and allocated.
"""

from __future__ import annotations

import functools
import gc
import hashlib
import json
import os
import signal
import sys
import tracemalloc
from collections import Counter
from collections.abc import Callable
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

METHODS = {
    "material": {"stress": "material stress"},
    "contact": {"pieces": "contact pieces", "normals": "contact normals", "conditions": "contact conditions"},
    "enforcement": {
        "solve": "contact enforcement",
        "respond": "contact enforcement",
    },
}
KERNELS = {"gradient": "element gradient", "force": "element force", "stabilise": "element stabilisation"}
WATCHED = (10, 40)  # steps between which kernels are counted: no look of the guards and no frame lies there


class Trace:
    """Counts calls made inside steps; stops the run after the wished number of them."""

    def __init__(self, steps: int, kernels: Counter[str]) -> None:
        self.last, self.kernels = steps, kernels
        self.calls: Counter[str] = Counter()
        self.forget()

    def forget(self) -> None:
        """Count from zero on, as a new run begins."""
        self.calls.clear()
        self.kernels.clear()
        self.at: dict[int, Counter[str]] = {}
        self.steps, self.inside, self.bytes = 0, False, 0

    def counted(self, name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(function)
        def call(*arguments: Any, **named: Any) -> Any:
            self.calls[name] += self.inside
            return function(*arguments, **named)

        return call

    def stepping(self, advance: Callable[[float], Any]) -> Callable[[float], Any]:
        def step(dt: float) -> Any:
            self.inside, self.calls["integrator"] = True, self.calls["integrator"] + 1
            done = advance(dt)
            self.inside, self.steps = False, self.steps + 1
            if self.steps in WATCHED:
                self.at[self.steps] = Counter(self.kernels)
            if self.steps == self.last:
                if tracemalloc.is_tracing():
                    self.bytes = allocated()
                os.kill(os.getpid(), signal.SIGINT)  # the run ends in order after this step
            return done

        return step


def allocated() -> int:
    """Bytes of all NumPy arrays that are alive, but for constants of the compiler."""
    filters = [tracemalloc.DomainFilter(True, np.lib.tracemalloc_domain), tracemalloc.Filter(False, "*/numba/*")]
    return sum(trace.size for trace in tracemalloc.take_snapshot().filter_traces(filters).traces)


def trace_parts(trace: Trace) -> None:
    """Wrap the parts as they are made, before anything binds them."""
    from contactlab.model import model
    from contactlab.model.bodies import body
    from contactlab.parts.registry import Registry

    make, kernels, external = Registry.make, body.element_kernels, model.Model.external_force
    seen: set[type] = set()

    def traced_make(self: Any, kind: str, spec: Any, where: Any = "") -> Any:
        part = make(self, kind, spec, where)
        if type(part) not in seen:
            seen.add(type(part))
            wrap(type(part), kind)
        return part

    def wrap(cls: type, kind: str) -> None:
        for method, name in METHODS.get(kind, {}).items():
            if hasattr(cls, method):
                setattr(cls, method, trace.counted(name, getattr(cls, method)))
        if kind == "integrator":
            bind = cls.bind  # type: ignore[attr-defined]
            cls.bind = lambda self, equations, state: trace.stepping(bind(self, equations, state))  # type: ignore[attr-defined]

    def traced_kernels(element: Any, kinematics: Any) -> Any:
        found = kernels(element, kinematics)
        own = {field: getattr(found, field) for field in KERNELS}
        return found._replace(**{f: trace.counted(KERNELS[f], call) for f, call in own.items() if call is not None})

    def traced_external(self: Any, time: float, out: Any) -> bool:
        trace.calls["loads and effects"] += trace.inside * len(self.loading.loads)
        return external(self, time, out)

    Registry.make, body.element_kernels = traced_make, traced_kernels  # type: ignore[method-assign]
    model.Model.external_force = traced_external  # type: ignore[method-assign]
    body.midpoint = trace.counted("increment to midpoint", body.midpoint)


def run(data: dict[str, Any]) -> Any:
    """Results of a scene that is stopped by the trace."""
    from contactlab.run.interruption import Interrupted
    from contactlab.run.simulation import simulate
    from contactlab.scene.scene import Scene

    with TemporaryDirectory() as folder:
        try:
            return simulate(Scene.from_data(data), out=folder)
        except Interrupted as stopped:
            return stopped.results


def forget_tables() -> None:
    """Let the next run allocate its tables: it would take those of a run that is over."""
    from contactlab.api.compiled import bound_arrays

    gc.collect()
    bound_arrays._FREE.clear()


def main() -> None:
    wish = json.load(sys.stdin)
    from contactlab.explanation.trial_run import count_kernel_calls, imported_modules

    kernels = count_kernel_calls()
    trace = Trace(wish["steps"], kernels.calls)
    trace_parts(trace)
    if wish["arrays"]:
        # once before: kernels are loaded three times as slowly while allocations are traced
        run(wish["scene"])
        trace.forget()
        forget_tables()
        tracemalloc.start()
    results = run(wish["scene"])
    first, last = WATCHED
    per_step = {}
    if last in trace.at:
        per_step = {name: (trace.at[last][name] - trace.at[first][name]) / (last - first) for name in trace.at[last]}
    digest = hashlib.sha256()
    for array in (results.displacement, results.velocity, *results.stress.values()):
        digest.update(np.ascontiguousarray(array))
    found = {
        "status": results.status,
        "reason": results.reason,
        "steps": trace.steps,
        "calls": trace.calls,
        "kernels": list(kernels.calls),
        "per_step": per_step,
        "modules": imported_modules(),
        "bytes": trace.bytes,
        "digest": digest.hexdigest(),
    }
    print(json.dumps(found))


if __name__ == "__main__":
    main()
