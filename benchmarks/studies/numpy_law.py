"""What a law in plain NumPy costs beside the same law in compiled kernels: the two ways to write one.

Neo-Hookean, as an author would write it without a compiler: one line of NumPy for each component, on the rows of a
block. And once more with stacked matrices and `np.linalg`, which is shorter and what one should not do. Whole explicit
steps, elements and node updates included, in one process and in turns; CPU time of the thread, medians.
`benchmarks/bench.py --only numpy-law`.
"""

from __future__ import annotations

from dataclasses import dataclass
from statistics import median
from typing import Any, ClassVar

import numpy as np
from elements import model_of, seconds, stepper

from contactlab.api import Floats, Material
from contactlab.api.material import Kinematics

LAME, SHEAR = 40384.6, 26923.1


@dataclass(frozen=True)
class ByComponents(Material):
    """Neo-Hookean law from F^-1, row by row."""

    density: float = 1e6
    kinematics: ClassVar[Kinematics] = "finite"

    def stress(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        """Cauchy stress (4, P): lambda ln J / J I + mu (b - I) / J."""
        a, b, c, d = gradient
        det = a * d - b * c  # 1/J
        spherical = -(LAME * np.log(det) + SHEAR) * det
        scale = SHEAR / det
        stress[0] = spherical + scale * (d * d + b * b)
        stress[1] = spherical + scale * (a * a + c * c)
        stress[2] = spherical + SHEAR * det
        stress[3] = -scale * (c * d + a * b)

    def wave_speeds(self) -> tuple[float, float]:
        """Of the undeformed material."""
        return ((LAME + 2.0 * SHEAR) / self.density) ** 0.5, (SHEAR / self.density) ** 0.5


@dataclass(frozen=True)
class ByMatrices(ByComponents):
    """The same from stacked 2x2 matrices."""

    def stress(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        """Cauchy stress (4, P)."""
        f = np.linalg.inv(gradient.reshape(2, 2, -1).transpose(2, 0, 1))
        j = np.linalg.det(f)
        b = f @ f.transpose(0, 2, 1)
        spherical = (LAME * np.log(j) - SHEAR) / j
        stress[0], stress[1] = spherical + SHEAR * b[:, 0, 0] / j, spherical + SHEAR * b[:, 1, 1] / j
        stress[2], stress[3] = spherical + SHEAR / j, SHEAR * b[:, 0, 1] / j


def with_law(law: Material | None, cells: int) -> tuple[Any, Any]:
    """A model of the compiled law, or one whose blocks call `law` in its place; and its step."""
    model = model_of("q1", "neo-hookean", cells)
    if law is not None:
        body = model.bodies[0]
        object.__setattr__(body, "material", law)
        forces = model.forces[0]
        for block in forces.blocks:
            block.law = law
        pairs = zip(forces.blocks, forces.scratch, strict=True)
        model.updates = tuple(forces._bind(block, scratch) for block, scratch in pairs)
    return model, stepper(model)


def study(cells: int, rounds: int) -> dict[str, float]:
    """Cost of a step over that of the compiled law, and the cost of that in ns per cell."""
    laws = {"compiled": None, "by components": ByComponents(), "by matrices": ByMatrices()}
    made = {name: with_law(law, cells) for name, law in laws.items()}
    forces = [model.state["internal_force"] for model, _ in made.values()]
    for other in forces[1:]:
        assert np.abs(other - forces[0]).max() <= 1e-4 * np.abs(forces[0]).max()  # constants have six digits
    repeats = max(2, 200_000 // cells)
    times: dict[str, list[float]] = {name: [] for name in made}
    for number in range(rounds + 1):
        for name, (_, step) in made.items():
            spent = seconds(step, repeats)
            if number:
                times[name].append(spent)
    ratios = {name: _ratio(values, times["compiled"]) for name, values in times.items()}
    return {**ratios, "alone": _alone(made, rounds), "compiled_ns": 1e9 * median(times["compiled"]) / cells}


def _ratio(own: list[float], reference: list[float]) -> float:
    return median(a / b for a, b in zip(own, reference, strict=True))


def _alone(made: dict[str, tuple[Any, Any]], rounds: int) -> float:
    """Ratio of the calls of the two laws alone, without elements and nodes."""
    times: dict[str, list[float]] = {"compiled": [], "by components": []}
    for _ in range(rounds):
        for name, values in times.items():
            forces = made[name][0].forces[0]
            values.append(seconds(lambda forces=forces: _stresses(forces), 10))  # type: ignore[misc]
    return _ratio(times["by components"], times["compiled"])


def _stresses(forces: Any) -> None:
    for block in forces.blocks:
        forces.body.material.stress(block.gradient, block.history, 0.0, block.stress, block.new_history)
