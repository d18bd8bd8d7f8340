"""Efficiency of pressures: the error of the best approximation on the slave's nodes over the error of a pressure."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from contactlab.accuracy.problem import Problem
from contactlab.accuracy.scene_case import PRESSURE
from contactlab.api import Record, Setup
from contactlab.api.arrays import Floats, Ints
from contactlab.errors import PartError
from contactlab.studies.profile import Profile, Window, quadrature

MEASURES = ("L2 of the pressure", PRESSURE)
"""What names of measures begin with that a best approximation goes with: relative errors of the pressure in L2."""


def best_of(problem: Problem, setup: Setup, done: Mapping[str, Record]) -> float:
    """Relative L2 error of the best approximation of the exact pressure on the nodes that the error was measured on.

    Pressures are compared as continuous piecewise linear functions of the deformed slave nodes, those of constant
    multipliers and of nodal forces, too; the best approximation is sought among these. nan where another quantity
    counts, where the case has no exact pressure, or a run did not come to its end. Raises PartError where it raises.
    """
    records = list(done.values())
    if len(records) != 1 or not records[0].finished or not problem.measure(setup).name.startswith(MEASURES):
        return math.nan
    try:
        exact = problem.case.exact_pressure(setup, done)
    except Exception as error:
        text = f"the case raised {type(error).__name__} for its exact pressure: {error}"
        raise PartError(text, where=type(problem.case).__name__) from error
    if exact is None:
        return math.nan
    profile = Profile(np.asarray(exact.x, float), np.asarray(exact.pressure, float))
    return best_error(np.asarray(records[0].curve().x, float), profile, exact.window)


def best_error(nodes: Floats, exact: Profile, window: Window | None = None) -> float:
    """Relative error in L2 of the continuous piecewise linear function on `nodes` (m,) that is nearest to `exact`.

    It is the orthogonal projection onto these functions, zero outside the nodes. Both are taken over the window, or
    over all of the nodes and of `exact`; nan without two nodes there.
    """
    x = np.unique(np.asarray(nodes, float))
    low, high = window or (min(exact.x[0], x[0]), max(exact.x[-1], x[-1])) if x.size and exact.x.size else (0.0, 0.0)
    touching = np.flatnonzero((np.append(x[1:], np.inf) > low) & (np.append(-np.inf, x[:-1]) < high))
    x = x[touching]
    if len(x) < 2:
        return np.nan
    breaks = np.unique(np.concatenate([x, exact.x, [low, high]]))
    at, weights = quadrature(breaks[(breaks >= low) & (breaks <= high)])
    wanted = exact(at)
    inside = (at >= x[0]) & (at <= x[-1])
    segment = np.clip(np.searchsorted(x, at[inside], side="right") - 1, 0, len(x) - 2)
    right = (at[inside] - x[segment]) / np.diff(x)[segment]
    shapes = 1.0 - right, right
    values = _solved(segment, shapes, weights[inside], wanted[inside], len(x))
    found = np.zeros(len(at))
    found[inside] = values[segment] * shapes[0] + values[segment + 1] * shapes[1]
    norm = float(weights @ wanted**2)
    return float(np.sqrt(weights @ (found - wanted) ** 2 / norm)) if norm > 0.0 else np.nan


def _solved(segment: Ints, shapes: tuple[Floats, Floats], weights: Floats, wanted: Floats, count: int) -> Floats:
    """Nodal values (m,) of the projection: the mass matrix is tridiagonal."""
    from scipy.linalg import solveh_banded

    left, right = shapes
    mass = np.zeros((2, count))
    np.add.at(mass[1], segment, weights * left * left)
    np.add.at(mass[1], segment + 1, weights * right * right)
    np.add.at(mass[0], segment + 1, weights * left * right)
    force = np.zeros(count)
    np.add.at(force, segment, weights * left * wanted)
    np.add.at(force, segment + 1, weights * right * wanted)
    return np.asarray(solveh_banded(mass, force))
