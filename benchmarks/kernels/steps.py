"""What an explicit step costs, phase by phase, from 200 to 200 000 cells; contact from 100 to 10 000 slave nodes;
start-up and memory.

Two blocks are pressed onto each other between their outer edges, every slave node active. Phases are timed with the
clock of the thread, in rounds, and the median round counts: seconds belong to this machine, ratios and
exponents to the program. `benchmarks/bench.py --only steps`.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from statistics import median
from time import perf_counter, thread_time
from typing import Any

os.environ.setdefault("NUMBA_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from contactlab.model.build import build
from contactlab.model.held_arrays import held_arrays
from contactlab.model.model import Model
from contactlab.scene.scene import Scene

ELASTIC = {"use": "neo-hookean", "young": 7000.0, "poisson": 0.3, "density": 2.7e-9}
PLASTIC = {"use": "power-law", **{k: v for k, v in ELASTIC.items() if k != "use"}, "strength": 348.0, "prestrain": 0.02,
           "exponent": 0.03}  # fmt: skip
ALGORITHMS = ("node-on-segment", "mortar-p0", "mortar-p1")
CELLS = (200, 1_000, 5_000, 20_000, 200_000)
NODES = (100, 300, 1_000, 3_000, 10_000)
SQUEEZE = 1e-3  # of the height: the blocks stay pressed onto each other
CROSSING = 5e-7  # s/mm: time that sound needs for a cell of one millimetre; they are pressed within 20 cells' time
ROUND = 0.05  # seconds of a round, at least


def blocks(columns: int, rows: int, algorithm: str | None, law: dict[str, Any] = ELASTIC, element: str = "q1") -> Scene:
    """Two equal blocks of columns x rows cells; the upper one is narrower by a cell, so that no two nodes meet."""
    width, height = 1.0, rows / columns
    shrink = 0.5 / columns

    def body(low: float, x: list[float]) -> dict[str, Any]:
        mesh = {"use": "rectangle", "x": x, "y": [low, low + height], "cells": [columns, rows]}
        return {"element": element, "material": "m", "mesh": mesh}

    down = {"ramp": "linear", "to": -SQUEEZE * height, "duration": 20.0 * CROSSING / columns}
    contact = {"slave": "upper.bottom", "master": "lower.top", "algorithm": algorithm}
    return Scene.from_data(
        {
            "time": {"end": 1.0, "damping": 0.1 * columns / CROSSING},
            "integrator": "central-difference",
            "materials": {"m": law},
            "bodies": {"lower": body(0.0, [0.0, width]), "upper": body(height, [shrink, width - shrink])},
            "supports": [{"on": "lower.bottom", "ux": 0.0, "uy": 0.0}, {"on": "upper.top", "ux": 0.0, "uy": down}],
            "contacts": [contact] if algorithm else [],
        }
    )


class Clock:
    """CPU seconds of the phases of a model's step, by wrapping the two calls that the integrator makes."""

    def __init__(self, model: Model) -> None:
        self.spent = {"elements": 0.0, "contact": 0.0}
        model.internal_force = self.timed("elements", model.internal_force)  # type: ignore[method-assign]
        if model.contact is not None:
            model.contact.solve = self.timed("contact", model.contact.solve)  # type: ignore[method-assign]

    def timed(self, phase: str, call: Callable[..., Any]) -> Callable[..., Any]:
        """The call, its seconds booked under the phase."""

        def timed(*arguments: Any) -> Any:
            began = thread_time()
            done = call(*arguments)
            self.spent[phase] += thread_time() - began
            return done

        return timed


def measure(scene: Scene, rounds: int, warm: int = 100) -> dict[str, float]:
    """CPU microseconds of a step by phase, medians of rounds, with the best and the worst; sweeps, active nodes."""
    model = build(scene, scene.registry)
    dt = 0.9 * model.stable_step()
    clock = Clock(model)
    advance = model.bound_integrator().step
    began = perf_counter()
    for _ in range(warm):
        advance(dt)
    number = max(3, int(ROUND / max(1e-9, (perf_counter() - began) / warm)))
    found: list[dict[str, float]] = []
    for _ in range(rounds):
        clock.spent.update(elements=0.0, contact=0.0)
        start, sweeps = thread_time(), 0
        for _ in range(number):
            sweeps += advance(dt).sweeps
        whole = thread_time() - start
        row = {"whole": whole, **clock.spent, "rest": whole - sum(clock.spent.values())}
        found.append({name: 1e6 * seconds / number for name, seconds in row.items()} | {"sweeps": sweeps / number})
    middle = {name: median(row[name] for row in found) for name in found[0]}
    active = int(np.count_nonzero(model.state["multipliers"][0])) if model.contact is not None else 0
    spread = {"least": min(row["whole"] for row in found), "largest": max(row["whole"] for row in found)}
    return middle | spread | {"cells": sum(len(body.cells) for body in model.bodies), "active": active}


