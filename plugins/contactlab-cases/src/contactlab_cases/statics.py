"""Helpers of the static cases: scenes, meshes, curves by increasing x, and errors of pressures."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from contactlab.api import ContactCurve, Floats, Job, Record, Setup

WORK = 250
"""Steps and iterations after which a static case is given up: three times what any of them needs if it converges."""
HELD_BY_FRICTION = {"use": "active-set", "start": "stick"}
"""Enforcement of a contact whose bodies are held along it by friction alone."""


def static_job(
    name: str, setup: Setup, materials: Mapping[str, Mapping[str, Any]], bodies: Mapping[str, Any],
    contact: Mapping[str, Any], steps: int = 1, frames: int = 1, fields: bool = False,
    tolerance: float = 1e-8, **more: Any,
) -> Job:  # fmt: skip
    """A static run. Materials are linear elastic unless they name a law; bodies take the element of the setup."""
    law = {"use": "linear-elastic", "density": 1.0}
    scene = {
        "name": name,
        # methods are judged by themselves: a jump that is helped over would stand for none of them
        "integrator": {"use": "newton", "steps": steps, "stabilised": False, "tolerance": tolerance},
        "materials": {key: law | dict(values) for key, values in materials.items()},
        "bodies": {key: {"element": setup.element} | dict(body) for key, body in bodies.items()},
        "contacts": [{"algorithm": setup.algorithm, "swap": setup.swap} | dict(contact)],
    }
    return Job(name, scene | more, work=WORK, frames=frames, fields=fields)


def plane_strain(young: float, poisson: float = 0.3) -> float:
    """Modulus E/(1 - nu^2) [MPa] of plane strain."""
    return young / (1.0 - poisson**2)


def graded_count(length: float, first: float, growth: float) -> int:
    """Cells of growing size from `first` on that fill a length."""
    return max(2, round(math.log(1.0 + length / first * (growth - 1.0)) / math.log(growth)))


def ordered(x: Floats, *values: Any) -> tuple[Floats, ...]:
    """Sort a curve by increasing x."""
    order = np.argsort(x)
    return x[order], *(np.asarray(v)[order] for v in values)


def l2_error(x: Floats, values: Floats, exact: Callable[[Floats], Floats], reach: float) -> float:
    """Relative L2 difference over |x| < reach between the linear interpolant of nodal values and a function.

    NaN if the function is zero: nothing was pressed yet when the run ended.
    """
    at, order = np.linspace(-reach, reach, 4001), np.argsort(x)
    found, wanted = np.interp(at, x[order], values[order]), exact(at)
    if not wanted.any():
        return math.nan
    return float(np.sqrt(((found - wanted) ** 2).sum() / (wanted**2).sum()))


def force_of(record: Record, support: str = "block.bottom") -> float:
    """Force [N/mm] that the block is pressed with."""
    return float(record.reaction(support)[1])


def iterations(record: Record) -> float:
    """Number of Newton iterations of the run."""
    return float(record.summary["iterations"])


def cell_size(curve: ContactCurve, reach: float) -> float:
    """Mean length of the slave's segments over |x| < reach."""
    x = np.sort(curve.x[np.abs(curve.x) < reach])
    return float(np.diff(x).mean())


def projected(at: Floats, values: Floats, cells: int) -> Floats:
    """L2 projection of `values` (n,) at equal distances onto piecewise linear functions on so many equal cells."""
    nodes = np.linspace(at[0], at[-1], cells + 1)
    shapes = np.stack([np.interp(at, nodes, unit) for unit in np.eye(cells + 1)], axis=1)
    weights = np.ones(len(at))
    weights[[0, -1]] = 0.5
    mass = (shapes.T * weights) @ shapes
    return np.asarray(shapes @ np.linalg.solve(mass, (shapes.T * weights) @ values))
