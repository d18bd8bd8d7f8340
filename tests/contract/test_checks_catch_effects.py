"""Every check of effects catches a planted defect, and a right one passes all of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest

from contactlab.api import Effect, EffectView, Floats
from contactlab.testing import effect, run_check
from contactlab.testing.assertions import Check


@dataclass(frozen=True)
class Drag(Effect):
    """Forces -10 m v on the upper body, from 0.2 s on; one flaw or none."""

    flaw: str = ""

    dissipates: ClassVar[bool] = True
    needs_mass: ClassVar[bool] = True

    def times(self) -> tuple[float, ...]:
        return () if self.flaw == "hides its times" else (0.2,)

    def bind(self, view: EffectView) -> Callable[[float, Floats], None]:
        nodes = view.nodes("upper")
        velocity = view.velocity.copy() if self.flaw == "speed of the start" else view.velocity
        calls: list[float] = []

        def pull(time: float, force: Floats) -> None:
            calls.append(time)
            if self.flaw == "sets the force":
                force[:] = 0.0
            if self.flaw == "stops the nodes":
                velocity[nodes] *= 0.5
            if self.flaw == "undefined":
                force[0] += np.log(-1.0)
            late = time > 0.2 or (self.flaw == "counts its calls" and len(calls) > 1)
            if late and self.flaw != "does nothing":
                force[nodes] -= 10.0 * view.mass[nodes, None] * velocity[nodes]

        return pull


@pytest.mark.parametrize("check", effect.CHECKS)
def test_a_right_effect_passes(check: Check) -> None:
    assert run_check(check, Drag()).status in ("passed", "not applicable")


@dataclass(frozen=True)
class Boaster(Drag):
    """Promises what a drag on one body cannot keep."""

    conservative: ClassVar[bool] = True
    internal: ClassVar[bool] = True


@dataclass(frozen=True)
class Drive(Effect):
    """A force along the motion, of a size that nobody can choose."""

    size: float

    dissipates: ClassVar[bool] = True

    def bind(self, view: EffectView) -> Callable[[float, Floats], None]:
        def push(time: float, force: Floats) -> None:
            force += 2.0 * view.velocity

        return push


@dataclass(frozen=True)
class Whirl(Effect):
    """Pushes everything around the origin."""

    conservative: ClassVar[bool] = True

    def bind(self, view: EffectView) -> Callable[[float, Floats], None]:
        def push(time: float, force: Floats) -> None:
            x = view.reference + view.displacement
            force += np.stack([-x[:, 1], x[:, 0]], axis=1)

        return push


def test_facts_that_are_not_declared_are_told() -> None:
    outcome = run_check(effect.work_around_a_path_is_declared, Falling())
    assert (outcome.status, outcome.reason) == ("passed", "declare conservative = True")


@dataclass(frozen=True)
class Falling(Effect):
    """Weight, of which nothing is declared."""

    def bind(self, view: EffectView) -> Callable[[float, Floats], None]:
        def pull(time: float, force: Floats) -> None:
            force[:, 1] -= view.mass

        return pull


@dataclass(frozen=True)
class Misnamed(Falling):
    """Declares a point that it does not have."""

    points: ClassVar[tuple[str, ...]] = ("center",)


@dataclass(frozen=True)
class Late(Effect):
    """A pull that grows for a while, in a time that is not its own.

    force  [N]
    ramp   [s]
    """

    force: float = 1.0
    ramp: float = 0.5

    def times(self) -> tuple[float, ...]:
        return (self.ramp,)

    def bind(self, view: EffectView) -> Callable[[float, Floats], None]:
        def pull(time: float, force: Floats) -> None:
            force[:, 1] -= self.force * (time / 0.5 if time < self.ramp else 1.0)

        return pull


WRONG: list[tuple[Check, Effect]] = [
    (effect.units_do_not_matter_to_it, Late()),
    (effect.masses_are_asked_for, Falling()),
    (effect.points_and_vectors_are_fields, Misnamed()),
    (effect.numbers_count, Drive(3.0)),
    (effect.power_is_declared, Drive(3.0)),
    (effect.work_around_a_path_is_declared, Whirl()),
    (effect.resultants_are_declared, Boaster()),
    (effect.gives_forces, Drag("does nothing")),
    (effect.gives_forces, Drag("undefined")),
    (effect.adds_to_what_is_there, Drag("sets the force")),
    (effect.follows_the_state, Drag("speed of the start")),
    (effect.remembers_nothing, Drag("counts its calls")),
    (effect.leaves_the_view_alone, Drag("stops the nodes")),
    (effect.times_are_declared, Drag("hides its times")),
]


@pytest.mark.parametrize(("check", "part"), WRONG)
@pytest.mark.filterwarnings("ignore:invalid value")  # the logarithm that is to be caught
def test_wrong_effects_are_caught(caught: Any, check: Check, part: Effect) -> None:
    caught(check, part)


def test_every_check_has_a_wrong_part() -> None:
    assert {check for check, _ in WRONG} == set(effect.CHECKS) - {effect.memory_counts}


@dataclass(frozen=True)
class Creeping(Effect):
    """Springs on the upper body whose ends creep after the nodes, with one flaw or none."""

    flaw: str = ""

    memory: ClassVar[tuple[str, ...]] = ("x",)

    def bind(self, view: EffectView) -> Callable[..., Any]:
        nodes = view.nodes("upper")
        own = np.zeros(len(view.reference))

        def pull(time: float, force: Floats, dt: float, memory: dict[str, Floats]) -> Any:
            end = own if self.flaw == "own memory" else memory["x"]
            if self.flaw not in ("writes memory", "own memory"):
                end = end.copy()
            if self.flaw != "does not creep":
                end[nodes] += dt * (view.displacement[nodes, 0] - end[nodes])
            force[nodes, 0] -= view.displacement[nodes, 0] - (0.0 if self.flaw == "deaf" else end[nodes])
            if self.flaw == "gives nothing back":
                return None
            return {"y" if self.flaw == "another name" else "x": end[nodes] if self.flaw == "of its nodes" else end}

        return pull


@pytest.mark.parametrize(
    ("flaw", "found"),
    [
        ("own memory", "remembers_nothing"),
        ("writes memory", "memory_counts"),
        ("does not creep", "memory_counts"),
        ("deaf", "memory_counts"),
        ("gives nothing back", "memory_counts"),
        ("another name", "memory_counts"),
        ("of its nodes", "memory_counts"),
    ],
)
def test_flaws_of_memory_are_caught(flaw: str, found: str) -> None:
    checks = {check.__name__: check for check in effect.CHECKS}
    assert run_check(checks[found], Creeping()).status == "passed"
    assert run_check(checks[found], Creeping(flaw)).status == "failed"
