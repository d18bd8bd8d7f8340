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
from contactlab.testing.assertions import Check, NotApplicable, require
from contactlab.testing.partners import partners
from contactlab.testing.spoilt import spoilt, unknown

CONTACT = "contacts.0"
POWERS = {
    "length": (1, 0), "pressure": (0, 1), "line_force": (1, 1), "line_energy": (2, 1), "share": (0, 0),
    "": (0, 0),
}  # fmt: skip
"""Powers of lengths and pressures that numbers of a unit follow; others may have a unit that has no name here."""


def record() -> Record:
    """Return a fresh record of a static run of disc-on-block: summary, history and the last curve."""
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
    """Return a made-up reference: an arc of pressure somewhat wider and higher than the run's."""
    x = np.linspace(-0.12, 0.12, 121)
    pressure = 400.0 * np.sqrt(np.maximum(0.0, 1.0 - (x / 0.11) ** 2))
    return Solution(x, pressure, 0.01, "made up", scalars={"reaction": Scalar(60.0, 0.1)})


def says_what_it_is(measure: RunMeasure) -> None:
    """Title and meaning are given, tables know its unit; it can be pickled and is equal to its copy."""
    require(bool(measure.title) and bool(measure.meaning), "its title or its meaning is empty")
    require(measure.meaning.endswith("."), f"its meaning does not end with a full stop: {measure.meaning!r}")
    known = {column.unit for column in BY_NAME.values()} | {"force", "energy", "time", "line_energy"}
    require(measure.unit in known, f"its unit is {measure.unit!r}, allowed: {', '.join(sorted(known - {''}))}")
    require(pickle.loads(pickle.dumps(measure)) == measure, "it differs from its copy after pickling")


def finds_a_number(measure: RunMeasure) -> None:
    """A measure gives one number with and without a reference, NaN if it needs one; finite in one of both."""
    with_one, without = (measure.evaluate(record(), CONTACT, reference) for reference in (solution(), None))
    for value in (with_one, without):
        require(np.ndim(value) == 0 and isinstance(float(value), float), f"it gives {value!r}, needed: a number")
    require(math.isfinite(with_one) or math.isfinite(without), "it finds no number in a finished run")
    if math.isfinite(without):
        other = measure.evaluate(spoilt(record()), CONTACT, None)
        require(_other(other, without), f"without a reference it finds {without:g} in every record; return NaN instead")
    else:
        against = replace(
            solution(), pressure=1.7 * solution().pressure, x=1.3 * solution().x, error=0.02,
            scalars={"reaction": Scalar(77.0, 0.2)},
        )  # fmt: skip
        other = measure.evaluate(record(), CONTACT, against)
        require(_other(other, with_one), f"it needs a reference, but finds {with_one:g} with every reference")


def _other(one: float, two: float) -> bool:
    return repr(float(one)) != repr(float(two))


def looks_at_its_contact(measure: RunMeasure) -> None:
    """A measure finds the number of the requested contact in a run with two contacts."""
    alone = measure.evaluate(record(), CONTACT, solution())
    both = replace(record(), curves={CONTACT: spoilt(record()).curves[CONTACT], "contacts.1": record().curves[CONTACT]})
    second = measure.evaluate(both, "contacts.1", solution())
    if _other(measure.evaluate(both, CONTACT, solution()), alone):
        require(not _other(second, alone), f"it finds {second:g} for the second contact, {alone:g} for its curve alone")


def has_its_unit(measure: RunMeasure) -> None:
    """A run that is twice as large, or with pressures three times as high, gives the number that its unit implies."""
    if measure.unit not in POWERS:
        raise NotApplicable(f"no rule is known for scaling the unit {measure.unit!r} with lengths and pressures")
    plain = measure.evaluate(record(), CONTACT, solution())
    scalars = measure.evaluate(replace(record(), curves=spoilt(record()).curves), CONTACT, solution())
    others = replace(spoilt(record()), curves=record().curves)
    if (
        not math.isfinite(plain)
        or not _other(scalars, plain)
        or _other(measure.evaluate(others, CONTACT, solution()), plain)
    ):
        raise NotApplicable("it depends on more than curves, and only their units are known")
    for length, pressure in ((2.0, 1.0), (1.0, 3.0)):
        found = measure.evaluate(*_scaled(length, pressure))
        by = length ** POWERS[measure.unit][0] * pressure ** POWERS[measure.unit][1]
        what = "lengths are doubled" if length > 1.0 else "pressures are tripled"
        text = f"its unit is {measure.unit}, but if {what} it is {found:g}, expected {by * plain:g}"
        # a number that is zero by symmetry is round-off of its size for other curves
        require(abs(found - by * plain) <= by * max(1e-9 * abs(plain), 1e-12 * abs(scalars)), text)


