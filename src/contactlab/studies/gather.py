"""Rows of a table from the records of runs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from contactlab.api import Record
from contactlab.api.warning import RunWarning
from contactlab.jobs.system import system_facts
from contactlab.parts.registry import Registry
from contactlab.studies.find_reference import Source, matching_reference
from contactlab.studies.installed_measures import with_installed
from contactlab.studies.measure_run import applied_share, carried_load, measure_run
from contactlab.studies.measures import mutual_difference, relative_difference
from contactlab.studies.plan import Combination, Plan
from contactlab.studies.reference import Reference
from contactlab.studies.shape import shapes_of
from contactlab.studies.table import Row


def gather(plan: Plan, records: Mapping[str, Record], named: Source | None) -> list[Row]:
    """A row per job. Pairs of rows that differ in the swap alone share their asymmetry."""
    rows = [row_of(plan, job, records[job.name], named) for job in plan.jobs]
    partners: dict[str, list[Row]] = {}
    for job, row in zip(plan.jobs, rows, strict=True):
        partners.setdefault(job.partner, []).append(row)
    shared = {row.name: _pair_measures(pair) for pair in partners.values() for row in pair}
    return [replace(row, measures={**row.measures, **shared[row.name]}) for row in rows]


def row_of(plan: Plan, job: Combination, record: Record, named: Source | None) -> Row:
    """The row of one job, without the measures that it shares with its partner."""
    data = job.scene.data
    reference, why = fitting_reference(data, named, job.scene.registry)
    curve = record.curve(name) if record.curves.get(name := f"contacts.{plan.contact}") else None
    share = applied_share(record.summary)
    loaded = carried_load(record.status, share)
    final = curve if loaded else None
    measures, notes = measure_run(data, record.summary, plan.contact, final, reference if loaded else None)
    if curve is not None and final is None:
        notes.append(
            f"{job.algorithm}, slave {job.slave}, level {job.scene.level}: stopped before the load was complete; "
            "its pressure is shown, but not compared"
        )
    if final is not None:
        measures, said = with_installed(measures, record, plan.contact, reference, job.scene.registry)
        notes += said
    return Row(
        name=job.name,
        algorithm=job.algorithm,
        slave=job.slave,
        level=job.scene.level,
        varied=job.varied,
        choices=job.choices,
        status=record.status,
        reason=record.reason,
        measures=measures,
        notes=[*notes, *([why] if why else [])],
        system=record.summary.get("system") or system_facts(),
        parts=record.summary.get("parts", {}),
        warnings=[RunWarning.from_data(data) for data in record.summary.get("warnings", ())],
        reference=reference.name if reference else "",
        curve=curve,
        shapes=shapes_of(record),
        refines=job.refines,
        history=record.history,
        path=str(record.summary.get("history", {}).get("curve", "")),
        share=share,
    )


def fitting_reference(
    scene: Mapping[str, Any], named: Source | None, registry: Registry | None = None
) -> tuple[Reference | None, str]:
    """Return the study's reference if it holds, else an installed one that does; and why none holds."""
    if named is not None and not named.mismatch(scene):
        return named.at(scene), ""
    found = matching_reference(scene, registry)
    if found is not None:
        return found, ""
    return None, f"{named.name} does not apply: {named.mismatch(scene)}" if named else "no reference fits this scene"


def _pair_measures(pair: Sequence[Row]) -> dict[str, float]:
    if len(pair) != 2 or not all(row.complete for row in pair):
        return {}
    a, b = pair
    found = {
        "swap_reaction_difference": relative_difference(
            a.measures.get("reaction", math.nan), b.measures.get("reaction", math.nan)
        )
    }
    if a.profile is not None and b.profile is not None:
        found["swap_asymmetry"] = mutual_difference(a.profile, b.profile)
    return found


def common_reference(plan: Plan, rows: Sequence[Row], named: Source | None) -> Reference | None:
    """The reference of the report: the one that most rows compare with, at the first of their scenes."""
    names = [row.reference for row in rows if row.reference]
    if not names:
        return None
    most = max(set(names), key=names.count)
    first = next(job for job, row in zip(plan.jobs, rows, strict=True) if row.reference == most)
    return fitting_reference(first.scene.data, named, first.scene.registry)[0]
