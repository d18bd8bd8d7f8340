"""`contactlab view`: look at the timeline of a run or of a comparison, or take a picture of it."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from shutil import rmtree

from contactlab.api.recorder import Recorder
from contactlab.commands.common import console
from contactlab.errors import ContactlabError, RequestError
from contactlab.parts.registry import Registry, default_registry
from contactlab.results.load import load_results
from contactlab.results.result_file import FILE
from contactlab.results.results import Results
from contactlab.run.recorders import record_again
from contactlab.studies.recordings import checked_names, left_out, main_runs_of, runs_of, titled_runs
from contactlab.studies.shown_file import as_asked, recording_in, showing_recorder

PANEL = "panel"
"""Folder of the recording of a single panel."""


def view(options: argparse.Namespace) -> int:
    """Open the viewer, or write a picture and say where."""
    _check_place(options)
    recorder = _recorder(default_registry())
    if not options.path:
        raise RequestError("no folder is given", where="DIR-or-RRD", got="", allowed="a folder or a recording")
    path = Path(options.path)
    if options.runs and (path.is_file() or (path / FILE).is_file()):
        raise RequestError("--runs needs a comparison", where="--runs", got=str(path), allowed="its folder")
    if options.panel:
        file = _one_panel(path, recorder, options)
    else:
        file = path if path.is_file() else recording_in(path, recorder, options.runs)
    png = _writable(Path(options.png)) if options.png is not None else None
    if not path.is_file() and not options.runs and (more := left_out(path)):
        console().say(more)
    try:
        at = {} if options.iteration is None else {"iteration": options.iteration}
        recorder.show(file, png, options.step, **at)
    except ValueError as error:
        raise RequestError(str(error), where=str(file)) from error
    except RuntimeError as error:
        raise ContactlabError(f"{file}: {error}") from error
    if png is not None:
        console().say(f"picture: {png}")
    return 0


def _check_place(options: argparse.Namespace) -> None:
    """Raise RequestError for a step or iteration of no picture, or for both."""
    for name in ("step", "iteration"):
        if getattr(options, name) is not None and options.png is None:
            raise RequestError(
                f"{'an' if name == 'iteration' else 'a'} {name} is for pictures",
                where=f"--{name}",
                hint="add --png FILE; in the viewer, move the cursor",
            )
    if options.step is not None and options.iteration is not None:
        raise RequestError("a picture shows a step or an iteration", where="--iteration", hint="omit one of them")


def _one_panel(path: Path, recorder: Recorder, options: argparse.Namespace) -> Path:
    """A recording of one panel alone, made from the results, in a folder next to the folder of all panels."""
    if not path.is_dir() or not hasattr(recorder, "panel"):
        raise RequestError("--panel needs results", where="--panel", got=str(path), allowed="a folder of a run")
    folder = path / PANEL
    known = folder.exists()
    folder.mkdir(parents=True, exist_ok=True)
    try:
        if (path / FILE).is_file():
            run = load_results(path)
            record_again(_panel_of(recorder, run, options.panel), folder, run)
        else:
            names = checked_names(path, options.runs) if options.runs else main_runs_of(path)
            runs = titled_runs(runs_of(path, names))
            _panel_of(recorder, next(iter(runs.values()), None), options.panel).compared(folder, runs)
    except ValueError as error:
        if not known:
            rmtree(folder)
        raise RequestError(str(error), where="--panel") from error
    return folder / recorder.shown_file


def _panel_of(recorder: Recorder, run: Results | None, panel: str) -> Recorder:
    """The recorder that shows this panel alone, else as the scene of the run says."""
    asked = recorder if run is None else as_asked(recorder, run)
    return replace(asked, panel=panel)  # type: ignore[type-var]


def _recorder(registry: Registry) -> Recorder:
    """The recorder with a viewer. Raises RequestError if none is installed."""
    recorder = showing_recorder(registry)
    if recorder is None:
        raise RequestError(
            "no installed recorder makes recordings for a viewer",
            where="view",
            hint=" ".join(["pip install", *registry.missing_packages(optional=False)]) + ", which usually has one",
        )
    return recorder


def _writable(png: Path) -> Path:
    """Path of the picture. Raises RequestError if it cannot be written."""
    if png.suffix.lower() != ".png":
        raise RequestError("pictures are PNG files", where="--png", got=str(png), allowed="a name that ends in .png")
    if not png.resolve().parent.is_dir():
        raise RequestError("there is no such folder", where="--png", got=str(png), allowed="an existing folder")
    return png
