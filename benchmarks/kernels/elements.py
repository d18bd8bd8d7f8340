"""Updates per second of explicit steps, by element, law and size, node update and Python included.

Each row is timed beside two yardsticks in the same process, in turns: a fused scalar loop written by hand
for that law (`fused_loops.py`) or element (`fused_elements.py`, neo-Hookean), which must give the same
forces, and the time that the memory of this machine needs for the bytes that no scheme can avoid, from a
triad. Both seconds and ratios belong to the machine, as the share of memory in them differs. Times are of the
thread (CPU), medians of rounds.

    python benchmarks/kernels/elements.py                              # bilinear, all laws, 1k to 1M cells
    python benchmarks/kernels/elements.py --elements q2 --sizes 10000 --laws neo-hookean
"""

from __future__ import annotations

import argparse
import json
import os
import tempfile
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median
from time import thread_time
from typing import Any

os.environ.setdefault("NUMBA_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import fused_elements
import fused_loops as loops
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
    """One measurement: CPU nanoseconds per cell and step (`spread`: of the best and the worst round), and ratios."""

    element: str
    law: str
    cells: int
    ns: float
    millions_per_s: float
    spread: tuple[float, float]
    over_fused: float | None
    over_rate_loop: float | None
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


def fused_call(model: Model, law: str, rate_loop: bool = False) -> Callable[[float], None] | None:
    """The hand-written loop in place of the model's block calls."""
    cells, force = model.bodies[0].cells, model.state["internal_force"]
    young, poisson = ELASTIC["young"], ELASTIC["poisson"]
    shear = young / (2.0 * (1.0 + poisson))
    lame = 2.0 * shear * poisson / (1.0 - 2.0 * poisson)
    x, reference, u = model.position, model.reference, model.state["displacement"]
    power = tuple(PLASTIC.values())
    if rate_loop:
        if law != "power-law":
            return None
        # the increment of the flow itself: this loop has no model that would give it
        du, history = np.ascontiguousarray(INCREMENT * model.state["velocity"]), np.zeros((len(cells), 4, 5))
        loops.power_law_rate(x, STRAIN / INCREMENT * du, cells, force, history, lame, shear, *power)
        return lambda dt: loops.power_law_rate(x, du, cells, force, history, lame, shear, *power)
    if law == "linear-elastic":
        return lambda dt: loops.linear_elastic(reference, u, cells, force, lame, shear)
    if law == "neo-hookean":
        return lambda dt: loops.neo_hookean(x, reference, cells, force, lame, shear)
    if law == "hypoelastic":
        history = np.zeros((len(cells), 4, 4))
        return lambda dt: loops.hypoelastic(x, model.increment, cells, force, history, lame, shear)
    history, bulk = np.zeros((len(cells), 4, 4)), lame + 2.0 / 3.0 * shear
    if law == "power-law":
        return lambda dt: loops.power_law(x, reference, cells, force, history, bulk, shear, *power)
    if law == "linear-hardening":
        flow = LAWS[law]["yield_stress"], LAWS[law]["hardening"]
        return lambda dt: loops.linear_hardening(x, reference, cells, force, history, bulk, shear, *flow)
    return None


def fused_element(model: Model) -> Callable[[float], None]:
    """The same for elements other than the bilinear one with 2x2 points, neo-Hookean."""
    element, cells, force = model.bodies[0].element, model.bodies[0].cells, model.state["internal_force"]
    law = model.bodies[0].material
    shear = law.young / (2.0 * (1.0 + law.poisson))
    lame = 2.0 * shear * law.poisson / (1.0 - 2.0 * law.poisson)
    x, reference, u = model.position, model.reference, model.state["displacement"]
    if model.bodies[0].points == 1:
        modulus = element.hourglass * shear
        return lambda dt: fused_elements.q1_reduced(x, reference, u, cells, force, lame, shear, modulus)
    if len(element.nodes) == 4:
        return lambda dt: fused_elements.q1_fbar(x, reference, cells, force, lame, shear)
    rule = element.quadrature()
    derivatives, weights = element.shape(rule.points).gradient, rule.weights
    return lambda dt: fused_elements.by_table(x, reference, cells, force, lame, shear, derivatives, weights)


def loop_for(model: Model, element: str, law: str, rate_loop: bool = False) -> Callable[[float], None] | None:
    """The loop that somebody wrote by hand for this element and law, if anybody did."""
    if element == "q1":
        return fused_call(model, law, rate_loop)
    return fused_element(model) if law == "neo-hookean" and not rate_loop else None


def fused_stepper(element: str, law: str, cells: int, rate_loop: bool = False) -> Step | None:
    """The same model and integrator around the fused loop."""
    model = model_of(element, law, cells)
    call = loop_for(model, element, law, rate_loop)
    if call is None:
        return None
    model.updates = (call,)
    if not rate_loop:
        check_forces(element, law)
    return stepper(model)


def check_forces(element: str, law: str) -> None:
    """In a flow that bends cells, forces of the parts are those of the loop, or the two do not compare."""
    plain, fused = model_of(element, law, 100), model_of(element, law, 100)
    call = loop_for(fused, element, law)
    assert call is not None
    fused.updates = (call,)
    for model in (plain, fused):
        x, y = model.reference.T
        model.state["velocity"][:] += 0.1 * np.stack([x * y, x**2 + y], axis=1)
        advance = model.bound_integrator().step
        for dt in (STRAIN, 0.1 * STRAIN):
            advance(dt)
    expected, found = plain.state["internal_force"], fused.state["internal_force"]
    # both sum the same products in other orders; plastic steps are iterated to 1e-12
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-10 * np.abs(expected).max())


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
    """All yardsticks in turns, so that a slow moment of the machine meets each of them."""
    model = model_of(element, law, cells)
    count = len(model.bodies[0].cells)
    step = stepper(model)
    fused, rate = fused_stepper(element, law, cells), fused_stepper(element, law, cells, rate_loop=True)
    repeats = max(1, 100_000 // count)
    for call in (step, fused, rate):
        if call is not None:
            seconds(call, max(2, repeats // 5))
    times: dict[str, list[float]] = {"step": [], "fused": [], "rate": [], "triad": []}
    for _ in range(rounds):
        times["step"].append(seconds(step, repeats))
        times["triad"].append(seconds(lambda: triad(*arrays), 1) / (24 * arrays[0].size))
        for name, call in (("fused", fused), ("rate", rate)):
            if call is not None:
                times[name].append(seconds(call, max(1, repeats // 2)))
    ns = 1e9 * median(times["step"]) / count

    def ratio(name: str) -> float | None:
        pairs = [other / own for other, own in zip(times[name], times["step"], strict=False)]
        return median(pairs) if pairs else None

    bound = median(times["triad"]) * unavoidable_bytes(element, law, model) * 1e9
    spread = (1e9 * min(times["step"]) / count, 1e9 * max(times["step"]) / count)
    return Row(element, law, count, ns, 1e3 / ns, spread, ratio("fused"), ratio("rate"), bound / ns)


def text(value: float | None, form: str) -> str:
    """A number, or a dash where nothing was measured."""
    return "-" if value is None else format(value, form)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--elements", nargs="+", default=["q1"])
    parser.add_argument("--laws", nargs="+", default=list(LAWS), choices=list(LAWS))
    parser.add_argument("--sizes", nargs="+", type=int, default=[1_000, 10_000, 100_000, 1_000_000])
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--json", type=Path, help="write the rows to this file, too")
    chosen = parser.parse_args()
    arrays = tuple(np.ones(20_000_000) for _ in range(3))
    triad(*arrays)
    speed = 24 * arrays[0].size / seconds(lambda: triad(*arrays), 3) / 1e9
    print(f"triad {speed:.1f} GB/s; per cell and step, CPU time of one thread, median of {chosen.rounds} rounds")
    print(
        f"{'element':12s} {'law':17s} {'cells':>8s} {'ns':>8s} {'M/s':>7s} {'x fused':>8s} "
        f"{'x rate J2':>9s} {'bound':>6s}"
    )
    rows = []
    for element in chosen.elements:
        for law in chosen.laws:
            for size in chosen.sizes:
                row = measure(element, law, size, chosen.rounds, arrays)
                rows.append(row)
                print(
                    f"{row.element:12s} {row.law:17s} {row.cells:8d} {row.ns:8.1f} {row.millions_per_s:7.1f} "
                    f"{text(row.over_fused, '8.2f'):>8s} {text(row.over_rate_loop, '9.2f'):>9s} "
                    f"{row.share_of_bound:6.0%}",
                    flush=True,
                )
    if chosen.json is not None:
        chosen.json.write_text(json.dumps([asdict(row) for row in rows], indent=1))


if __name__ == "__main__":
    main()
