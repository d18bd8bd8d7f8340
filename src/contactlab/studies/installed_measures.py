"""Measures that plugins bring: what they find in a run, and their columns."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from contactlab.api import Record, RunMeasure, Scalar, Solution
from contactlab.errors import PartError, one_line
from contactlab.parts.registry import Registry
from contactlab.studies.columns import BY_NAME, Column
from contactlab.studies.reference import Reference


def column_name(part: str) -> str:
    """Name of a measure in `table.csv` and in studies: "contact_length" for the part contact-length."""
    return part.replace("-", "_")


def measure_columns(registry: Registry) -> tuple[Column, ...]:
    """Return a column per installed measure. Raises PartError if every table has a column of its name."""
    found = []
    for name in registry.names("measure"):
        part, column = registry.part_class("measure", name), column_name(name)
        if column in BY_NAME:
            raise PartError("every comparison has a column of this name", where=f"measure {name}", got=column)
        found.append(Column(column, part.title, part.unit, part.meaning, part.digits, part.better))
    return tuple(found)


def known_measures(registry: Registry) -> Sequence[str]:
    """Names that a study may list under `measures`."""
    return [*BY_NAME, *map(column_name, registry.names("measure"))]


def with_installed(
    measures: Mapping[str, float], record: Record, contact: int, reference: Reference | None, registry: Registry
) -> tuple[dict[str, float], list[str]]:
    """The measures of a run, with the measures of installed parts, and notes on parts that raised."""
    found, notes = dict(measures), []
    solution = None if reference is None else _solution(reference)
    for name in registry.names("measure"):
        part: RunMeasure = registry.make("measure", name)
        try:
            found[column_name(name)] = float(part.evaluate(record, f"contacts.{contact}", solution))
        except Exception as error:
            found[column_name(name)] = math.nan
            notes.append(f"the measure {name} raised {one_line(error)}")
    return found, notes


def _solution(reference: Reference) -> Solution:
    """Return the reference of a comparison in the form that measures get."""
    scalars = {
        name: Scalar(float(s["value"]), float(s.get("error", 0.0)), str(s.get("meaning", "")))
        for name, s in reference.scalars.items()
    }
    curve = reference.profile.x, reference.profile.value, reference.pressure_uncertainty
    return Solution(
        *curve, str(reference.error_estimate.get("meaning", "")), reference.spread, reference.window, scalars
    )
