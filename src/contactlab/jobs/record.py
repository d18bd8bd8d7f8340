"""Records: made from the results of a run, and as bytes."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from contactlab.api import ContactCurve, Job, Record
from contactlab.results.results import Results


def record_of(results: Results, job: Job) -> Record:
    """Keep the results of a run that the job requests."""
    names = [contact.name for contact in results.layout.contacts]
    first = -1 if job.curves == "last" else 0
    fields: dict[str, Any] = {}
    if job.fields:
        fields = {
            "nodes": results.nodes, "displacement": results.displacement, "velocity": results.velocity,
            "stress": results.stress, "cells": results.cells,
        }  # fmt: skip
    return Record(
        status=results.status,
        reason=results.reason,
        summary={**results.summary, "guards": job.guards},
        history=results.history,
        times={name: np.array(results.contact[name].times)[first:] for name in names},
        curves={name: list(results.contact[name].curves)[first:] for name in names},
        watched=results.watched,
        events=[event.text for event in results.events],
        **fields,
    )


def ended(status: str, reason: str, **summary: Any) -> Record:
    """Make the record of a run that left no results."""
    return Record(status, reason, {"status": status, "reason": reason, **summary})


def refused(reason: str) -> Record:
    """Make the record of a run that could not begin."""
    return ended("refused", reason)


# --- as bytes: arrays in an npz archive, the rest as JSON in it; no code comes out of either ---------

_ARRAYS = ("history", "times", "stress", "cells")
_FIELDS = ("nodes", "displacement", "velocity")


def to_bytes(record: Record) -> bytes:
    """A record as bytes that `from_bytes` reads."""
    text = json.dumps(
        {
            "status": record.status, "reason": record.reason, "summary": record.summary,
            "events": list(record.events), "curves": {name: len(c) for name, c in record.curves.items()},
            "memory": {name: list(curves[-1].memory) for name, curves in record.curves.items() if curves},
        },
        default=lambda value: dict(value) if isinstance(value, Mapping) else value.tolist(),
    )  # fmt: skip
    arrays = {"record": np.frombuffer(text.encode(), np.uint8), **dict(_flat(record))}
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as packed:
        for name, values in arrays.items():
            with packed.open(f"{name}.npy", "w", force_zip64=True) as entry:
                np.lib.format.write_array(entry, np.asanyarray(values), allow_pickle=False)
    return file.getvalue()


def _flat(record: Record) -> Iterator[tuple[str, Any]]:
    for group in _ARRAYS:
        for name, values in getattr(record, group).items():
            yield f"{group}/{name}", values
    for name in _FIELDS:
        yield f"field/{name}", getattr(record, name)
    for name, curves in record.curves.items():
        for number, curve in enumerate(curves):
            yield f"curves/{name}/{number}", np.array(list(curve.columns().values()))
    for watch, found in record.watched.items():
        for name, values in found.items():
            yield f"watched/{watch}/{name}", values


def from_bytes(data: bytes) -> Record:
    """The record that `to_bytes` wrote. Raises ValueError if `data` is not a record."""
    with np.load(io.BytesIO(data), allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files}
    head = json.loads(arrays.pop("record").tobytes())
    groups: dict[str, dict[str, Any]] = {name: {} for name in (*_ARRAYS, "field", "curves", "watched")}
    for name, values in arrays.items():
        group, _, rest = name.partition("/")
        groups[group][rest] = values
    fields: dict[str, Any] = {**groups["field"], **{name: groups[name] for name in _ARRAYS}}
    watched: dict[str, dict[str, Any]] = {}
    for name, values in groups["watched"].items():
        watch, _, key = name.partition("/")
        watched.setdefault(watch, {})[key] = values
    memory = head.get("memory", {})
    return Record(
        status=head["status"], reason=head["reason"], summary=head["summary"], events=head["events"],
        curves={
            name: [ContactCurve.of_table(groups["curves"][f"{name}/{k}"], memory.get(name, ())) for k in range(count)]
            for name, count in head["curves"].items()
        },
        watched=watched,
        **fields,
    )  # fmt: skip
