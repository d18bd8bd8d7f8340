"""Checks of measures of runs: they find one number in the record of a run, and change nothing."""

from __future__ import annotations

import copy
import math
import pickle
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from contactlab.api import ContactCurve, Record, RunMeasure, Scalar, Solution
from contactlab.parts.registry import default_registry
from contactlab.run.simulation import simulate
from contactlab.scene.scene import load_scene
from contactlab.studies.columns import BY_NAME
from contactlab.testing.assertions import Check, require
from contactlab.testing.partners import partners
from contactlab.testing.spoilt import spoilt, unknown

CONTACT = "contacts.0"


def record() -> Record:
    """What a comparison keeps of a static run of disc-on-block: summary, history and the last curve; a fresh copy."""
    return copy.deepcopy(_record())


@cache
def _record() -> Record:
    registry = default_registry()
    static = next(n for n in partners(registry, "integrator") if not registry.part_class("integrator", n).inertia)
    changes: dict[str, Any] = {"integrator": static, "record.recorders": [], "supports.1.uy.to": -0.01}
    results = simulate(load_scene("disc-on-block").with_(changes))
    curves = {CONTACT: [results.contact[CONTACT].last]}
    return Record(results.status, results.reason, results.summary, results.history, curves=curves)


def solution() -> Solution:
    """A made-up reference: an arc of pressure somewhat wider and higher than that of the run."""
    x = np.linspace(-0.12, 0.12, 121)
    pressure = 400.0 * np.sqrt(np.maximum(0.0, 1.0 - (x / 0.11) ** 2))
    return Solution(x, pressure, 0.01, "made up", scalars={"reaction": Scalar(60.0, 0.1)})


def says_what_it_is(measure: RunMeasure) -> None:
    """Title and meaning are given, tables know its unit; it can be pickled and is equal to its copy."""
    require(bool(measure.title) and bool(measure.meaning), "its title or its meaning is empty")
    require(measure.meaning.endswith("."), f"its meaning is no sentence: {measure.meaning!r}")
    known = {column.unit for column in BY_NAME.values()} | {"force", "energy", "time", "line_energy"}
    require(measure.unit in known, f"its unit is {measure.unit!r}, known are {', '.join(sorted(known - {''}))}")
    require(pickle.loads(pickle.dumps(measure)) == measure, "it is not equal to what its pickle brings back")


def finds_a_number(measure: RunMeasure) -> None:
    """With a reference and without: one number, nan where it needs one; finite in one of both."""
    with_one, without = (measure.evaluate(record(), CONTACT, reference) for reference in (solution(), None))
    for value in (with_one, without):
        require(np.ndim(value) == 0 and isinstance(float(value), float), f"it gives {value!r}, which is no number")
    require(math.isfinite(with_one) or math.isfinite(without), "it finds nothing in a run that finished well")


def finds_the_same_again(measure: RunMeasure) -> None:
    """A second call and a copy find the same number in the same run."""
    first = [measure.evaluate(record(), CONTACT, solution()), measure.evaluate(record(), CONTACT, solution())]
    first.append(pickle.loads(pickle.dumps(measure)).evaluate(record(), CONTACT, solution()))
    require(len({repr(float(value)) for value in first}) == 1, f"it finds {first} in the same run")


def changes_nothing(measure: RunMeasure) -> None:
    """Curve, summary and reference are unchanged."""
    seen, against = record(), solution()
    measure.evaluate(seen, CONTACT, against)
    for name in ContactCurve.COLUMNS:
        kept = np.array_equal(getattr(seen.curve(), name), getattr(record().curve(), name), equal_nan=True)
        require(kept, f"it changes the {name} of the curve")
    require(seen.summary == record().summary, "it changes the summary")
    require(np.array_equal(against.pressure, solution().pressure), "it changes the reference")


def outlives_empty_contacts(measure: RunMeasure) -> None:
    """Where nothing is pressed it gives a number or nan, and raises nothing."""
    curve = record().curve()
    empty = {name: np.zeros_like(getattr(curve, name)) for name in ("pressure", "shear", "nodal_pressure", "state")}
    nothing = replace(record(), curves={CONTACT: [replace(curve, **empty)]})
    for reference in (solution(), None):
        value = measure.evaluate(nothing, CONTACT, reference)
        require(not math.isinf(value), f"it gives {value} where nothing is pressed")


def follows_from_the_run(measure: RunMeasure) -> None:
    """Other numbers in the record, or in the reference, give another number; what it cannot know is no number."""
    plain = measure.evaluate(record(), CONTACT, solution())
    other = measure.evaluate(spoilt(record()), CONTACT, solution())
    against = replace(solution(), pressure=1.7 * solution().pressure, scalars={"reaction": Scalar(77.0, 0.1)})
    moved = [repr(float(v)) != repr(float(plain)) for v in (other, measure.evaluate(record(), CONTACT, against))]
    require(any(moved), f"it finds {plain:g} whatever is in the record and in the reference")
    curves_alone = replace(record(), curves=spoilt(record()).curves)
    if repr(float(measure.evaluate(curves_alone, CONTACT, solution()))) != repr(float(plain)):
        blind = measure.evaluate(unknown(record()), CONTACT, solution())
        require(not math.isfinite(blind), f"it finds {blind:g} in a curve of NaN; NaN says that nothing is known")


CHECKS: tuple[Check, ...] = (
    says_what_it_is, finds_a_number, finds_the_same_again, changes_nothing, outlives_empty_contacts,
    follows_from_the_run,
)  # fmt: skip
"""All checks of measures."""