def phases(sizes: Sequence[int], rounds: int) -> list[dict[str, float]]:
    """Cost of a step by phase for blocks six times as wide as high, as in disc-on-block."""
    rows = []
    for cells in sizes:
        height = max(1, round((cells / 12.0) ** 0.5))
        rows.append(measure(blocks(6 * height, height, "mortar-p0"), rounds, warm=100 + 2 * height))
        print("  {cells:8.0f} cells: {whole:10.1f} us, elements {elements:.1f}, contact {contact:.1f}, rest {rest:.1f}"
              .format(**rows[-1]), flush=True)  # fmt: skip
    return rows


def contacts(nodes: Sequence[int], rounds: int) -> list[dict[str, Any]]:
    """Cost of contact for blocks of one layer of cells: as many active slave nodes as columns."""
    rows = []
    for algorithm in ALGORITHMS:
        for count in nodes:
            found = measure(blocks(count - 1, 1, algorithm), rounds)
            rows.append({"algorithm": algorithm, "nodes": count, **found})
            spent, sweeps, active = (found[name] for name in ("contact", "sweeps", "active"))
            print(
                f"  {algorithm:16s} {count:6d} nodes: {spent:9.1f} us, {sweeps:.1f} sweeps, {active} active", flush=True
            )
    return rows


def exponent(x: Sequence[float], y: Sequence[float]) -> float:
    """Slope of log y over log x by least squares."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def exponents(by_cells: Sequence[dict[str, float]], by_nodes: Sequence[dict[str, Any]]) -> dict[str, float]:
    """How cost grows: of contact with its nodes, by algorithm, and of elements with their number."""
    slopes = {}
    for name in ALGORITHMS:
        rows = [row for row in by_nodes if row["algorithm"] == name]
        slopes[name] = exponent([row["nodes"] for row in rows], [row["contact"] for row in rows])
    return slopes | {
        "elements": exponent([row["cells"] for row in by_cells[1:]], [r["elements"] for r in by_cells[1:]])
    }


def overhead(rounds: int) -> dict[str, float]:
    """A step of the smallest model, whose kernels have next to nothing to do, beside a call of a Python method."""
    smallest = measure(blocks(2, 1, "mortar-p0"), rounds)
    return {"step_us": smallest["whole"], "without_contact_us": measure(blocks(2, 1, None), rounds)["whole"],
            "python_call_us": _python_call()}  # fmt: skip


class _Callee:
    def method(self, argument: float) -> float:
        """Nothing much."""
        return argument


def _python_call() -> float:
    """CPU microseconds of a method call, the best of several tries."""
    bound, tries = _Callee().method, []
    for _ in range(7):
        began = thread_time()
        for _ in range(200_000):
            bound(1.0)
        tries.append((thread_time() - began) / 0.2)
    return min(tries)


def memory() -> list[dict[str, Any]]:
    """Bytes per cell of a model, integrator included; and per slave node of a contact."""
    rows = []
    for element, law, name in (("q1", ELASTIC, "elastic"), ("q1", PLASTIC, "power law"), ("q2", ELASTIC, "elastic")):
        free, pressed = (_held(blocks(60, 60, algorithm, law, element)) for algorithm in (None, "mortar-p0"))
        row = {
            "element": element,
            "law": name,
            "bytes_per_cell": free / 7200,
            "bytes_per_slave_node": (pressed - free) / 61,
        }
        rows.append(row)
    return rows


def _held(scene: Scene) -> int:
    model = build(scene, scene.registry)
    dt = 0.9 * model.stable_step()
    advance = model.bound_integrator().step
    advance(dt)
    return sum(array.bytes for array in held_arrays(model, integrator=advance))


FIRST_STEP = """
import time; began = time.process_time()
from contactlab.scene.scene import load_scene
from contactlab.explanation.trial_run import _trial_of
_trial_of(lambda: load_scene("disc-on-block"))
print(time.process_time() - began)
"""


def start_up(rounds: int) -> dict[str, float]:
    """CPU seconds of fresh processes; the best of several tries, since the first reads everything from disk."""
    programs = {"python": "pass", "numpy": "import numpy", "contactlab": "import contactlab", "first_step": FIRST_STEP}
    return {name: min(_cpu(program) for _ in range(rounds)) for name, program in programs.items()}


def _cpu(program: str) -> float:
    before = os.times()
    subprocess.run([sys.executable, "-c", program], check=True, capture_output=True)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system