def _scaled(length: float, pressure: float) -> tuple[Record, str, Solution]:
    """Record and reference with other lengths and pressures."""
    curve, one = record().curve(), solution()
    longer = {name: length * getattr(curve, name) for name in ("s", "x", "y", "gap")}
    higher = {name: pressure * getattr(curve, name) for name in ("pressure", "shear", "nodal_pressure")}
    force = one.scalars["reaction"]
    by = length * pressure
    return (
        replace(record(), curves={CONTACT: [replace(curve, **longer, **higher)]}), CONTACT,
        replace(one, x=length * one.x, pressure=pressure * one.pressure,
                scalars={"reaction": Scalar(by * force.value, by * force.error)}),
    )  # fmt: skip


def finds_the_same_again(measure: RunMeasure) -> None:
    """A second call and a copy find the same number in the same run."""
    first = [measure.evaluate(record(), CONTACT, solution()), measure.evaluate(record(), CONTACT, solution())]
    first.append(pickle.loads(pickle.dumps(measure)).evaluate(record(), CONTACT, solution()))
    require(len({repr(float(value)) for value in first}) == 1, f"it finds {first} in the same run")


def changes_nothing(measure: RunMeasure) -> None:
    """Curve, summary and reference are unchanged, also of a slave that runs against x, and if numbers are NaN."""
    for made in (record, _mirrored, lambda: unknown(record())):
        seen, plain, against = made(), made(), solution()
        measure.evaluate(seen, CONTACT, against)
        for name in ContactCurve.COLUMNS:
            kept = np.array_equal(getattr(seen.curve(), name), getattr(plain.curve(), name), equal_nan=True)
            require(kept, f"it changes the {name} of the curve")
        require(seen.summary == plain.summary, "it changes the summary")
        require(np.array_equal(against.pressure, solution().pressure), "it changes the reference")


def _mirrored() -> Record:
    """The record with x turned over."""
    curve = record().curve()
    return replace(record(), curves={CONTACT: [replace(curve, x=-curve.x)]})


def outlives_empty_contacts(measure: RunMeasure) -> None:
    """A measure gives a number or NaN, and raises nothing, if nothing is pressed."""
    curve = record().curve()
    empty = {name: np.zeros_like(getattr(curve, name)) for name in ("pressure", "shear", "nodal_pressure", "state")}
    nothing = replace(record(), curves={CONTACT: [replace(curve, **empty)]})
    for reference in (solution(), None):
        value = measure.evaluate(nothing, CONTACT, reference)
        require(not math.isinf(value), f"it gives {value} if nothing is pressed")


def follows_from_the_run(measure: RunMeasure) -> None:
    """Other numbers in the record, or in the reference, give another number; unknown values give NaN."""
    plain = measure.evaluate(record(), CONTACT, solution())
    other = measure.evaluate(spoilt(record()), CONTACT, solution())
    against = replace(solution(), pressure=1.7 * solution().pressure, scalars={"reaction": Scalar(77.0, 0.1)})
    moved = [repr(float(v)) != repr(float(plain)) for v in (other, measure.evaluate(record(), CONTACT, against))]
    require(any(moved), f"it finds {plain:g} in every record and with every reference")
    curves_alone = replace(record(), curves=spoilt(record()).curves)
    if repr(float(measure.evaluate(curves_alone, CONTACT, solution()))) != repr(float(plain)):
        blind = measure.evaluate(unknown(record()), CONTACT, solution())
        require(not math.isfinite(blind), f"it finds {blind:g} in a curve of NaN, needed: NaN")


CHECKS: tuple[Check, ...] = (
    says_what_it_is, finds_a_number, finds_the_same_again, changes_nothing, outlives_empty_contacts,
    follows_from_the_run, looks_at_its_contact, has_its_unit,
)  # fmt: skip
"""All checks of measures."""
