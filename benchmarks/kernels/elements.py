"""Updates per second of explicit steps, by element, law and size, node update and Python included.

Each row is timed beside a yardstick in the same process, in turns: the time that the memory of this machine needs
for the bytes that no scheme can avoid, from a triad. Both seconds and ratios belong to the machine, as the share of
memory in them differs. Times are of the thread (CPU), medians of rounds. `benchmarks/bench.py --only elements`.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from time import thread_time
from typing import Any

os.environ.setdefault("NUMBA_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from numba import njit

from contactlab.model.build import build
from contactlab.model.model import Model
from contactlab.scene.scene import load_scene

Step = Callable[[], Any]

ELASTIC = {"young": 70000.0, "poisson": 0.3, "density": 1e6}  # so heavy that the prescribed flow stays
PLASTIC = {"strength": 348.0, "prestrain": 0.02, "exponent": 0.03}
LAWS: dict[str, dict[str, Any]] = {
    "linear-elastic": ELASTIC,
    "neo-hookean": ELASTIC,
    "hypoelastic": ELASTIC,
    "linear-hardening": {**ELASTIC, "yield_stress": 300.0, "hardening": 500.0},
    "power-law": {**ELASTIC, **PLASTIC},
}
NODES_PER_CELL = {"q2": 3, "q2-lagrange": 4}
STRAIN, INCREMENT = 0.02, 1e-6  # before timing starts, and of every timed step

SCENE = """
format = 1
name = "kernels"
[time]
end = 1e9
step = 1.0
[integrator]
use = "central-difference"
[materials.m]
{material}
[bodies.block]
element = "{element}"
material = "m"
mesh = {{ use = "rectangle", x = [0.0, {columns}.0], y = [0.0, {rows}.0], cells = [{columns}, {rows}] }}
"""


@dataclass
class Row:
    """One measurement: CPU nanoseconds per cell and step (`spread`: of the best and the worst round)."""

    element: str
    law: str
    cells: int
    ns: float
    millions_per_s: float
    spread: tuple[float, float]
    share_of_bound: float


def model_of(element: str, law: str, cells: int) -> Model:
    """A free block in uniform flow, already strained, so that plastic laws yield at every point."""
    columns = round(cells**0.5)
    rows = -(-cells // columns)
    material = "\n".join([f'use = "{law}"', *(f"{key} = {value!r}" for key, value in LAWS[law].items())])
    text = SCENE.format(element=element, material=material, columns=columns, rows=rows)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.toml"
        path.write_text(text)
        scene = load_scene(path)
        model = build(scene, scene.registry)
    rate = np.array([[1.0, 0.3], [-0.2, -0.9]])
    model.state["velocity"][:] = model.reference @ rate.T
    return model


def stepper(model: Model) -> Step:
    """One explicit step of a small strain increment, through the integrator; the first strain is made here."""
    advance = model.bound_integrator().step
    advance(STRAIN)
    return lambda: advance(INCREMENT)


# --- timing --------------------------------------------------------------------------------------


@njit(error_model="numpy", fastmath={"contract"})
def triad(a: Any, b: Any, c: Any) -> None:
    """a = b + s c: 24 bytes an entry."""
    for i in range(a.size):
        a[i] = b[i] + 0.7 * c[i]


def seconds(call: Step, repeats: int) -> float:
    """CPU seconds of one call."""
    began = thread_time()
    for _ in range(repeats):
        call()
    return (thread_time() - began) / repeats


def unavoidable_bytes(element: str, law: str, model: Model) -> int:
    """Bytes per cell and step that come from memory: history in and out, connectivity, 200 for a node's update."""
    body = model.bodies[0]
    return (
        16 * body.points * body.material.history_size + 4 * body.cells.shape[1] + 200 * NODES_PER_CELL.get(element, 1)
    )


def measure(element: str, law: str, cells: int, rounds: int, arrays: tuple[Any, ...]) -> Row:
    """Steps and triads in turns, so that a slow moment of the machine meets both."""
    model = model_of(element, law, cells)
    count = len(model.bodies[0].cells)
    step = stepper(model)
    repeats = max(1, 100_000 // count)
    seconds(step, max(2, repeats // 5))
    steps, triads = [], []
    for _ in range(rounds):
        steps.append(seconds(step, repeats))
        triads.append(seconds(lambda: triad(*arrays), 1) / (24 * arrays[0].size))
    least, ns, largest = (1e9 * of(steps) / count for of in (min, median, max))
    bound = median(triads) * unavoidable_bytes(element, law, model) * 1e9
    return Row(element, law, count, ns, 1e3 / ns, (least, largest), bound / ns)
