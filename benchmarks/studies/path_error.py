"""What the length of load steps costs, estimated by one double step at the end, against runs with many steps.

python benchmarks/studies/path_error.py            prints the table of path_error.md
"""

from __future__ import annotations

from collections.abc import Iterator
from time import process_time
from typing import Any

import numpy as np

import contactlab
from contactlab.api import Floats, StepStatus
from contactlab.model.build import build
from contactlab.model.memory import model_memory, restore_model
from contactlab.scene.scene import Scene

FINE = 12  # times the steps of the coarsest run

SOFT: dict[str, Any] = {"young": 7000.0, "poisson": 0.3, "density": 2.7e-9}
FLOWS: dict[str, Any] = {
    "materials.soft": {"use": "power-law", "strength": 60.0, "prestrain": 0.02, "exponent": 0.1} | SOFT
}
STEEL: dict[str, Any] = {"materials.steel": {"use": "hypoelastic", "young": 70000.0, "poisson": 0.3, "density": 2.7e-9}}


def disc(mu: float, deep: float = -0.1581, algorithm: str = "mortar-p1", **more: Any) -> Scene:
    """disc-on-block, statics, level 1."""
    friction = {"contacts.0.friction": {"use": "coulomb", "mu": mu}} if mu else {}
    changes = {"level": 1, "integrator": {"use": "newton"}, "supports.1.uy": {"ramp": "linear", "to": deep}}
    return contactlab.load_scene("disc-on-block").with_(changes | {"contacts.0.algorithm": algorithm} | friction | more)


def scenes() -> Iterator[tuple[str, Scene, int]]:
    """Name, scene, load steps."""
    for mu in (0.1, 0.2, 0.5):
        for steps in (5, 10, 20):
            yield f"disc, mu {mu}", disc(mu), steps
    for steps in (5, 10, 20):
        yield "disc, shallow", disc(0.2, -0.05), steps
        yield "disc, P0", disc(0.2, algorithm="mortar-p0"), steps
    for steps in (5, 10):
        yield "block flows", disc(0.0, -0.03, **FLOWS, **STEEL), steps
        yield "block flows, mu 0.2", disc(0.2, -0.03, **FLOWS, **STEEL), steps


def quantities(state: Any) -> dict[str, Floats]:
    """What is compared: friction by node, normal forces by node, reactions."""
    y = state["multipliers"]
    found = {"shear": y[1].copy()} if len(y) > 1 else {}
    return found | {"pressure": y[0].copy(), "reaction": state["reaction"].ravel().copy()}


def run(scene: Scene, steps: int, estimate: bool = True) -> tuple[dict[str, Floats], dict[str, Floats], float, float]:
    """Quantities of equal steps, those of a double step at the end, and the CPU time of each part."""
    model = build(scene, scene.registry)
    advance, dt, kept = model.bound_integrator().step, 1.0 / steps, None
    began = process_time()
    for number in range(steps):
        if number == steps - 2 and estimate:
            kept = {name: np.copy(values) for name, values in model_memory(model).items()}
        done = advance(dt)
        if done.status is not StepStatus.accepted:
            raise RuntimeError(f"step {number + 1}: {done.reason}")
    took, began, found = process_time() - began, process_time(), quantities(model.state)
    if kept is None:
        return found, {}, took, 0.0
    again = build(scene, scene.registry)
    restore_model(again, kept)
    done = again.bound_integrator().step(2.0 * dt)
    if done.status is not StepStatus.accepted:
        raise RuntimeError(f"double step: {done.reason}")
    return found, quantities(again.state), took, process_time() - began


def distance(one: Floats, other: Floats) -> float:
    """Length of the difference over the length of the first."""
    return float(np.linalg.norm(one - other)) / max(float(np.linalg.norm(one)), 1e-300)


def peak(one: Floats, other: Floats) -> float:
    """Difference of the largest entries over that of the first."""
    return float(abs(np.abs(one).max() - np.abs(other).max()) / max(np.abs(one).max(), 1e-300))


def main() -> None:
    """Print one line a scene and quantity."""
    fine: dict[str, dict[str, Floats]] = {}
    for name, scene, steps in scenes():
        try:
            if name not in fine:
                fine[name] = run(scene, 5 * FINE, estimate=False)[0]
            found, double, took, cost = run(scene, steps)
        except RuntimeError as problem:
            print(f"{name} | {steps} | {problem}", flush=True)
            continue
        for key, exact in fine[name].items():
            true, seen = distance(exact, found[key]), distance(found[key], double[key])
            tip, top = peak(exact, found[key]), peak(found[key], double[key])
            print(
                f"{name} | {steps} | {key} | {true:.2e} | {seen:.2e} | {true / max(seen, 1e-300):.2f} | {tip:.2e} | "
                f"{top:.2e} | {tip / max(top, 1e-300):.2f} | {cost / took:.0%}",
                flush=True,
            )


if __name__ == "__main__":
    main()
