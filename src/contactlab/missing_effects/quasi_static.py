"""Runs that should be quasi-static and are not."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from contactlab.api import WORK, ImplicitIntegrator, RunWarning
from contactlab.missing_effects.missing_effect import Detectors, needed, per_cent
from contactlab.model.loading.declared import courses_in
from contactlab.model.model import Model
from contactlab.model.timing import A_PERIOD
from contactlab.results.reaction_balance import reaction_sum
from contactlab.scene.scene import Scene

SHARE = 0.01  # of kinetic over internal energy
UNBALANCED = 0.02  # of the largest reaction, and of the work that damping takes
EARLY = 0.2  # of the ramp: what a jolt at its start put in is not small against the work done yet
UNRESISTED = 0.5  # a body that meets a resistance stores more than half of its kinetic energy however slow the load is


def quasi_static_detectors(scene: Scene, model: Model) -> Detectors:
    """The detector for frames of runs with `end = "auto"` whose loading path is meant to be in equilibrium."""
    del scene
    if _follows(model):
        yield Balance(model)


def work_detectors(scene: Scene, model: Model) -> Detectors:
    """Detectors for works of such a run: shares of its largest, which early frames do not know."""
    if _follows(model):
        yield KineticEnergy(model)
        yield DampedWork(model, tuple(_at_once(scene)))


def _follows(model: Model) -> bool:
    return model.timing.end is None and model.timing.follows and model.integrator.inertia


class KineticEnergy:
    """`worst`: largest kinetic energy in the second half of the ramp and after, and largest internal energy [mJ].

    In the first half of the ramp a body may still be on its way to the others.
    """

    def __init__(self, model: Model) -> None:
        self.model, self.worst = model, np.zeros(2)

    def update(self) -> None:
        """Take in the kinetic energy, and the work of the stresses."""
        if self.model.state.time >= 0.5 * self.model.timing.last:
            self.worst[0] = max(self.worst[0], self.model.kinetic_energy())
        self.worst[1] = max(self.worst[1], abs(float(self.model.state["work"][0])))

    def warning(self) -> RunWarning | None:
        """A slower ramp: kinetic energy goes with the square of the speed."""
        kinetic, internal = (float(value) for value in self.worst)
        if kinetic <= SHARE * internal:
            return None
        share = kinetic / max(internal, 1e-300)
        if share > UNRESISTED:
            seen = (
                f"nothing resists the motion: kinetic energy reaches {per_cent(share)} of the internal energy in a run"
            )
            mend = "hold the moving bodies by supports or contacts, or slow down: " + _slowly(self.model, 10.0)
        else:
            seen = f"kinetic energy reaches {per_cent(share)} of the internal energy in a run"
            mend = _slowly(self.model, math.ceil(10.0 * math.sqrt(share / SHARE)) / 10.0)
        seen += f" that is meant to be quasi-static ({per_cent(SHARE)} at most)"
        return needed("slower-loading", share, SHARE, _slow_key(self.model), seen, mend)


class Balance:
    """`worst`: largest mismatch of reactions at a frame after the first fifth of the ramp, and largest reaction [N].

    Frames in which bodies are still on their way to each other, or kinetic energy is not small, are not judged, nor
    those in which reactions are smaller than what the largest so far may be off by: a body that was let go.
    """

    def __init__(self, model: Model) -> None:
        self.model, self.worst = model, np.zeros(2)

    def update(self) -> None:
        """Take in the sum of reactions and loads over the largest of them."""
        model = self.model
        total, largest = reaction_sum(model)
        self.worst[1] = max(self.worst[1], largest)
        slow = model.kinetic_energy() <= SHARE * abs(float(model.state["work"][0]))
        if slow and model.state.time >= EARLY * model.timing.last and largest > UNBALANCED * self.worst[1]:
            self.worst[0] = np.fmax(self.worst[0], total / largest)

    def warning(self) -> RunWarning | None:
        """A slower ramp: vibrations fade while it lasts, and inertia goes with the square of its speed."""
        return _slower(
            self.model,
            float(self.worst[0]),
            "unbalanced-reactions",
            "the sum of reactions and loads is",
            "of the largest at a frame",
        )


class DampedWork:
    """`worst`: largest work that damping had taken at a frame, of steps with it, and largest work from outside [mJ].

    A jolt at the start of the ramp is damped as it should be, and small against the work done in the end, however much
    of the little done by then it is. Loads that act `at_once` (their keys) set bodies in motion however slow the rest
    is, and damping has to take as much as these store. The end does not depend on it where nothing remembers the way.
    """

    def __init__(self, model: Model, at_once: tuple[str, ...] = ()) -> None:
        self.model, self.at_once, self.worst = model, at_once, np.zeros(2)

    def update(self) -> None:
        """Take in the works of damping and of supports and loads so far."""
        internal, external, damping = (abs(float(work)) for work in self.model.state["work"][:3])
        if not self.model.explicit:  # in explicit runs it is the energy of hourglass modes
            damping += abs(float(self.model.state["work"][WORK.index("numerical")]))
        np.maximum(self.worst, (damping, max(internal, external)), out=self.worst)

    def warning(self) -> RunWarning | None:
        """A slower ramp, or one at all: what is damped away does not deform the bodies."""
        damping, work = (float(value) for value in self.worst)
        share, history = damping / max(work, 1e-300), self.model.history
        if not self.at_once:
            return _slower(self.model, share, "damped-work", "damping has taken", "of the work done by the end")
        if share <= UNBALANCED or not (history.laws or history.friction):
            return None
        return needed(
            "damped-work", share, UNBALANCED, self.at_once[0],
            f"damping has taken {per_cent(share)} of the work done ({per_cent(UNBALANCED)} at most), as a load acts "
            f"without a ramp, and {(*history.laws, *history.friction)[0]} depends on the loading path",
            f"add a ramp: write {self.at_once[0]} = {_rising(self.model, self.at_once[0])}",
        )  # fmt: skip


def _slower(model: Model, share: float, code: str, what: str, whole: str) -> RunWarning | None:
    if share <= UNBALANCED:
        return None
    return needed(
        code,
        share,
        UNBALANCED,
        _slow_key(model),
        f"{what} {per_cent(share)} {whole} of a run that is meant to be quasi-static ({per_cent(UNBALANCED)} at most)",
        _slowly(model, 2.0),
    )


def _at_once(scene: Scene) -> Iterator[str]:
    """Keys of loads and effects that act with all they have from the start on, if nothing in the scene rises."""
    if any(not course.steady for _, _, course in courses_in(scene)):
        return
    yield from (key for key, _, _ in courses_in(scene) if key.startswith("loads."))
    for number, part in enumerate(scene.effects):
        if scene.registry.make("effect", part, scene.where(f"effects.{number}")).times():
            continue
        if "ramp" in part:
            yield f"effects.{number}.ramp"


def _rising(model: Model, key: str) -> str:
    """Value of a key that makes a load rise during the run, slowly enough to excite little."""
    if key.endswith(".ramp"):
        return f"{model.timing.last:.3g}"
    return '{ ramp = "linear", to = its value }'


def _slow_key(model: Model) -> str:
    """The key of the scene that sets how fast it is loaded."""
    if _steps_needed(model):
        return "integrator.steps"
    because = model.timing.because
    return "time.ramp" if not because or because.endswith(".begin") else because


def _slowly(model: Model, factor: float) -> str:
    """The line that makes the loading slower by a factor, or steps shorter if they do not resolve vibrations."""
    key = _slow_key(model)
    if steps := _steps_needed(model):
        return f"write {key} = {steps} or more, or omit it: steps are longer than half a period of the lowest mode"
    if key == "time.ramp":
        return f"write {key} = {factor * model.timing.ramp:.3g} or more"
    last = factor * model.timing.last
    if key.endswith((".points", ".file", ".function")) or key.rpartition(".")[2].isdigit():
        return f"stretch the times of {key} to {last:.3g} s or more"
    return f"write {key} = {last:.3g} or more"


def _steps_needed(model: Model) -> int:
    """The number of implicit steps of the loading that resolves the lowest mode, if the scene gives fewer; else 0."""
    integrator, timing = model.integrator, model.timing
    if not isinstance(integrator, ImplicitIntegrator) or not integrator.fixes_steps():
        return 0
    steps = math.ceil(A_PERIOD * timing.last / timing.period)
    return steps if integrator.wished_steps() < steps else 0
