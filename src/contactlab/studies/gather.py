"""From the outcomes of runs to the rows of a table."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from contactlab.api.warning import RunWarning
from contactlab.studies.measure_run import measure_run
from contactlab.studies.measures import mutual_difference, relative_difference
from contactlab.studies.plan import Job, Plan
from contactlab.studies.reference import Reference, load_reference, matching_reference
from contactlab.studies.run_job import Outcome
from contactlab.studies.table import COMPLETE, Row


def gather(plan: Plan, outcomes: Mapping[str, Outcome], named: Reference | None) -> list[Row]:
    """A row per job. Pairs of rows that differ in the swap alone share their asymmetry."""
    rows = [row_of(plan, job, outcomes[job.name], named) for job in plan.jobs]
    partners: dict[str, list[Row]] = {}
    for job, row in zip(plan.jobs, rows, strict=True):
        partners.setdefault(job.partner, []).append(row)
    shared = {row.name: _pair_measures(pair) for pair in partners.values() for row in pair}
    return [_with_measures(row, shared[row.name]) for row in rows]


def row_of(plan: Plan, job: Job, outcome: Outcome, named: Reference | None) -> Row:
    """The row of one job, without the measures that it shares with its partner."""
    data = job.scene.data
    reference, why = fitting_reference(data, named)
    final = outcome.curve if outcome.status in COMPLETE else None
    measures, notes = measure_run(data, outcome.summary, plan.contact, final, reference)
    if outcome.curve is not None and final is None:
        notes.append(
            f"{job.algorithm}, slave {job.slave}, level {job.scene.level}: stopped before the load was complete; "
            "its pressure is shown and not compared"
        )
    return Row(
        name=job.name,
        algorithm=job.algorithm,
        slave=job.slave,
        level=job.scene.level,
        varied=job.varied,
        choices=job.choices,
        status=outcome.status,
        reason=outcome.reason,
        measures=measures,
        notes=[*notes, *([why] if why else [])],
        system=outcome.system,
        parts=outcome.summary.get("parts", {}),
        warnings=[RunWarning.from_data(data) for data in outcome.summary.get("warnings", ())],
        reference=reference.name if reference else "",
        curve=outcome.curve,
        shapes=outcome.shapes,
        refines=job.refines,
    )


def fitting_reference(scene: Mapping[str, Any], named: Reference | None) -> tuple[Reference | None, str]:
    """The study's reference where it holds, else a bundled one that does; and why there is none."""
    if named is not None and not named.mismatch(scene):
        return named, ""
    found = matching_reference(scene)
    if found is not None:
        return found, ""
    return None, f"{named.name} does not hold: {named.mismatch(scene)}" if named else "no reference fits this scene"


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


def _with_measures(row: Row, more: Mapping[str, float]) -> Row:
    return replace(row, measures={**row.measures, **more})


def common_reference(rows: Iterable[Row], named: Reference | None) -> Reference | None:
    """The reference of the report: the one that most rows compare with."""
    names = [row.reference for row in rows if row.reference]
    if not names:
        return None
    most = max(set(names), key=names.count)
    return named if named is not None and named.name == most else load_reference(most)
