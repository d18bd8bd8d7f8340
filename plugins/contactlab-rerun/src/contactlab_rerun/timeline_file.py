"""A recording on disk: what is logged of all its runs, and in which order."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import rerun as rr

from contactlab.api.drawing.units import Units
from contactlab_rerun.blueprint import Shown, arrange
from contactlab_rerun.colour_bar import log_colour_bar, log_state_key
from contactlab_rerun.convergence import log_convergence
from contactlab_rerun.drawing import FEW_CELLS, OUTLINE, Drawing, Scale, model_box
from contactlab_rerun.gathered import NO_FIELD, PRESSURE, VON_MISES, Appearance, Gathered, nice
from contactlab_rerun.iterations import log_newton
from contactlab_rerun.length_curves import log_lengths
from contactlab_rerun.memory_curves import log_memories
from contactlab_rerun.node_tables import log_tables
from contactlab_rerun.notes import log_events, log_iterations, log_page, log_state_tracks, track_folders
from contactlab_rerun.opening import OPENS
from contactlab_rerun.profiles import Profile, log_profile, profile_of
from contactlab_rerun.recorder import Rerun
from contactlab_rerun.series import SeriesWriter
from contactlab_rerun.step_pictures import log_pictures
from contactlab_rerun.stream import FileStream, drop_streams

MOST_TRACKS = 12  # in the view of a comparison
MESHES = 0.25e6  # bytes of all meshes and their lines in a recording, if the scene does not say which frames are drawn


class TimelineFile:
    """A recording file; it has another name until `finish`, so that a partial file is never taken for a whole one."""

    def __init__(self, path: Path, options: Rerun, timeline: str) -> None:
        self.path, self.options, self.timeline = path, options, timeline
        self.present = path.with_name(path.name + ".new")
        self.stream: FileStream | None = FileStream(self.present)
        self.recording = self.stream.stream
        self.error: OSError | None = None
        self.runs: list[tuple[Gathered, Appearance, SeriesWriter]] = []

    def open_run(self, run: Gathered, appearance: Appearance) -> SeriesWriter:
        """Add a run; its steps go to the returned writer, its frames to `run`."""
        writer = SeriesWriter(self.recording, run, appearance)
        self.runs.append((run, appearance, writer))
        return writer

    def finish(self, summaries: Sequence[Mapping[str, Any]]) -> None:
        """Write everything that waited for the end. Raises OSError if the disk is full."""
        try:
            if all(run.instants for run, _, _ in self.runs):
                self._finish(summaries)
            self._close()
            if self.error is not None:
                raise OSError(self.error.errno, self.error.strerror, str(self.present))
        except BaseException:
            self.abandon()
            raise
        self.present.replace(self.path)

    def abandon(self) -> None:
        """Close the file and delete it."""
        self._close()
        self.present.unlink(missing_ok=True)

    def _close(self) -> None:
        """Whoever writes steps must have let go of the stream, or its threads stay until the next file is closed."""
        if self.stream is not None:
            self.stream.close()
            self.error = self.stream.error
            self.runs.clear()
            del self.recording
            self.stream = None
            drop_streams()

    def _finish(self, summaries: Sequence[Mapping[str, Any]]) -> None:
        several = len(self.runs) > 1
        for (run, _, writer), summary in zip(self.runs, summaries, strict=True):
            run.finish(summary)
            writer.flush()
            writer.log_styles(several)
        self.runs = [
            (run, replace(appearance, title=_ended(appearance.title, summary)), writer)
            for (run, appearance, writer), summary in zip(self.runs, summaries, strict=True)
        ]
        shown, profiles = self._draw(), self._profiles()
        shown = [
            replace(
                one,
                pictures=log_pictures(
                    self.recording, one.run, one.appearance, Units.of_label(one.run.layout.units).pressure
                ),
                active_sets=log_newton(self.recording, one.run, one.appearance),
            )
            for one in shown
        ]
        converged = log_convergence(
            self.recording, [(run, appearance) for run, appearance, _ in self.runs], 2.0 * self._hang
        )
        for (run, appearance, _), summary in zip(self.runs, summaries, strict=True):
            tracks = self.options.lanes if len(self.runs) == 1 else max(1, MOST_TRACKS // len(self.runs))
            log_state_tracks(self.recording, run, track_folders(run, appearance, several), tracks)
            log_events(self.recording, run, appearance, several)
            log_iterations(self.recording, run, appearance)
            log_page(self.recording, run, appearance, summary)
            if not several:
                log_tables(self.recording, run, appearance, shown[0].frames)
        self.recording.send_recording_name(self.runs[0][0].layout.title)
        if not several and (window := self.runs[0][0].window()):
            self.recording.send_property(OPENS, rr.AnyValues(step=window[1]))
        arrange(shown, profiles, converged, self.timeline, self.options.panel).send(self.recording)

    @property
    def _hang(self) -> float:
        """Labels hang by pixels, and the plots of comparisons are smaller."""
        return 0.035 if len(self.runs) == 1 else 0.07

    def _draw(self) -> list[Shown]:
        low, high = model_box([run for run, _, _ in self.runs])
        ends = [run.extent for run, _, _ in self.runs]
        field = -nice(-min(ends)[0]) if min(ends)[0] < 0.0 else 0.0, nice(max(top for _, top in ends))
        pressure = max(run.largest_pressure for run, _, _ in self.runs) or 1.0
        scale = Scale(*field, pressure, float((high - low).max()), float(np.abs([low, high]).max()))
        shown = []
        for run, appearance, writer in self.runs:
            outline = appearance.colour if len(self.runs) > 1 else OUTLINE
            # bytes that the meshes of a run may take
            room = MESHES / len(self.runs) if self.options.every == "auto" else math.inf
            few = sum(len(body.cells) for body in run.layout.bodies) <= FEW_CELLS
            wired = few if self.options.wire == "auto" else bool(self.options.wire)
            drawing = Drawing(self.recording, run, appearance, scale, outline, wired, room)
            drawing.draw()
            box = np.asarray(low, float), np.asarray(high, float)
            if run.layout.contacts:
                log_state_key(self.recording, appearance.path, *box, run.frictional, scale.distance)
            if self.options.field != NO_FIELD:
                name = {VON_MISES: "von Mises stress"}.get(self.options.field, self.options.field.replace("_", " "))
                unit = Units.of_label(run.layout.units).pressure if self.options.field in (VON_MISES, PRESSURE) else ""
                label = f"{name} [{unit}]" if unit else name
                box = log_colour_bar(self.recording, appearance.path, label, field, *box, scale.distance)
            shown.append(Shown(appearance, run, box, writer.shown(), drawing.frames))
        return shown

    def _profiles(self) -> list[Profile]:
        """Plots for each slave surface, with curves of all runs: pressures first, then memories, gaps and slips."""
        pressures, memories, lengths = [], [], []
        for number, slave in enumerate(dict.fromkeys(c.slave for run, _, _ in self.runs for c in run.layout.contacts)):
            these = [
                (contact.name, run, appearance)
                for run, appearance, _ in self.runs
                for contact in run.layout.contacts
                if contact.slave == slave
            ]
            contact = next(c for c in these[0][1].layout.contacts if c.slave == slave)
            profile = profile_of(contact, [(name, run) for name, run, _ in these], f"/axes/{number}", self._hang)
            log_profile(self.recording, profile, these)
            pressures.append(profile)
            memories += log_memories(self.recording, profile, these)
            lengths += [log_lengths(self.recording, profile, these, what) for what in ("gap", "slip")]
        return [*pressures, *memories, *(profile for profile in lengths if profile)]


def _ended(title: str, summary: Mapping[str, Any]) -> str:
    """The title of a run, and its status if it ended early."""
    status = summary.get("status", "finished")
    return title if status == "finished" else f"{title} ({status} at step {summary.get('steps', 0)})"
