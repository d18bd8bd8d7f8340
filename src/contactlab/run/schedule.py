"""When a run steps, stores a frame, and ends."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from contactlab.api import Floats, RunWarning, Step
from contactlab.errors import SceneError, SimulationFailure
from contactlab.model.model import Model
from contactlab.results.reaction_balance import reaction_mismatch, reaction_sum
from contactlab.run.stopping import stop
from contactlab.run.swings import Swing, frame_warnings, step_warnings, swings_of
from contactlab.scene.scene import Scene

SETTLED_MISMATCH = 2e-4  # of support reactions, over the last period
SETTLED_KINETIC = 1e-3  # kinetic over internal energy
LET_GO = 0.01  # of the largest reactions of the run: smaller ones count as that, and energies as its square
SAMPLES = 40  # samples per period while waiting to settle
SAME_TIME = 1e-12  # relative: round-off of sums of steps that meet a time
ROUND_OFF = 1.0 + 1e-6  # of the stable step: what a step may be longer that was meant to be as long
SHORTEST_CONTROLLED = 1e-6  # of the stable step: an error that such steps do not cure is no matter of their length
SHORTEST = 1e-3  # of the first step: a stable step below it means that cells are collapsing
MANY = 1000  # frames that were asked for within one step


class Schedule:
    """Step lengths and the end of one run.

    A run with a fixed end takes equal steps that meet it. An `auto` run follows all that the scene declares in time,
    then holds until reactions and kinetic energy have settled over one period of the lowest mode.
    """

    def __init__(self, model: Model, scene: Scene) -> None:
        self.model, self.scene, self.timing, self.state = model, scene, model.timing, model.state
        self.fraction_of_limit, self.fixed = scene.time.fraction, scene.time.step
        self.control = model.integrator.control()
        self.swings = swings_of(scene, model.timing)
        self.limit = self.end = self.timing.end if self.timing.end is not None else self.timing.last + self.timing.hold
        self.frame_every = self.timing.last / max(1, scene.record.frames)
        self.next_frame = self.frame_every
        self.dt = self.first = self.longest = self.aimed = self._first_step()
        if self.control is not None and model.explicit:
            self._aim(self.dt)
        self.next_sample = self.timing.last
        self.samples: deque[tuple[float, float]] = deque(maxlen=SAMPLES + 1)
        self.settled = False
        self.largest = np.zeros(2)  # reaction [N] and internal energy [mJ] at frames, by which what is left is judged
        if self.swings:
            model.warnings.add(*self._too_coarse())

    def _too_coarse(self) -> Iterator[RunWarning]:
        """Warnings of values that go to and fro faster than steps and frames can show."""
        yield from frame_warnings(self.swings, self.frame_every, self.scene.record.frames)
        yield from step_warnings(self.swings, self._each_way, bool(self.model.history), "time.step", self.first)

    def _each_way(self, swing: Swing) -> float:
        """Steps of the shortest way of a value that goes to and fro."""
        return swing.shortest / self.first

    def _first_step(self) -> float:
        if self.fixed is None:
            return self._even(self.model.step_within(self.fraction_of_limit))
        stable = self.model.step_within(1.0)
        if self.fixed > ROUND_OFF * stable:
            raise SceneError(
                "the fixed step is longer than the stable step, and the run would diverge",
                where=self.scene.where("time.step"),
                got=self.fixed,
                allowed=f"at most {stable:.6g} [s], set by {self._smallest()}",
                hint="omit it: the step is then time.fraction of the current stable step",
            )
        return float(self.fixed)

    def _even(self, dt: float) -> float:
        """A step of at most dt that meets a fixed end exactly."""
        if self.timing.end is None:
            return dt
        rest = self.timing.end - self.state.time
        # less than half a step is round-off of the last one, which `_reached` passes over
        return rest / max(1, -int(-rest // dt)) if rest > 0.5 * dt else dt

    def adapt(self) -> None:
        """Shorten the step when the stable one has become shorter."""
        if self.fixed is not None:
            stable = self.model.step_within(1.0)
            if self.dt > ROUND_OFF * stable:
                self.model.warnings.add(RunWarning(
                    "fixed-step", self.dt, stable, "time.step",
                    f"the fixed step {self.dt:.4g} s is {self.dt / stable:.3g} times the stable step, which fell to "
                    f"{stable:.4g} s by {self._smallest()}; omit time.step, steps follow the stable step then",
                ))  # fmt: skip
            return
        safe = self.model.step_within(self.fraction_of_limit)
        if not safe >= SHORTEST * self.first:  # NaN where positions are
            stop(
                self.model,
                f"the stable step fell to {safe:.3g} s, {safe / self.first:.1e} of the first step, by "
                f"{self._smallest()}",
                "cells are collapsing: try a finer mesh where strain is large",
            )
        if self.control is not None:
            self.longest = safe
            self._aim(self.aimed)
        elif safe < self.dt:
            self.dt = self._even(safe)

    @property
    def parameter(self) -> str:
        """Quantity that steps are equal parts of, in words."""
        return "time"

    def estimated_steps(self) -> int:
        """Steps of the whole run if nothing changes their length; a run that settles is taken to do so in a period."""
        timing = self.timing
        return max(1, round((timing.last if timing.end is not None else timing.last + timing.period) / self.first))

    def _smallest(self) -> str:
        """Name the cause of the stable step: a cell, and effects if they shorten it by a tenth or more."""
        limit = min(self.model.step_limits, key=lambda limit: limit.latest)
        cell = f"cell {limit.cell} of body {limit.body.name}"
        rates = self.model.loading.rates, self.model.rates(limit.latest)
        effects, all_ = (limits.limit(limit.latest) / limit.latest for limits in rates)
        if all_ < 0.9 * effects:
            cell = f"the pressure of contacts, which shortens it to {all_ / effects:.0%}, and {cell}"
        return f"effects (springs, damping) and {cell}" if effects < 0.9 else cell

    @property
    def every_step(self) -> tuple[Callable[[Step, float], None], ...]:
        """Callbacks after each accepted step, with the step and its length."""
        springs = self.model.contact is not None and not self.model.contact.enforcement.exact
        controlled = (self._follow_error,) if self.control is not None else ()
        return (*controlled, self._follow) if springs else controlled

    def _follow(self, step: Step, dt: float) -> None:
        """Shorten the step if contact has become stiffer than expected."""
        if self.model.contact.stiffened:  # type: ignore[union-attr]
            self.adapt()

    def _follow_error(self, step: Step, dt: float) -> None:
        """Choose the next step from the error of this one, at most the stable step."""
        self._aim(self._after(step, dt, self.aimed))

    def _after(self, step: Step, length: float, aimed: float) -> float:
        """Length of the next step by the error of this one, which may have been cut to meet a frame."""
        ratio = self._ratio(step)
        return ratio * length if ratio < 1.0 else max(ratio * length, aimed)

    def _ratio(self, step: Step) -> float:
        assert self.control is not None
        before = float(self.state["step_error"][1])
        return self.control.ratio(step.error or 0.0, before if before > 0.0 else 1.0)

    def _aim(self, dt: float) -> None:
        """Take a step of at most dt that meets frames and the end."""
        from contactlab.run.controlled_step import next_stop, within

        time, end = self.state.time, np.inf if self.timing.end is None else self.end
        self.dt = self.aimed = min(dt, self.longest)
        if time < end * (1.0 - SAME_TIME):
            self.dt = within(self.aimed, next_stop(self, end) - time)

    def cut(self, step: Step) -> str:
        """React to a step that was not accepted: explicit steps are only rejected for their error."""
        if self.control is not None and step.error is not None and step.error > 1.0:
            tried = self.dt
            self._aim(self._ratio(step) * tried)
            if self.aimed < SHORTEST_CONTROLLED * self.longest:
                raise SimulationFailure(
                    "not-converged", f"step {self.state.step}: {step.reason} with a step of {tried:.3g} s, "
                    f"{tried / self.longest:.1e} of the stable step; try a larger tolerance",
                )  # fmt: skip
            start = f"step of {tried:.6g} from time {self.state.time:.6g}"
            return f"{start} rejected: {step.reason}; retry with {self.dt:.6g}"
        raise SimulationFailure("failed", f"step {self.state.step}: {step.reason or step.status.value}")

    def stop(self) -> None:
        """End the run after the present step, as if its time were over; may be called at any moment."""
        self.limit = -np.inf

    @property
    def skips(self) -> bool:
        """Return whether steps skip the path between the corners of the loading."""
        return False

    def follow_the_way(self) -> None:
        """Skip nothing from here on."""

    def stopped(self) -> bool:
        """Return whether `stop` was called."""
        return self.limit == -np.inf

    def frame_due(self) -> bool:
        """Return whether to store the state just reached: at intervals, and at the end of the run."""
        if due := self._interval_over() or self._over(self.end):
            self._look()
        return due

    def _look(self) -> None:
        """Take in the largest reaction and the internal energy of a run that is to settle."""
        if self.timing.until_settled:
            now = reaction_sum(self.model)[1], abs(self.state["work"][0])
            np.maximum(self.largest, now, out=self.largest)

    def _interval_over(self) -> bool:
        if self.state.time < self.next_frame * (1.0 - 1e-12):
            return False
        behind = (self.state.time - self.next_frame) / self.frame_every
        if behind > MANY:  # counting them one by one would take longer than the step: every step is one
            self.next_frame = self.state.time * (1.0 + 1e-11)
            return True
        while self.next_frame * (1.0 - 1e-12) <= self.state.time:
            self.next_frame += self.frame_every
        return True

    def done(self) -> bool:
        """Return whether the run has reached its end, or was stopped."""
        return self._over(self.limit)

    def at_its_end(self) -> bool:
        """Return whether the last step has been made, without side effects."""
        return self.settled or self._reached(self.end)

    def _reached(self, limit: float) -> bool:
        return bool(self.state.time >= limit - 0.5 * self.dt)

    def _over(self, limit: float) -> bool:
        if self._reached(limit):
            return True
        if self.timing.until_settled and self.state.time >= self.next_sample:
            self.next_sample += self.timing.period / SAMPLES
            self.settled = self._settled()
        return self.settled

    def _settled(self) -> bool:
        force, energy = LET_GO * self.largest[0], LET_GO**2 * self.largest[1]
        energy = max(abs(self.state["work"][0]), energy, 1e-300)
        self.samples.append((reaction_mismatch(self.model, force), self.model.kinetic_energy() / energy))
        if len(self.samples) <= SAMPLES:
            return False
        mismatch, kinetic = self.worst()
        return (mismatch != mismatch or mismatch <= SETTLED_MISMATCH) and kinetic <= SETTLED_KINETIC

    def worst(self) -> tuple[float, float]:
        """Largest reaction mismatch and kinetic over internal energy of the last period."""
        return max(m for m, _ in self.samples), max(k for _, k in self.samples)

    def fraction(self) -> float:
        """Fraction of the run that is done, 0 to 1."""
        return self.share(self.state.time)

    def share(self, time: float) -> float:
        """Fraction of the run that is done at a time [s], 0 to 1; of its declared time if it waits to settle."""
        return min(1.0, time / self.timing.last)

    def reached(self) -> dict[str, Any]:
        """Progress of the run: time [s], and the share of the loading (statics) or of time that is done."""
        time = self.state.time
        of = "time" if self.model.integrator.inertia else "load"
        return {"time": time, "share": self.share(time), "of": of}

    def stabilisation(self) -> dict[str, float]:
        """Steps that were stabilised, as for the summary. Explicit steps never are."""
        return {}

    def saved(self) -> dict[str, Floats]:
        """Everything that changes during the run."""
        samples = np.full((SAMPLES + 1, 2), np.nan)
        samples[: len(self.samples)] = list(self.samples) or np.zeros((0, 2))
        numbers = (
            self.dt,
            self.first,
            self.next_frame,
            self.next_sample,
            self.settled,
            len(self.samples),
            *self.largest,
        )
        own = {"schedule.control": np.array([self.aimed, self.longest])} if self.control is not None else {}
        return {"schedule": np.array(numbers, np.float64), "schedule.samples": samples, **own}

    def restore(self, memory: Mapping[str, Floats]) -> None:
        """Go back to where `memory` was saved."""
        numbers = memory["schedule"].tolist()
        self.dt, self.first, self.next_frame, self.next_sample = numbers[:4]
        self.settled, self.largest[:] = bool(numbers[4]), numbers[6:]
        if self.control is not None:
            self.aimed, self.longest = memory["schedule.control"].tolist()
        rows = memory["schedule.samples"][: int(numbers[5])].tolist()
        self.samples = deque(((mismatch, kinetic) for mismatch, kinetic in rows), maxlen=SAMPLES + 1)

    def verdict(self) -> None:
        """Raise SimulationFailure("not-converged") for an `auto` run that did not settle."""
        if not self.timing.until_settled or self.settled or not self.samples:
            return
        mismatch, kinetic = self.worst()
        raise SimulationFailure(
            "not-converged",
            f"the run did not settle within {self.timing.hold:.3g} s after the loading: over the last period reactions "
            f"differ by {mismatch:.1e} (allowed {SETTLED_MISMATCH:.0e}) and kinetic energy is {kinetic:.1e} of "
            f"internal (allowed {SETTLED_KINETIC:.0e}); likely cause: contact that keeps opening and closing; try a "
            "longer time.ramp",
        )
