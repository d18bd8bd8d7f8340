"""Run: a model with its guards, watches and recorders, new or restored from a checkpoint."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

from contactlab.api import Floats, ImplicitIntegrator, IterationRow, Recorder, RunWarning, Step, StepStatus
from contactlab.api.recorder import FAILURE
from contactlab.errors import SimulationFailure
from contactlab.missing_effects.monitor import EffectMonitor
from contactlab.model.memory import model_memory, restore_model
from contactlab.model.model import Model
from contactlab.results.cost import Clock
from contactlab.results.journal import Journal
from contactlab.results.results import Results
from contactlab.results.sample import take_sample
from contactlab.results.summary import Counts, summarise
from contactlab.run.attempts import Attempts
from contactlab.run.guards import EVERY, Guards
from contactlab.run.kept_states import KeptStates
from contactlab.run.restart import check_memory, stored_results
from contactlab.run.schedule import Schedule
from contactlab.run.watches import NoGuards, Watching, WorkLimit

if TYPE_CHECKING:
    from contactlab.results.iterate_sampler import IterateSampler
    from contactlab.run.last_steps import LastSteps
    from contactlab.run.nested import NestedStart

SAVE_EVERY = 1.0  # seconds of wall time between saved states, at least
SAVE_SHARE = 100.0  # and so many times what one costs: saving never takes more than a hundredth of a run
ENDS = ("finished", "diverged", "not-converged")  # runs that cannot be continued: the saved state is their end
FAILED = ("diverged", "not-converged", "failed")  # runs whose last steps one wants to see
OF_THE_LAST_STEP = ("reactions", "reaction_mismatch", "contacts", "balance", "invariants")  # of a summary
KILLED = "the run ended without a message (killed, or still running)"


@dataclass
class Run:
    """State of the step loop. `memory` is the part of it that changes in time."""

    model: Model
    schedule: Schedule
    guards: Guards | NoGuards
    monitor: EffectMonitor
    watching: Watching | None = None
    work_limit: WorkLimit | None = None
    counts: Counts = field(default_factory=Counts)
    clock: Clock = field(default_factory=Clock)
    resumed_at: list[int] = field(default_factory=list)
    save_after: float = 0.0
    first_step: int = 0
    taken_up: dict[str, Any] = field(default_factory=dict)
    attempt: int = 1
    attempts: Attempts | None = None
    kept: KeptStates = field(default_factory=KeptStates)
    last_steps: LastSteps | None = None
    journal: Journal = field(init=False)
    nested: NestedStart | None = None
    saved_memory: Mapping[str, Floats] = field(default_factory=dict)
    iterates: IterateSampler | None = None
    when_over: Mapping[str, Recorder] = field(default_factory=dict)

    def store_start(self) -> None:
        """Store the initial state, unless the run is resumed; from here on its results are not final."""
        if not self.journal.frames:
            for attempt in self.attempts.tried if self.attempts is not None else ():
                self.journal.tell("info", f"tried before: {attempt.brief}")
            self.store()
            for pair in self.model.contact.pairs if self.model.contact is not None else ():
                if pair.start_gaps is not None and (told := pair.start_gaps.told()):
                    self.journal.tell("info", f"{pair.name}: {told}")
        self.keep()
        self.save()

    def solve_coarser_levels(self) -> None:
        """Estimate the end on coarser meshes if steps skip the loading path; follow the path without an estimate."""
        nested = self.nested
        if nested is None or not self.schedule.skips or self.schedule.done():
            return
        nested.prepare()
        known = {event.text for event in self.journal.events}  # of a run that is resumed before its first step
        for level in nested.levels:
            if str(level) not in known:
                self.journal.tell("warning" if level.reason else "info", str(level))
        if nested.levels and not nested.model.estimates:
            self.schedule.follow_the_way()

    def step_judge(self) -> tuple[Callable[[], None], Callable[[Step], Step]] | None:
        """Return what is called before and after each step, which it may reject; None if no step can be rejected."""
        if not self.model.explicit:
            from contactlab.run.guarded_step import GuardJudge

            guarded = GuardJudge(self.model, self.guards, lambda: self.schedule.skips)
            return guarded.begin, guarded.judged
        if self.schedule.control is None:
            return None
        from contactlab.run.controlled_step import ControlJudge

        controlled = ControlJudge(self.model)
        return controlled.begin, controlled.judged

    @property
    def every_step(self) -> tuple[Callable[[Step, float], None], ...]:
        """Callbacks after each accepted step, with the step and its length."""
        more = self.watching.every_step if self.watching is not None else ()
        limit = (self.work_limit,) if self.work_limit is not None else ()
        last = self.last_steps.every_step if self.last_steps is not None else ()
        booked = (self.model.split.sample,) if self.model.split is not None else ()  # first: the others read it
        kept = (lambda step, dt: self.keep(),) if self.schedule.control is not None else ()  # each has its own length
        others = (*self.schedule.every_step, *self.monitor.every_step, *kept, *more, *limit)
        return (*booked, *self.journal.every_step, *last, *others)

    def iterated(self, step: Step) -> None:
        """Keep the iterations of an attempted step of an implicit run."""
        done = step.status is StepStatus.accepted
        state, dt = self.model.state, self.schedule.dt
        begun = (state.step if done else state.step + 1, state.time - dt if done else state.time, dt, self.attempt)
        shown = self.model.shown_conditions
        trace = [row._replace(statuses=row.statuses[:shown]) for row in step.trace]
        self.journal.iterated([IterationRow._make((*begun, i + 1, *row)) for i, row in enumerate(trace)])
        if self.iterates is not None:
            self.journal.iterates(self.iterates.take(len(self.journal.iterations)))
            if text := self.iterates.thinned():
                self.journal.tell("info", text)
        self.attempt = 1 if done else self.attempt + 1

    def taken_back(self, step: Step) -> None:
        """Continue with a shorter step after a rejected step. Raises SimulationFailure if there is none."""
        self.counts.iterations += step.iterations
        if self.work_limit is not None:
            self.work_limit.check()
        self.journal.tell("warning" if step.error is None and step.longest is None else "info", self.schedule.cut(step))
        if self.schedule.control is not None:
            self.keep()  # the next step from here is shorter than the step that was kept with this state
        if self.nested is not None:
            self.nested.model.estimates = ()

    def store(self) -> None:
        """Store the present state as a frame."""
        began, counts, last = perf_counter(), self.counts, self.journal.last_step
        mean = (counts.sweeps - counts.sweeps_stored) / max(1, self.model.state.step - last)
        counts.sweeps_stored = counts.sweeps
        self.journal.add(take_sample(self.model, self.journal.frames, mean, self.schedule.fraction()))
        self.clock.recording_s += perf_counter() - began
        self.monitor.examine_frame()
        self.tell_warnings()
        if self.last_steps is not None:
            self.last_steps.judged(self.journal, self.kept)

    def judge(self) -> None:
        """Judge the end of the run; see `contactlab.run.judgement`."""
        known = list(self.model.warnings) if self.journal.last is None else []
        self._look_again()
        self.guards.judge(self.journal.last, self.journal.largest_force, self.journal.largest_work)
        self.monitor.judge()
        self._judge_stability()
        if self.attempts is not None:
            self.model.warnings.add(*self.attempts.warnings(self.model))
        # conditions computed again differ in their last digits from the step's conditions, which saved warnings cite
        self.model.warnings.keep(known)

    def _judge_stability(self) -> None:
        """Ask whether bodies would stay in the equilibrium at the end of statics, unless a coarser mesh was asked."""
        integrator = self.model.integrator
        if (
            not isinstance(integrator, ImplicitIntegrator)
            or integrator.inertia
            or (self.nested is not None and self.nested.solved)
        ):
            return
        from contactlab.run.stability import unstable

        self.model.warnings.add(*unstable(self.model))

    def _look_again(self) -> None:
        """Sample a run that was resumed at its very last frame."""
        if self.journal.last is None and self.journal.frames:
            row = self.journal.rows[-1]
            share = self.schedule.fraction()
            self.journal.last = take_sample(self.model, self.journal.frames - 1, row["sweeps"], share)

    def conclude(self) -> None:
        """Judge a run that has reached its end. Raises SimulationFailure if its answer is invalid."""
        self.guards.at_the_end()
        self.schedule.adapt()
        self.listen()
        self.schedule.verdict()
        self.judge()
        if self.last_steps is not None:
            self.last_steps.judged(self.journal, self.kept)

    def tell_warnings(self) -> None:
        """Note warnings that are new as events."""
        for warning in self.model.warnings.untold():
            self.journal.tell("warning", warning.text)

    def keep(self) -> None:
        """Remember the state as it is: from here on explicit steps can be repeated."""
        if self.model.explicit:
            self.kept.take(self.model, self.schedule.dt)

    def listen(self) -> None:
        """Store the last steps with all fields, when a guard has warned for the first time."""
        if self.last_steps is not None:
            self.last_steps.listen(self.journal, self.kept)

    def failed(self, status: str) -> None:
        """Store the last steps with all fields, if the run failed."""
        if self.last_steps is not None and status in FAILED and not self.journal.full:
            with suppress(SimulationFailure):  # the disk is full: the run has failed, and says why
                self.last_steps.store(FAILURE, self.journal, self.kept)

    def save(self) -> None:
        """Save all that a restart needs; a run that is killed later looks as `KILLED` says."""
        began = perf_counter()
        if self.journal.restartable:
            reason = f"{KILLED}; its state at step {self.model.state.step} is saved"
            self.journal.save(self.saved(), self.summary("interrupted", reason))
        now = perf_counter()
        self.save_after = now + max(SAVE_EVERY, SAVE_SHARE * (now - began))
        self.clock.recording_s += now - began

    def save_now_and_then(self) -> None:
        """Save, if the last time was long ago."""
        if perf_counter() > self.save_after:
            self.save()

    @property
    def saves(self) -> tuple[int, Callable[[], None]]:
        """After how many steps to do what for a restart: each load step is saved, and others by time."""
        if self.model.explicit:
            return EVERY, self.save_now_and_then
        return 1, self.save_now_and_then if self.model.integrator.inertia else self.save

    def pause(self, why: str) -> str:
        """Save the state of a run that is stopped; return the reason for its summary.

        After the last step data that the step left outside the state can still be judged, but not later;
        a run that fails there fails when it is resumed.
        """
        if self.schedule.at_its_end():
            with suppress(SimulationFailure):
                self.conclude()
            self.tell_warnings()
        self.save()
        kept = "its state is saved" if self.journal.restartable else "nothing was written to resume it"
        return f"{why} after step {self.model.state.step}; {kept}"

    def saved(self) -> dict[str, Floats]:
        """Arrays by name: of the model, and of everything that follows it."""
        memory = model_memory(self.model)
        for part in self._followers:
            memory |= part.saved()
        return memory

    @property
    def _followers(self) -> tuple[Any, ...]:
        more = (self.watching, self.model.split)
        recorded = (self.journal,) if hasattr(self, "journal") else ()  # it is opened after the rest is restored
        return self.schedule, self.guards, self.counts, self.monitor, *(p for p in (*more, *recorded) if p is not None)

    def restore(self, memory: Mapping[str, Floats], summary: str, folder: Path) -> None:
        """Restore arrays that were saved, and take up the summary. Raises RequestError if they do not fit the model."""
        check_memory(memory, self.saved(), folder)
        self.saved_memory = memory
        restore_model(self.model, memory)
        for part in self._followers:
            part.restore(memory)
        self.first_step = self.counts.steps
        self.taken_up = json.loads(summary) if summary else {}
        self.model.warnings.restore(map(RunWarning.from_data, self.taken_up.get("warnings", ())))
        self.clock.before = self.taken_up.get("cost", {})
        self.resumed_at = [*self.taken_up.get("resumed_at_steps", ()), self.counts.steps]

    @property
    def energy_error(self) -> float:
        """Relative error of the energy balance at the last stored frame."""
        return self.journal.last.energies["error"] if self.journal.last is not None else 0.0

    def summary(self, status: str, reason: str) -> dict[str, Any]:
        """Gather the content of `summary.json`, as if the run ended now."""
        journal = self.journal
        seen = journal.last, status, reason, self.counts, self.clock, journal.largest_force
        summary = summarise(journal.layout, self.model, *seen)
        summary["reached"] = self.schedule.reached()
        if took := self.schedule.stabilisation():
            summary["stabilisation"] = took
        summary["warnings"] = [warning.as_data() for warning in self.model.warnings]
        if self.attempts is not None:
            summary["resolved"]["integrator"] = self.attempts.resolved(self.schedule.scene.integrator["use"])
            summary["cost"]["failed_attempts_s"] = self.attempts.cpu_s
        if self.counts.steps == self.first_step:
            # resumed and not stepped yet: data that a step leaves in the model outside the state is missing
            summary |= {name: self.taken_up[name] for name in OF_THE_LAST_STEP if name in self.taken_up}
        if self.nested is not None and self.nested.levels:
            summary["nested"] = self.nested.summary()
            summary["cost"]["coarser_levels_s"] = sum(level.cpu_s for level in self.nested.levels)
        elif "nested" in self.taken_up:
            summary["nested"] = self.taken_up["nested"]
        return summary | ({"resumed_at_steps": self.resumed_at} if self.resumed_at else {})

    def finish(self, status: str, reason: str) -> Results:
        """Close the files and give the results."""
        self._look_again()
        self.clock.arrays_mib = None
        complete, folder = self.journal.restartable, self.journal.folder
        try:
            self.tell_warnings()
            if status in ENDS:
                self.save()
        except SimulationFailure as failure:  # the disk is full at the very end
            status, reason = failure.status, failure.reason
        results = self.journal.finish(self.summary(status, reason))
        return stored_results(folder, results) if complete and folder is not None else results
