"""Efficiency: a pressure that is the best approximation has 1, an interpolant less; other quantities have none."""

from __future__ import annotations

import math

import numpy as np
import pytest

from contactlab.accuracy.efficiency import best_of
from contactlab.accuracy.point import Point
from contactlab.accuracy.problem import Problem, problem_of
from contactlab.accuracy.scene_case import SceneCase
from contactlab.accuracy.study import CaseChoice
from contactlab.api import ContactCurve, Record, Setup
from contactlab.parts.registry import default_registry
from contactlab.scene.scene import load_scene
from contactlab.studies.profile import Profile
from contactlab.studies.reference import Reference

SETUP = Setup("mortar-p1", False, "q1", "newton", 1)
FINE = np.linspace(0.0, 1.0, 20001)
PARABOLA = Profile(FINE, 1.0 + FINE**2)


def record(x: np.ndarray, pressure: np.ndarray, status: str = "finished") -> Record:
    columns = dict.fromkeys(ContactCurve.COLUMNS, pressure) | {"x": x, "s": x}
    return Record(status, "", {}, {}, {"contacts.0": np.array([1.0])}, {"contacts.0": [ContactCurve(**columns)]})


def problem() -> Problem:
    reference = Reference("exact", "a parabola", "", PARABOLA, np.zeros(20001), error_estimate={"pressure": 0.0})
    return Problem(CaseChoice(scene="disc-on-block"), SceneCase(load_scene("disc-on-block").data, reference))


def efficiency(x: np.ndarray, pressure: np.ndarray) -> float:
    asked, done = problem(), {"run": record(x, pressure)}
    error = asked.error(SETUP, asked.case.evaluate(SETUP, done))
    return Point("a", "b", "declared", 1, "finished", "", error, best=best_of(asked, SETUP, done)).efficiency


def test_the_best_approximation_has_one_and_an_interpolant_less() -> None:
    x = np.linspace(0.0, 1.0, 9)
    exact = 1.0 + x**2
    # s (h - s) is what an interpolant of x^2 misses: h^5/30 a segment in the square, h^5/180 once its mean is taken out
    assert efficiency(x, exact - (1 / 8) ** 2 / 6.0) == pytest.approx(1.0, abs=1e-5)  # facets of the reference
    assert efficiency(x, exact) == pytest.approx(math.sqrt(30.0 / 180.0), rel=1e-4)


def test_without_an_exact_pressure_there_is_none() -> None:
    asked, x = problem(), np.linspace(0.0, 1.0, 9)
    assert math.isnan(best_of(asked, SETUP, {"run": record(x, x, "diverged")}))
    force = problem_of(CaseChoice(use="hertz", error="largest pressure"), default_registry())
    assert math.isnan(best_of(force, SETUP, {"run": record(x, x)}))
    assert math.isnan(Point("a", "b", "declared", 1, "failed", best=0.1).efficiency)
