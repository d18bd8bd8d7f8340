"""A recording on disk: what is logged of all its runs, and in which order."""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any
from uuid import uuid4

import numpy as np
import rerun as rr

from contactlab_rerun.blueprint import Shown, blueprint
from contactlab_rerun.drawing import FEW_CELLS, OUTLINE, Drawing, Scale, model_box
from contactlab_rerun.gathered import Gathered, Look, nice
from contactlab_rerun.notes import log_events, log_lanes, log_page
from contactlab_rerun.plots import Plot, log_axes, log_colour_bar, log_curves, log_legend, plot_for
from contactlab_rerun.series import SeriesWriter

if TYPE_CHECKING:
    from contactlab_rerun.recorder import Rerun

APPLICATION = "contactlab"
MOST_LANES = 12  # in the view of a comparison
ROOM = 1 << 20  # bytes of disk that must be left: the library does not tell when there are none


class TimelineFile:
    """One recording; it has another name until `finish`, so that half of one is never taken for all."""

    def __init__(self, path: Path, options: Rerun, timeline: str) -> None:
        self.path, self.options, self.timeline = path, options, timeline
        self.present = path.with_name(path.name + ".new")
        self.recording = rr.RecordingStream(APPLICATION, recording_id=uuid4())
        self.recording.save(self.present)
        self.runs: list[tuple[Gathered, Look, SeriesWriter]] = []

    def begin(self, run: Gathered, look: Look) -> SeriesWriter:
        """One more run; its steps go to what is given back, its frames to `run`."""
        writer = SeriesWriter(self.recording, run.layout, look)
        self.runs.append((run, look, writer))
        return writer

    def finish(self, summaries: Sequence[Mapping[str, Any]]) -> None:
        """Write everything that waited for the end. Raises OSError where the disk is full."""
        _need_room(self.path.parent)
        for run, _, writer in self.runs:
            run.finish()
            writer.flush()
            writer.log_styles(several=len(self.runs) > 1)
        shown = self._draw()
        plots = self._plot()
        for (run, look, _), summary in zip(self.runs, summaries, strict=True):
            log_lanes(self.recording, run, look, self._lanes())
            log_events(self.recording, run, look)
            log_page(self.recording, run.layout, look, summary)
        self.recording.send_recording_name(self.runs[0][0].layout.title)
        self.recording.send_blueprint(blueprint(shown, plots, self.timeline), make_active=True, make_default=True)
        self.recording.disconnect()
        _need_room(self.path.parent)
        self.present.replace(self.path)

    def _lanes(self) -> int:
        return self.options.lanes if len(self.runs) == 1 else max(1, MOST_LANES // len(self.runs))

    def _draw(self) -> list[Shown]:
        low, high = model_box([run for run, _, _ in self.runs])
        top = nice(max(run.top for run, _, _ in self.runs))
        pressure = max(run.largest("pressure") for run, _, _ in self.runs) or 1.0
        scale = Scale(top, pressure, float((high - low).max()))
        shown = []
        for run, look, writer in self.runs:
            outline = look.colour if len(self.runs) > 1 else OUTLINE
            Drawing(self.recording, run, look, scale, outline, self._wired(run)).draw()
            box = np.asarray(low, float), np.asarray(high, float)
            if self.options.field != "none":
                label = _label(self.options.field, run.layout.units)
                box = log_colour_bar(self.recording, look.path, label, top, *box)
            shown.append(Shown(look, run, box, writer.shown()))
        return shown

    def _wired(self, run: Gathered) -> bool:
        few = sum(len(body.cells) for body in run.layout.bodies) <= FEW_CELLS
        return few if self.options.wire == "auto" else bool(self.options.wire)

    def _plot(self) -> list[Plot]:
        """Axes for each slave surface, with the curves of all runs on it."""
        plots = []
        for number, slave in enumerate(dict.fromkeys(c.slave for run, _, _ in self.runs for c in run.layout.contacts)):
            these = [
                (contact.name, run, look)
                for run, look, _ in self.runs
                for contact in run.layout.contacts
                if contact.slave == slave
            ]
            contact = next(c for c in these[0][1].layout.contacts if c.slave == slave)
            plot = plot_for(contact, [(name, run) for name, run, _ in these], f"/axes/{number}")
            log_axes(self.recording, plot)
            if len(self.runs) > 1:
                log_legend(self.recording, plot, [look for _, _, look in these])
            for name, run, look in these:
                log_curves(self.recording, plot, run, look, name)
            plots.append(plot)
        return plots


def _label(field: str, units: str) -> str:
    from contactlab.api.units import Units

    pressure = Units.of_label(units).pressure
    if field == "von_mises":
        return f"von Mises stress [{pressure}]" if pressure else "von Mises stress"
    return field.replace("_", " ")


def _need_room(folder: Path) -> None:
    if shutil.disk_usage(folder).free < ROOM:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(folder))
