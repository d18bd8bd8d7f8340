"""The file that is looked at, of a run or of several: the one that is there, or one made from the results."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from contactlab.api.recorder import Recorder
from contactlab.errors import RequestError
from contactlab.parts.registry import Registry, default_registry
from contactlab.results.load import load_results
from contactlab.results.result_file import FILE
from contactlab.results.results import Results
from contactlab.run.recorders import record_again
from contactlab.scene.toml_text import parse_toml
from contactlab.studies.recordings import checked_names, is_comparison, main_runs_of, runs_of, titled_runs

CHOSEN = "chosen"
"""Folder of the recording of runs requested by name, next to the comparison's recording."""
SO_FAR = "so-far-"
"""Prefix of the recording's name for a run that has not ended, or for several runs: it is made again each time."""


def showing_recorder(registry: Registry) -> Recorder | None:
    """The first installed recorder whose recordings can be looked at; None without such a recorder."""
    for name in registry.names("recorder"):
        if registry.part_class("recorder", name).shown_file:
            recorder: Recorder = registry.make("recorder", name)
            return recorder
    return None


def can_be_shown(folder: Path, registry: Registry) -> bool:
    """Return whether the folder of a run or comparison has a recording, or data to make one."""
    recorder = showing_recorder(registry)
    if recorder is None:
        return False
    return any((folder / name).is_file() for name in (recorder.shown_file, FILE)) or bool(main_runs_of(folder))


def as_asked(recorder: Recorder, run: Results) -> Recorder:
    """The recorder with the fields that the scene of a run gives it; as it is if the scene does not name it."""
    registry = default_registry()
    record: Mapping[str, Any] = parse_toml(run.layout.scene, "scene.toml").get("record", {})
    for spec in record.get("recorders", ()):
        name = spec if isinstance(spec, str) else spec["use"]
        if name in registry.names("recorder") and registry.part_class("recorder", name) is type(recorder):
            asked: Recorder = registry.make("recorder", spec)
            return asked
    return recorder


def recording_in(folder: Path, recorder: Recorder, names: Sequence[str] = ()) -> Path:
    """The recording of the run or comparison in `folder`; a missing one is made from the results.

    With `names` of runs of a comparison it has these alone, in a folder of its own; so has a recording of runs side by
    side in a folder without a comparison. Runs that were killed or are still running are shown as far as they came.
    """
    if not folder.is_dir():
        raise RequestError(
            "there is no such file or folder",
            where=str(folder),
            got=str(folder),
            allowed="the folder of a run, or a recording",
        )
    file = folder / recorder.shown_file
    if (folder / FILE).is_file():
        return recording_of(load_results(folder), folder, recorder)
    if not names and file.is_file():
        return file
    runs = titled_runs(runs_of(folder, checked_names(folder, names) if names else main_runs_of(folder)))
    if not runs:
        raise RequestError(
            "the folder holds no results", where=str(folder), allowed="the folder of a run, of runs or of a comparison"
        )
    if names or not is_comparison(folder):  # more runs may come to it: the recording is made again each time
        file = folder / CHOSEN / recorder.shown_file
        file.parent.mkdir(exist_ok=True)
    as_asked(recorder, next(iter(runs.values()))).compared(file.parent, runs)
    return file if all(run.closed for run in runs.values()) else _so_far(file)


def recording_of(run: Results, folder: Path, recorder: Recorder) -> Path:
    """The recording of a run in `folder`: the one that is there, or a new one."""
    file = folder / recorder.shown_file
    if not run.closed or not file.is_file():
        record_again(as_asked(recorder, run), folder, run)
    return file if run.closed else _so_far(file)


def _so_far(file: Path) -> Path:
    """Return the file, renamed as soon out of date; without frames there is no file."""
    return file.replace(file.with_name(SO_FAR + file.name)) if file.is_file() else file
