"""`contactlab view`: look at the timeline of a run or of a comparison, or take a picture of it."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from shutil import rmtree

from contactlab.api.recorder import Recorder
from contactlab.commands.common import console
from contactlab.errors import ContactlabError, RequestError
from contactlab.parts.registry import Registry, default_registry
from contactlab.results.load import load_results
from contactlab.results.result_file import FILE
from contactlab.run.recorders import record_again
from contactlab.studies.recordings import checked_names, is_comparison, left_out, main_runs_of, runs_of, titled_runs

PANEL = "panel"
"""Folder of the recording of one panel that was asked for."""
CHOSEN = "chosen"
"""Folder of the recording of runs that were asked for by name, beside that of the comparison."""


def view(options: argparse.Namespace) -> int:
    """Open the viewer, or write a picture and say where."""
    if options.step is not None and options.png is None:
        raise RequestError(
            "a step is for pictures", where="--step", hint="add --png FILE; in the viewer, move the cursor"
        )
    recorder = _showing_recorder(default_registry())
    path = Path(options.path)
    if options.runs and (path.is_file() or (path / FILE).is_file()):
        raise RequestError("runs are chosen of a comparison", where="--runs", got=str(path), allowed="its folder")
    if options.panel:
        file = _one_panel(path, recorder, options)
    else:
        file = path if path.is_file() else recording_in(path, recorder, options.runs)
    png = _writable(Path(options.png)) if options.png is not None else None
    if not path.is_file() and not options.runs and (more := left_out(path)):
        console().print(more, markup=False, highlight=False, soft_wrap=True)
    try:
        recorder.show(file, png, options.step)
    except ValueError as error:
        raise RequestError(str(error), where=str(file)) from error
    except RuntimeError as error:
        raise ContactlabError(f"{file}: {error}") from error
    if png is not None:
        console().print(f"picture: {png}", markup=False, highlight=False, soft_wrap=True)
    return 0


def _one_panel(path: Path, recorder: Recorder, options: argparse.Namespace) -> Path:
    """A recording of one panel alone, made anew from the results, in a folder beside that of all of them."""
    if not path.is_dir() or not hasattr(recorder, "panel"):
        raise RequestError("panels are taken from results", where="--panel", got=str(path), allowed="a folder of a run")
    folder = path / PANEL
    known, alone = folder.exists(), replace(recorder, panel=options.panel)  # type: ignore[type-var]
    folder.mkdir(parents=True, exist_ok=True)
    try:
        if (path / FILE).is_file():
            record_again(alone, folder, load_results(path))
        else:
            names = checked_names(path, options.runs) if options.runs else main_runs_of(path)
            alone.compared(folder, titled_runs(runs_of(path, names)))
    except ValueError as error:
        if not known:
            rmtree(folder)
        raise RequestError(str(error), where="--panel") from error
    return folder / recorder.shown_file


def _showing_recorder(registry: Registry) -> Recorder:
    """The first installed recorder whose recordings can be looked at."""
    for name in registry.names("recorder"):
        if registry.part_class("recorder", name).shown_file:
            recorder: Recorder = registry.make("recorder", name)
            return recorder
    raise RequestError(
        "no installed recorder makes recordings that can be looked at",
        where="view",
        hint="install a plugin with such a recorder; contactlab parts lists what there is",
    )


def recording_in(folder: Path, recorder: Recorder, names: Sequence[str] = ()) -> Path:
    """The recording of the run or comparison in `folder`; it is made from the results where it is not there.

    With `names` of runs of a comparison one of these alone, in a folder of its own; so is that of runs side by side in
    a folder that is no comparison's.

    That is so for runs that were killed or are still going on: they are shown as far as they came.
    """
    if not folder.is_dir():
        raise RequestError(
            "there is no such file or folder", where=str(folder), allowed="the folder of a run, or a recording"
        )
    file = folder / recorder.shown_file
    if (folder / FILE).is_file():
        results = load_results(folder)
        if not file.is_file() or not results.closed:
            record_again(recorder, folder, results)
        return file
    if not names and file.is_file():
        return file
    runs = titled_runs(runs_of(folder, checked_names(folder, names) if names else main_runs_of(folder)))
    if not runs:
        raise RequestError(
            "the folder holds no results", where=str(folder), allowed="the folder of a run, of runs or of a comparison"
        )
    if names or not is_comparison(folder):  # more runs may come to it: what is shown is made anew each time
        file = folder / CHOSEN / recorder.shown_file
        file.parent.mkdir(exist_ok=True)
    recorder.compared(file.parent, runs)
    return file


def _writable(png: Path) -> Path:
    """The place of the picture. Raises RequestError where nothing can be written there."""
    if png.suffix.lower() != ".png":
        raise RequestError("pictures are PNG files", where="--png", got=str(png), allowed="a name that ends in .png")
    if not png.resolve().parent.is_dir():
        raise RequestError("there is no such folder", where="--png", got=str(png))
    return png
