"""Samples of a run in memory, and dispatch of frames and events to recorders."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from contactlab.api import Floats
from contactlab.api.frame import Event, Frame, Iterate, IterationRow, Layout, Level
from contactlab.api.recorder import Recording
from contactlab.errors import ContactlabWarning, SimulationFailure, one_line
from contactlab.model.model import Model
from contactlab.results.files import HistoryFile, IterationFile, plain, write_contacts, write_summary
from contactlab.results.frame import frame_of
from contactlab.results.peaks import Peaks
from contactlab.results.results import ContactHistory, Results
from contactlab.results.sample import Sample

if TYPE_CHECKING:
    from contactlab.results.contact_sampler import ContactSampler
    from contactlab.results.record_plan import Window
    from contactlab.results.steps import Sample as StepSample
    from contactlab.results.steps import StepSampler


class Journal:
    """Samples of one run in memory; frames, steps and events go to its recordings, by the recorder's name.

    `wanted` names the recordings that want every step's scalars ("steps"), the contact record ("contact_steps"), states
    after iterations ("iterates") and all of the last steps ("last_steps"); `window` says which steps the contact record
    takes. With `past`, an interrupted run is resumed where it was saved. `share` is the fraction of the run that is
    done at a time [s].
    """

    def __init__(
        self,
        model: Model,
        layout: Layout,
        recordings: Mapping[str, Recording],
        wanted: Mapping[str, frozenset[str]],
        history_file: HistoryFile | None = None,
        past: Results | None = None,
        window: Window | None = None,
        share: Callable[[float], float] = float,
    ) -> None:
        self.share = share
        self.model, self.layout = model, layout
        self.folder = history_file.folder if history_file is not None else None
        self.recordings = dict(recordings)
        self.rows: list[dict[str, float]] = []
        self.contact = {contact.name: ContactHistory() for contact in layout.contacts}
        self.events: list[Event] = []
        self.iterations: list[IterationRow] = []
        self.iteration_file: IterationFile | None = None
        self.last: Sample | None = None
        self.peaks = Peaks(layout, model.explicit)
        self.full = False
        self.wanted = wanted
        self.step_sampler = self._every_step_sampler() if wanted["steps"] else None
        self.samplers: list[StepSampler | ContactSampler] = []
        if self.step_sampler is not None:
            self.samplers.append(self.step_sampler)
        if wanted["contact_steps"] and window is not None:
            self.samplers.append(self._contact_sampler(window))
        if past is not None:
            self._take_up(past)
        self.history_file = history_file
        if history_file is not None:
            history_file.replace_rows(self.rows)

    @property
    def every_step(self) -> tuple[StepSample, ...]:
        """Callbacks after each step, with the step and its length: none if no recorder wants anything."""
        return tuple(sampler.sample for sampler in self.samplers)

    @property
    def restartable(self) -> bool:
        """Return whether any recording keeps the data for a restart."""
        return any(recording.keeps_state for recording in self.recordings.values())

    @property
    def last_step(self) -> int:
        """Step of the last stored frame."""
        return int(self.rows[-1]["step"]) if self.rows else 0

    @property
    def largest_force(self) -> float:
        """Largest force [N] of a support or a contact at any stored frame."""
        pairs = [name.removesuffix(".fx") for name in (self.rows[0] if self.rows else {}) if name.endswith(".fx")]
        return max((math.hypot(row[f"{on}.fx"], row[f"{on}.fy"]) for row in self.rows for on in pairs), default=0.0)

    @property
    def largest_work(self) -> float:
        """Largest sum [mJ] of the works of the stresses and of all from outside at any stored frame, by magnitude."""
        return max((abs(row["energy.internal"]) + abs(row["energy.external"]) for row in self.rows), default=0.0)

    @property
    def frames(self) -> int:
        """Number of frames stored so far."""
        return len(self.rows)

    def add(self, sample: Sample) -> None:
        """Store a sample of the present state, and give recorders a frame of it."""
        row = sample.scalars()
        self.rows.append(row)
        self.peaks.frame(row)
        self.last = sample
        for name, report in sample.contacts.items():
            self.contact[name].times.append(sample.time)
            self.contact[name].curves.append(report.curve)
        if self.history_file is not None:
            self._or_stop("history.csv", lambda file: file.add(row), self.history_file)
        self._flush()
        if self.recordings:
            frame: Frame = frame_of(self.model, sample)
            self._tell("frame", lambda recording: recording.frame(frame))
            for recording in list(self.recordings.values()):
                for text in recording.news():
                    self.tell("info", text)

    def saved(self) -> dict[str, Floats]:
        """Arrays by name: what sampling a step needs of the step before."""
        return self.step_sampler.saved() if self.step_sampler is not None else {}

    def restore(self, memory: Mapping[str, Floats]) -> None:
        """Go back to saved arrays."""
        if self.step_sampler is not None:
            self.step_sampler.restore(memory)

    def tell(self, level: Level, text: str) -> None:
        """Record an event at the present step."""
        state = self.model.state
        event = Event(state.step, state.time, level, text)
        self.events.append(event)
        self._tell("event", lambda recording: recording.event(event))

    def last_steps(self, end: str, frames: list[Frame]) -> None:
        """Hand on the frames of every one of the last steps before `end`."""
        for name in self.wanted["last_steps"] & self.recordings.keys():
            self._one(name, "last_steps", lambda recording: recording.last_steps(end, frames))

    def iterated(self, rows: list[IterationRow]) -> None:
        """Keep the Newton iterations of an attempted step."""
        if self.folder is not None and self.iteration_file is None:
            self.iteration_file = IterationFile(self.folder, self.iterations)
        self.iterations += rows
        if self.iteration_file is not None:
            self._or_stop("iterations.csv", lambda file: file.add(rows), self.iteration_file)
        self._tell("iterations", lambda recording: recording.iterations(rows))

    def iterates(self, some: list[Iterate]) -> None:
        """Hand on states after iterations, whose rows were passed already."""
        for name in self.wanted["iterates"] & self.recordings.keys() if some else ():
            self._one(name, "iterates", lambda recording: recording.iterates(some))

    def save(self, memory: Mapping[str, Floats], summary: Mapping[str, Any]) -> None:
        """Let the recordings keep what a restart needs."""
        if self.recordings:
            self._flush()
            written = self._written(summary)
            self._tell("save", lambda recording: recording.save(memory, written))

    def release(self) -> None:
        """Let another run write to the folder, as this one could not begin."""
        if self.history_file is not None:
            self.history_file.close()

    def finish(self, summary: Mapping[str, Any]) -> Results:
        """Close everything, write the last files and return the results.

        If the disk has no space for the last state, the run has failed: it can be resumed there.
        """
        full = self.full
        reasons = [why for s in self.samplers for why in self._quietly("steps", lambda _, s=s: s.flush())]  # type: ignore[misc]
        facts = {name: fact for recording in self.recordings.values() for name, fact in recording.facts().items()}
        written = self._written({**summary, **facts})
        reasons += self._quietly("close", lambda recording: recording.close(written))
        if reasons and not full:
            written |= {"status": "failed", "reason": reasons[0]}
        self._write_files(written)
        return self._results(written)

    # --- inside -----------------------------------------------------------------------------------

    def _written(self, summary: Mapping[str, Any]) -> dict[str, Any]:
        """The summary as it is stored, with the peaks of all steps handed on so far."""
        return {**plain(summary), "peaks": plain(self.peaks.as_data(self.share))}

    def _every_step_sampler(self) -> StepSampler:
        from contactlab.results.steps import StepSampler

        return StepSampler(self.model, len(self.layout.steps), self._steps)

    def _contact_sampler(self, window: Window) -> ContactSampler:
        from contactlab.results.contact_sampler import ContactSampler

        return ContactSampler(self.model, self.layout, window, self._contact_steps)

    def _flush(self) -> None:
        for sampler in self.samplers:
            sampler.flush()

    def _write_files(self, summary: dict[str, Any]) -> None:
        if self.folder is None or self.history_file is None:
            return
        try:
            write_contacts(self.folder, self.contact)
            write_summary(self.folder, summary)
        except OSError as error:
            text = f"contact.csv and summary.json could not be written: {error.strerror or error}"
            warnings.warn(text, ContactlabWarning, stacklevel=4)
        finally:
            self.history_file.close()
            if self.iteration_file is not None:
                self.iteration_file.close()

    def _take_up(self, past: Results) -> None:
        columns = past.history
        count = len(next(iter(columns.values()), ()))
        self.rows = [{name: float(values[k]) for name, values in columns.items()} for k in range(count)]
        for name, history in self.contact.items():
            history.times, history.curves = list(past.contact[name].times), list(past.contact[name].curves)
        self.events, self.iterations = list(past.events), list(past.iterations)
        for row in self.rows:
            self.peaks.frame(row)
        self.peaks.restore(past.summary.get("peaks", {}))

    def _steps(self, block: Floats) -> None:
        self.peaks.steps(block)
        for name in self.wanted["steps"] & self.recordings.keys():
            self._one(name, "steps", lambda recording: recording.steps(block))

    def _contact_steps(self, block: Mapping[str, np.ndarray]) -> None:
        self.peaks.contact_steps(block)
        for name in self.wanted["contact_steps"] & self.recordings.keys():
            self._one(name, "contact_steps", lambda recording: recording.contact_steps(block))

    def _tell(self, what: str, call: Callable[[Recording], None]) -> None:
        for name in list(self.recordings):
            self._one(name, what, call)

    def _one(self, name: str, what: str, call: Callable[[Recording], None]) -> None:
        """Call one recording: a full disk stops the run if it keeps its state; other errors drop the recorder."""
        recording = self.recordings[name]
        try:
            if recording.keeps_state:
                self._or_stop(name, call, recording)
            else:
                call(recording)
        except SimulationFailure:
            raise
        except (Exception, SystemExit) as error:
            del self.recordings[name]
            text = f"the recorder {name} failed in {what} and is not used any more: {one_line(error)}"
            warnings.warn(text, ContactlabWarning, stacklevel=2)
            self.tell("warning", text)

    def _or_stop(self, name: str, call: Callable[[Any], None], target: Any) -> None:
        try:
            call(target)
        except OSError as error:
            self.full = True
            place = self.folder if error.filename is None else error.filename
            raise SimulationFailure(
                "failed",
                f"step {self.model.state.step}: {name} cannot write to {place}: "
                f"{(error.strerror or str(error)).lower()}; stored data stays readable, and the run can be "
                "resumed when there is space",
            ) from error

    def _quietly(self, what: str, call: Callable[[Recording], None]) -> list[str]:
        """Make the last calls; return errors of recordings that keep the run's state, report errors of others."""
        reasons, known = [], self.full
        for name, recording in list(self.recordings.items()):
            try:
                self._or_stop(name, call, recording)
            except SimulationFailure as failure:
                if recording.keeps_state:
                    reasons.append(failure.reason)
                elif not known:  # a full disk is reported once
                    warnings.warn(failure.reason, ContactlabWarning, stacklevel=2)
            except (Exception, SystemExit) as error:
                warnings.warn(f"the recorder {name} failed in {what}: {error}", ContactlabWarning, stacklevel=2)
        return reasons

    def _results(self, summary: dict[str, Any]) -> Results:
        model, keys = self.model, self.rows[0] if self.rows else {}
        stress = {forces.body.name: forces.stress() for forces in model.forces}
        return Results(
            summary=summary,
            layout=self.layout,
            history={key: np.array([float(row[key]) for row in self.rows]) for key in keys},
            contact=self.contact | {contact.label: self.contact[contact.name] for contact in self.layout.contacts},
            displacement=model.state["displacement"].copy(),
            velocity=model.state["velocity"].copy() if "velocity" in model.state else np.zeros((0, 2)),
            stress=stress,
            internal_variables=internal_variables(model),
            events=self.events,
            iterations=self.iterations,
            folder=self.folder,
        )


def internal_variables(model: Model) -> dict[str, dict[str, Floats]]:
    """History of each body whose law has any, by name (n, q)."""
    found = {}
    for forces in model.forces:
        names, points = forces.body.material.history_names, forces.body.points
        if names:
            parts = [b.history.reshape(len(names), points, -1).transpose(0, 2, 1) for b in forces.blocks]
            found[forces.body.name] = dict(zip(names, np.concatenate(parts, axis=1), strict=True))
    return found
