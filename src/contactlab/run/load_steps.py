"""Step lengths of implicit runs: as the scene wishes, shorter if Newton's method fails, and back again."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from typing import Protocol, cast

import numpy as np

from contactlab.api import Floats, ImplicitIntegrator, RunWarning, Step
from contactlab.errors import SceneError, SimulationFailure
from contactlab.model.implicit_model import ImplicitModel
from contactlab.model.loading.declared import courses_in
from contactlab.model.timing import A_PERIOD
from contactlab.run.controlled_step import next_stop, within
from contactlab.run.load_path import LoadPath, TimePath, corners, load_jumps
from contactlab.run.schedule import SHORTEST_CONTROLLED, Schedule
from contactlab.run.stabilised_steps import CUTS, JUMP, StabilisedSteps
from contactlab.run.swings import Swing, frame_warnings, step_warnings

CUT, GROW = 0.5, 2.0  # of the step that failed, after one that converged easily
FLOWING = 0.3, 1.5  # the same of bodies that flow: their steps start from the last one, and are best like it
EASY = 8  # iterations of a step after which a longer one is tried
SHORTEST = 2.0**-12  # of the wished step: below it the run is given up
LONGEST = 0.999  # of the loading in one step that follows its error: the whole load is not a step of a path
MOST = 1e6  # steps of a run: more is a step that was meant for an explicit one
SAME = 1e-6  # relative: residuals of two attempts that differ by less are the same
EACH_WAY = 2.0  # times the steps of a load, for each way of one that goes to and fro: friction work is right to 2 %
AGAIN = 0.6  # of the wished step: below it a step is stabilised where an earlier one had to be
TURNED = 0.1  # of a step, the first one after a turn: what reverses in it has no work, in a stiff pad all friction
HELD = 100  # steps of the longest hold: some periods, over which it is judged, are then a part of it
NUMBER = re.compile(r"[\d.]+(e[+-]?\d+)?")
AFTER_JUMP = 1.0 / 32.0  # of a step: the first one after a load has jumped, of which it takes the mean of both ends
CREEPS = 1.0 / 256.0  # of the wished step: with shorter steps a run does not end if every longer attempt fails
CREPT = 20  # such steps in a row, after which it is given up
BESIDE = 0.002  # of an end: a value that stands so far from the share of the loading is named
NEARLY = 1e-9  # of a step: differences below it are round-off


class StepError(Protocol):
    """Estimates what the length of steps does to the results."""

    @property
    def memory(self) -> dict[str, Floats]:
        """Arrays that change during the run, by name."""

    def follow(self, step: Step, dt: float, jumped: bool) -> None:
        """Look at an accepted step of length dt [s]; one that `jumped` was made in short substeps."""

    def warnings(self, key: str, now: float) -> Iterator[RunWarning]:
        """Warn of large errors; `key` of the scene says how many steps there are, or how long, `now`."""


class LoadSchedule(Schedule):
    """Equal steps as long as they converge. A failed step is cut and tried again from the same state.

    Without inertia steps end where the loading turns a corner, and are equal parts of it (`LoadPath`) unless the scene
    fixes their length; otherwise of time. `wished` and `part` are the wished and the present step as fractions of the
    whole. If the end does not depend on the loading path and the integrator nests, each step goes from corner to corner
    (`part` is 1), until one of them fails.
    """

    def _first_step(self) -> float:
        integrator = cast(ImplicitIntegrator, self.model.integrator)
        total, chosen = self.timing.last, self.fixed is None and not integrator.fixes_steps()
        statics = not integrator.inertia and self.fixed is None
        self.path: LoadPath | TimePath
        self.jumps: dict[float, bool] = {}
        length = 0.0
        number = integrator.wished_steps() if self.fixed is None else total / self.fixed
        if statics:
            self.path = path = LoadPath(self.model, self.scene, self.swings)
            length = path.length
            number *= EACH_WAY * length if chosen and self.swings else 1.0
        else:
            if chosen and self.timing.end is None:
                number = max(number, A_PERIOD * total / self.timing.period)
            if integrator.inertia:
                self.jumps = load_jumps(self.scene, self.timing, total / number)
                ends = [*self.jumps, total]
            else:
                ends = corners(self.scene, self.timing, self.swings)
            self.path = TimePath(total, number, self.swings if chosen else [], ends)
            number = self.path.number
        self.wished = 1.0 / number if self.fixed is None else self.fixed / total
        self.each_way = number / length if statics else 0.0
        if number > MOST:
            raise self._too_many(number, integrator)
        skips = statics and not self.model.history and integrator.for_coarser_levels() is not None
        self.part = 1.0 if skips else self.wished
        flows = any(body.material.history_size for body in self.model.bodies)
        self.cut_to, self.grow = FLOWING if flows else (CUT, GROW)
        self.failed: Step | None = None  # the last attempt, where it failed
        self.crept = 0  # accepted steps in a row that are very short, and whose longer attempt failed
        self.stabilised = StabilisedSteps(cast("ImplicitModel", self.model))
        self.step_errors = list(self._step_errors())
        return self._length()

    def _step_errors(self) -> Iterator[StepError]:
        """What estimates the errors of this run by the length of its steps."""
        model = self.model
        contact = None if model.integrator.inertia else cast("ImplicitModel", model).contact
        if contact is not None and any(linear.pair.friction is not None for linear in contact.linear):
            from contactlab.run.friction_error import FrictionError

            yield FrictionError(cast("ImplicitModel", model))
        if model.integrator.inertia and model.contact is not None:
            from contactlab.run.contact_times import ContactTimes

            yield ContactTimes(model, self.wished * self.timing.last)
        if model.integrator.inertia and self.timing.end is not None and not self.swings:
            from contactlab.run.phase_error import PhaseError

            yield PhaseError(model)

    def _too_many(self, number: float, integrator: ImplicitIntegrator) -> SceneError:
        timing, most = self.timing, f"at most {MOST:.0f} steps in a run"
        if self.fixed is not None:
            key, got, allowed = "time.step", self.fixed, f"at least {timing.last / MOST:.3g}"
            hint = "omit it: `steps` of implicit integrators gives the number of steps, which sets their length"
        elif integrator.fixes_steps():
            key, got, allowed, hint = "integrator.steps", integrator.wished_steps(), most, "write fewer"
        else:
            key, got, allowed = timing.because or "time.ramp", timing.last, most
            hint = "make it faster or omit it, or use statics (newton), which take load increments"
        return SceneError(
            f"this length needs {number:.0f} steps",
            where=self.scene.where(key),
            got=got,
            allowed=allowed,
            hint=hint,
        )

    def _too_coarse(self) -> Iterator[RunWarning]:
        """Warnings before the first step; `verdict` warns of load steps, which end where the loading turns."""
        yield from frame_warnings(self.swings, self.frame_every, self.scene.record.frames)
        if self.model.integrator.inertia:
            yield from self._few_steps()

    def _few_steps(self) -> Iterator[RunWarning]:
        if self.fixed is not None or cast(ImplicitIntegrator, self.model.integrator).fixes_steps():
            key = "integrator.steps" if self.fixed is None else "time.step"
            now = self.fixed or cast(ImplicitIntegrator, self.model.integrator).wished_steps()
            yield from step_warnings(self.swings, self._each_way, bool(self.model.history), key, now)

    def _each_way(self, swing: Swing) -> float:
        """Load increments go with the way that is made, steps in time with its time."""
        return self.each_way or swing.shortest / (self.wished * self.timing.last)

    @property
    def every_step(self) -> tuple[Callable[[Step, float], None], ...]:
        """Callbacks after each accepted step, with the step and its length."""
        return (self._took,)

    @property
    def parameter(self) -> str:
        """Quantity that steps are equal parts of, in words."""
        return f"{self.path.parameter}, from corner to corner" if self.skips else self.path.parameter

    @property
    def skips(self) -> bool:
        """Return whether steps go from corner to corner of the loading: no state between them is needed."""
        return self.part >= 1.0 > self.wished

    def follow_the_way(self) -> None:
        """Take load steps from here on: the end cannot be found in one step."""
        self.part = min(self.part, self.wished)
        self.dt = self._length()

    def estimated_steps(self) -> int:
        """Number of steps that the scene wishes, leg by leg of the loading."""
        if self.timing.end is None:
            return super().estimated_steps()
        time, count = 0.0, 0
        while time < self.timing.end:
            stop = self.path.stop(time)
            leg = self.path.fraction(stop) - self.path.fraction(time)
            count += max(1, int(np.ceil(leg / max(self.part, self.wished) * (1.0 - NEARLY))))
            time = stop
        return count

    def _took(self, step: Step, dt: float) -> None:
        """Follow an accepted step: longer again if it converged easily."""
        self.crept = self.crept + 1 if self.failed is not None and self.part < CREEPS * self.wished else 0
        self.failed, jumped = None, self.stabilised.replaces is not None
        for error in self.step_errors:
            error.follow(step, dt, jumped)
        self.stabilised.follow()
        if jumped:
            self._begin_anew()
        elif self.skips:
            self.model.way_followed = False
        elif self.control is not None:
            taken = self.path.fraction(self.state.time) - self.path.fraction(self.state.time - dt)
            self.part = min(LONGEST, self._after(step, taken, self.part))
        elif step.iterations <= EASY:
            self.part = min(self.wished, self.grow * self.part)
        self.dt = self._length()
        if near := [drops for at, drops in self.jumps.items() if abs(self.state.time - at) <= NEARLY * dt]:
            time = self.state.time
            short = AFTER_JUMP * (self.path.time(min(1.0, self.path.fraction(time) + self.part)) - time)
            self.dt = self.dt if self.dt <= 2.0 * short else short
            if any(near):
                from contactlab.implicit.impacts import resolve_waves

                resolve_waves(self.state, self.model.mass, self.dt)
        if step.longest is not None:
            self.dt = within(step.longest, self.dt)

    def cut(self, step: Step) -> str:
        """Shorten a step that failed; what was done, for the record.

        Raises SimulationFailure below the shortest, and if an attempt repeats the longer attempt before it.
        """
        tried, before, time = self.dt, self.failed, self.state.time
        if step.longest is not None:
            self.dt = min(step.longest, 0.9 * tried)
            return f"step of {tried:.6g} from time {time:.6g} cut to {self.dt:.6g}: {step.reason}"
        if self.control is not None and step.error is not None and step.error > 1.0:
            self.part = self._ratio(step) * (self.path.fraction(time + tried) - self.path.fraction(time))
            self.dt = self._length()
            if self.part < SHORTEST_CONTROLLED * self.wished:
                raise self._failure(tried, step, f"{self.part / self.wished:.1e} of the load increment")
            return f"step of {tried:.6g} from time {time:.6g} rejected: {step.reason}; retry with {self.dt:.6g}"
        # of the step that was taken, which a corner of the loading may have shortened
        if self.skips:
            self.part = self.wished
        else:
            self.part = self.cut_to * min(self.part, self.path.fraction(time + tried) - self.path.fraction(time))
        if (plain := self.stabilised.replaces) is not None:
            if self.part < JUMP * self.cut_to**CUTS * self.wished:
                if not self.stabilised.plain_instead():
                    again = "" if step.reason in plain.reason else f"; {step.reason}"
                    raise SimulationFailure("not-converged", f"{plain.reason}{again}")
                self._begin_anew()
                return f"stabilised step of {tried:.6g} from time {time:.6g} failed; retry without stabilisation"
        elif how := self._in_vain(step):
            failure = self._failure(tried, step, how)
            if not cast(ImplicitIntegrator, self.model.integrator).stabilises():
                raise failure
            self.stabilised.choose(failure)
            self._begin_anew()
            return f"{failure.reason}; retry with a stabilised step of {self.dt:.6g}"
        self.failed, self.dt = step, self._length()
        loose = ""
        if before is None:
            from contactlab.run.failure_cause import nothing_holds

            loose = f"; {nothing_holds(self.model).partition(';')[0]}".rstrip("; ")
        return (
            f"step of {tried:.6g} from time {time:.6g} rejected after {step.iterations} iterations: "
            f"{step.reason}{loose}; retry with {self.dt:.6g}"
        )

    def _in_vain(self, step: Step) -> str:
        """Say how a step failed that no shorter step can replace; empty if a shorter step may converge."""
        if self.failed is not None and repeats(self.failed, step):
            return "with the same iterations as the longer step before"
        shortest = AGAIN if self.stabilised.count else SHORTEST
        if self.part < shortest * self.wished:
            parts = round(self.cut_to * self.wished / self.part)
            return f"{f'1/{parts} of the' if parts > 1 else 'a whole'} load increment"
        if self.crept >= CREPT:
            return (
                f"after {self.crept} steps below 1/{1.0 / CREEPS:.0f} of the load increment that failed at twice that"
            )
        return ""

    def _begin_anew(self) -> None:
        """Let steps be as long as wished again, or as stabilised ones are."""
        jumps = self.stabilised.replaces is not None
        self.crept = 0
        self.part, self.failed = self.wished * (JUMP if jumps else 1.0), None
        self.dt = self._length()

    def _failure(self, tried: float, step: Step, how: str) -> SimulationFailure:
        """Say how far the load went, why it went no further and where, and what to try."""
        from contactlab.run.failure_cause import cause_of_failure, nothing_holds

        of = "time" if self.model.integrator.inertia else "load"
        done = f"stopped at {100.0 * self.share(self.state.time):.4g} % of the {of}, after step {self.state.step}"
        done += self._values_beside_share()
        why = nothing_holds(self.model, tried) or cause_of_failure(self.model, self.scene, step.trace, tried)
        attempt = f"step of {tried:.3g} from time {self.state.time:.6g} failed, {how}: {step.reason}"
        return SimulationFailure("not-converged", f"{done}, {why} ({attempt})")

    def _values_beside_share(self) -> str:
        """Name the values of statics that stand at another fraction of their end than the loading, such as rotations.

        The loading advances by the largest change of any value, or of any coordinate that a rotation moves.
        """
        if self.model.integrator.inertia:
            return ""
        told, share = [], self.share(self.state.time)
        for key, _, course in courses_in(self.scene):
            value = course.bind(self.timing.ramps)
            now, end = value(self.state.time), value(self.timing.last)
            if not course.steady and end and abs(now / end - share) > BESIDE:
                told.append(f"{key} at {100.0 * now / end:.4g} %")
        return f", with {' and '.join(told)}" if told else ""

    def share(self, time: float) -> float:
        """Fraction of the loading that is done at a time [s], 0 to 1; of its ramp if the end is open."""
        return min(1.0, self.path.fraction(time))

    def adapt(self) -> None:
        """Do nothing: only its convergence limits an implicit step."""

    def _release(self, pace: float) -> None:
        """Say how far multipliers of statics come free in the next step."""
        if "release_pace" in self.state:
            self.state["release_pace"][0] = pace

    def _length(self) -> float:
        """The step in time; the last before a corner of the loading or the end meets it, without a sliver before."""
        time, pace = self.state.time, min(1.0, self.part / self.wished)
        if self.timing.end is None:
            self._release(pace)
            # the step of a run without a fixed end; steps of the hold are short enough to judge it by
            even = self.path.time(self.part)
            if time < self.timing.last * (1.0 - NEARLY):
                return even if not self.swings else self.path.time(self.path.fraction(time) + self.part) - time
            return min(even, self.timing.hold / HELD) if self.timing.hold else even
        done = self.path.fraction(time)
        stop = self.path.stop(time)
        if self.control is not None and time < stop:
            stop = next_stop(self, stop)
        rest = self.path.fraction(stop) - done
        part = min(self.part, TURNED * self.wished) if self._turned(time) else self.part
        number = max(1, int(np.ceil(rest / part * (1.0 - NEARLY))))
        # all are free at a corner: what is to come free before it does so evenly
        self._release(max(pace, 1.0 / number))
        if number == 1:
            return stop - time
        return self.path.time(done + (rest / number if number <= 2 else part)) - time

    def _turned(self, time: float) -> bool:
        """Return whether an alternating value begins or turns at a time, in statics that depend on the path."""
        if not self.each_way or not self.model.history or self.skips:
            return False
        near = NEARLY * self.timing.last
        return any(bool((np.abs(swing.turns - time) <= near).any()) for swing in self.swings)

    def _reached(self, limit: float) -> bool:
        return bool(self.state.time >= limit * (1.0 - NEARLY * self.wished))

    def _over(self, limit: float) -> bool:
        if self._reached(limit):
            return True
        return super()._over(np.inf) if self.timing.until_settled else False

    def stabilisation(self) -> dict[str, float]:
        """Stabilised steps and what they took, as for the summary."""
        return self.stabilised.summary()

    def verdict(self) -> None:
        """Judge as every run; warn of results that depend on the path of jumps, and of steps that are long or few."""
        super().verdict()
        key = "integrator.steps" if self.fixed is None else "time.step"
        for error in self.step_errors:
            self.model.warnings.add(*error.warnings(key, self.fixed or 1.0 / self.wished))
        if not (self.stabilised.dissipates_little() or self.model.integrator.inertia):
            self.model.warnings.add(*self._few_steps())
        self.model.warnings.add(*self.stabilised.warnings())

    def saved(self) -> dict[str, Floats]:
        """Everything that changes during the run."""
        own = {"schedule.load": np.array([self.part, self.model.way_followed, self.crept, *self.stabilised.saved()])}
        own |= {f"schedule.{name}": a.copy() for error in self.step_errors for name, a in error.memory.items()}
        return super().saved() | own

    def restore(self, memory: Mapping[str, Floats]) -> None:
        """Go back to where `memory` was saved."""
        super().restore(memory)
        load = memory["schedule.load"]
        self.part, self.model.way_followed = float(load[0]), bool(load[1])
        self.crept = int(load[2])
        self.stabilised.restore(load[3:])
        for error in self.step_errors:
            for name, array in error.memory.items():
                array[:] = memory[f"schedule.{name}"]


def repeats(before: Step, step: Step) -> bool:
    """Return whether an attempt left the same residuals as the longer one `before` it: length is not the cause."""
    if not step.trace and not before.trace:
        # integrators need not report their iterations: words are the same then, whatever their numbers
        return NUMBER.sub("", step.reason) == NUMBER.sub("", before.reason) != ""
    if len(before.trace) != len(step.trace):
        return False
    first, second = (np.array([(one.force, one.contact) for one in attempt.trace]) for attempt in (before, step))
    return np.allclose(first, second, rtol=SAME, atol=0.0)
