"""What the static scenes with exact answers share: scenes, figures of merit, the mortars and their slaves."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from contactlab.api import Floats
from contactlab.results.results import Results
from contactlab.scene.scene import Scene
from contactlab.testing.cases.figures import Figure

Rows = Iterator[tuple[str, list[Figure]]]
"""A variant of a case and what was measured on it."""

MORTARS = ("mortar-p0", "mortar-p1")
INF = float("inf")


def scene(name: str, steps: int, materials: dict[str, Any], contact: dict[str, Any], **more: Any) -> Scene:
    """Materials are linear elastic unless they say otherwise."""
    base = {"use": "linear-elastic", "density": 1.0}
    data = {
        "name": name,
        "integrator": {"use": "newton", "steps": steps},
        "materials": {key: base | values for key, values in materials.items()},
        "contacts": [contact],
        "record": {"recorders": [], "frames": 1},
    }
    return Scene.from_data(data | more)


def within(says: str, value: float, most: float) -> Figure:
    """A number of either sign that must not be farther from zero than `most`."""
    return Figure(says, value, -most, most)


def percent(says: str, value: float, most: float = INF) -> Figure:
    """A fraction, shown in percent; its criterion too."""
    return Figure(f"{says} %", 100.0 * value, -most, most)


def plane_strain(young: float, poisson: float) -> float:
    """E/(1 - nu^2) [MPa]."""
    return young / (1.0 - poisson**2)


def graded_count(length: float, first: float, growth: float) -> int:
    """Cells of growing size from `first` on that fill a length."""
    return max(2, round(np.log(1.0 + length / first * (growth - 1.0)) / np.log(growth)))


def ordered(x: Floats, *values: Floats) -> tuple[Floats, ...]:
    """By increasing x."""
    order = np.argsort(x)
    return x[order], *(v[order] for v in values)


def spread(x: Floats, values: Floats, reach: float) -> tuple[Floats, Floats]:
    """The linear interpolant at many points of |x| < reach."""
    at, order = np.linspace(-reach, reach, 4001), np.argsort(x)
    return at, np.interp(at, x[order], values[order])


def l2_error(x: Floats, values: Floats, exact: Callable[[Floats], Floats], reach: float) -> float:
    """Relative L2 difference over |x| < reach between the linear interpolant of nodal values and a function."""
    at, found = spread(x, values, reach)
    wanted = exact(at)
    return float(np.sqrt(((found - wanted) ** 2).sum() / (wanted**2).sum()))


def stopped(results: Results, judged: bool = True) -> list[Figure]:
    """What is said of a run that did not come to its end; empty if it did."""
    if results.status == "finished":
        return []
    return [Figure("finished (1) or not converged (0)", 0.0, least=1.0 if judged else -INF)]


def label(algorithm: str, *parts: object) -> str:
    """Name of a variant."""
    return ", ".join(str(part) for part in (algorithm.removeprefix("mortar-").upper(), *parts))
