"""Trials that were made before: an archive in the user's cache, like the archives of results folders."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict

from contactlab.api import Job
from contactlab.api.compiled.cache import cache_root
from contactlab.errors import RequestError
from contactlab.explanation.trial_run import SHARE, TrialRun, run_trial
from contactlab.jobs.archive import Archive, StoredRun
from contactlab.jobs.keys import run_key
from contactlab.jobs.record import ended, from_bytes, to_bytes
from contactlab.jobs.system import machine
from contactlab.scene.scene import Scene

FILE = "trials.sqlite"
TRIAL = Job("trial", "")
Tried = Callable[["Scene"], TrialRun | None]
"""The trial of a scene, if there is one; made now, if the function makes trials."""


@contextmanager
def trials() -> Iterator[Archive | None]:
    """The archive of trials on this machine; None if the cache cannot be written."""
    archive = None
    with suppress(RequestError, OSError):
        cache_root().mkdir(parents=True, exist_ok=True)
        archive = Archive(cache_root() / FILE)
    try:
        yield archive
    finally:
        if archive is not None:
            archive.close()


def kept(scene: Scene, archive: Archive | None) -> TrialRun | None:
    """The trial of a scene with this content, these sources and on this machine."""
    record = archive.record(run_key(TRIAL, scene), machine()) if archive is not None else None
    return None if record is None else TrialRun.from_data(record.summary["trial"])


def tried(scene: Scene, archive: Archive | None) -> TrialRun:
    """The kept trial of a scene, or one made now and kept. Raises SimulationFailure if the first steps fail."""
    found = kept(scene, archive)
    if found is None:
        found = run_trial(scene, SHARE)
        if archive is not None and found.begin is not None:
            begin = found.begin
            content = to_bytes(ended(begin.status, begin.reason, trial=asdict(found)))
            archive.add_run(
                StoredRun(
                    run_key(TRIAL, scene), scene.name, scene.toml(), begin.status, begin.reason,
                    begin.steps + begin.iterations, begin.cpu_s, content, machine(),
                )
            )  # fmt: skip
            found = TrialRun.from_data(from_bytes(content).summary["trial"])
    return found
