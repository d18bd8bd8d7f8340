"""How near to the limit: the best that the slave's nodes could do, beside the error of a pressure."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from contactlab.accuracy.problem import Problem
from contactlab.accuracy.scene_case import PRESSURE
from contactlab.api import Record, Setup
from contactlab.errors import PartError
from contactlab.studies.best_approximation import best_error
from contactlab.studies.profile import Profile

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
