"""The recorders of a run, and opening them."""

from __future__ import annotations

import shutil
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from contactlab.api.frame import Layout
from contactlab.api.recorder import Recorder, Recording, replay
from contactlab.errors import ContactlabWarning, Location, RequestError, SceneError, one_line
from contactlab.meshing.room import in_words
from contactlab.parts.registry import Registry
from contactlab.results.results import Results
from contactlab.scene.scene import Scene


def recorders_of(scene: Scene, registry: Registry) -> dict[str, Recorder]:
    """The recorders that the scene names, or those that are there by default, by a name of their own."""
    specs = scene.record.recorders
    if specs is None:
        return {name: registry.make("recorder", name) for name in default_recorders(registry)}
    found = {}
    for number, spec in enumerate(specs):
        where = scene.where(f"record.recorders.{number}")
        name = spec["use"] if spec["use"] not in found else f"{spec['use']} ({number})"
        found[name] = registry.make("recorder", spec, where)
    return found


def default_recorders(registry: Registry) -> list[str]:
    """Names of the installed recorders that are used if a scene names none."""
    return [name for name in registry.names("recorder") if registry.part_class("recorder", name).by_default]


def at_work(recorders: Mapping[str, Recorder]) -> dict[str, Recorder]:
    """Return recorders that work during a run. If results are stored, files for viewing are made of them later."""
    stored = any(recorder.stores_results for recorder in recorders.values())
    return {name: recorder for name, recorder in recorders.items() if not (stored and recorder.shown_file)}


def when_over(recorders: Mapping[str, Recorder]) -> dict[str, Recorder]:
    """Return recorders that work on stored results when a run ends; the rest do so when their file is opened."""
    working = at_work(recorders)
    return {name: r for name, r in recorders.items() if name not in working and not r.on_view}


def check_disk_space(
    recorders: Mapping[str, Recorder],
    folder: Path,
    layout: Layout,
    steps: int,
    memory: float,
    record: float,
    where: Location,
) -> None:
    """Raise SceneError if the files of a run will not fit on the disk, in addition to what is there already.

    memory, record  bytes that a restart needs, and of the contact record and of states after iterations
    """
    wanted = sum(recorder.disk_bytes(layout, steps, memory) for recorder in recorders.values())
    wanted += record
    there = sum(path.stat().st_size for path in folder.iterdir() if path.is_file())
    free = shutil.disk_usage(folder).free
    if wanted - there > free:
        raise SceneError(
            "not enough free disk space",
            where=where,
            got=f"{layout.frames} frames of {len(layout.nodes)} nodes, {steps} steps: about {in_words(wanted)}",
            allowed=f"what fits into {in_words(free + there)} in {folder}",
            hint="fewer frames, a coarser mesh, or a folder on another disk",
        )


def open_recordings(
    recorders: Mapping[str, Recorder], folder: Path, layout: Layout, past: Any = None
) -> dict[str, Recording]:
    """The recordings of a run in `folder`; of an interrupted run `past` they are continued.

    A recorder that works later is only checked; what it made of the run before is removed.
    Raises RequestError if the folder cannot be written or a recorder cannot begin.
    """
    opened: dict[str, Recording] = {}
    working = at_work(recorders)
    for name, recorder in recorders.items():
        try:
            if name not in working:
                recorder.check(layout)
                (folder / recorder.shown_file).unlink(missing_ok=True)
                continue
            opened[name] = recorder.open(folder, layout) if past is None else recorder.resume(folder, layout, past)
        except RequestError:
            raise
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise RequestError(f"no results can be written here: {reason}", where=f"results folder {folder}") from error
        except Exception as error:
            raise RequestError(
                f"the recorder {name} cannot begin: {one_line(error)}",
                where="record.recorders",
                hint="name other recorders, or repair this recorder",
            ) from error
    return opened


def record_stored(recorders: Mapping[str, Recorder], folder: Path, run: Results) -> None:
    """Let these recorders make their files of a run that is stored; what fails is a warning."""
    for name, recorder in recorders.items():
        try:
            record_again(recorder, folder, run)
        except OSError as error:
            place = folder if error.filename is None else error.filename
            text = f"{name} cannot write to {place}: {(error.strerror or str(error)).lower()}; the results are complete"
            warnings.warn(text, ContactlabWarning, stacklevel=3)
        except (Exception, SystemExit) as error:
            text = f"the recorder {name} failed: {one_line(error)}; the results are complete"
            warnings.warn(text, ContactlabWarning, stacklevel=3)


def record_again(recorder: Recorder, folder: Path, run: Results) -> None:
    """Make a recording of what a run has stored."""
    recording = recorder.open(folder, run.layout)
    kinds = (recorder.every_step, recorder.every_contact, recorder.every_field, recorder.every_iterate)
    replay(run, recording, *kinds)
    recording.close(run.summary)
