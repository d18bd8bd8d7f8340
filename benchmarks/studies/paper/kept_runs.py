"""Runs of the paper's figures, kept in an archive: what is there is not run again.

The folder is runs/paper, or another that `use` names. With `only_kept` nothing is run at all: figures are drawn from
the newest runs of the archive, also where sources have changed since.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import mkdtemp
from time import process_time

import contactlab
from contactlab.api import Floats, Job, Record
from contactlab.jobs.archive import FILE, Archive, StoredRun
from contactlab.jobs.keys import row_key
from contactlab.jobs.record import record_of, to_bytes
from contactlab.jobs.system import machine
from contactlab.results.results import Results
from contactlab.scene.scene import Scene

NAME = "paper"
FIELDS = Job(NAME, "", fields=True)
"""What is kept of every run: history, curves, and the fields at its end."""

More = Callable[[Results], Mapping[str, Floats]]
"""What is kept besides, found in the stored frames; in `Record.watched` by the function's name."""


class MissingRunError(LookupError):
    """A run that the archive does not hold."""


@dataclass
class Source:
    """Where runs come from: the folder of an archive, and whether what it lacks is run."""

    folder: Path
    only_kept: bool = False


source = Source(Path(__file__).parents[3] / "runs" / NAME)


def use(folder: Path, *, only_kept: bool) -> None:
    """Take runs from the archive in this folder from now on."""
    source.folder, source.only_kept = folder, only_kept


def run(scene: Scene, more: More | None = None) -> Record:
    """The record of a scene, from the archive or made now. Raises MissingRunError with `only_kept`."""
    scene = scene.with_({"record.recorders": ["vtkhdf"] if more else []})
    name = f"{NAME} {more.__name__}" if more else NAME
    if source.only_kept:
        return _newest(scene, name)
    key = row_key(scene, name)
    source.folder.mkdir(parents=True, exist_ok=True)
    with Archive(source.folder / FILE) as archive:
        record = archive.record(key, machine())
        if record is None:
            began = process_time()
            record = _made(scene, more)
            work = record.summary["steps"] + record.summary.get("iterations", 0)
            end = (record.status, record.reason, work, process_time() - began, to_bytes(record))
            archive.add_run(StoredRun(key, name, scene.toml(), *end, machine()))
    return record


def _made(scene: Scene, more: More | None) -> Record:
    folder = Path(mkdtemp())
    try:
        results = contactlab.simulate(scene, out=folder / "run" if more else None)
        record = record_of(results, FIELDS)
        return replace(record, watched={more.__name__: more(results)}) if more else record
    finally:
        shutil.rmtree(folder)


def _newest(scene: Scene, name: str) -> Record:
    with Archive(source.folder / FILE, write=False) as archive:
        record = archive.newest(name, scene.toml())
    if record is None:
        raise MissingRunError(f"{source.folder / FILE} holds no run of {scene.name} with these settings: make paper")
    return record


def held(folder: Path) -> bool:
    """Whether the archive of a folder holds any run of the paper's figures."""
    with Archive(folder / FILE, write=False) as archive:
        return any(kept["name"].split()[0] == NAME for kept in archive.runs())
