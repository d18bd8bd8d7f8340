"""Every check of effects catches a planted defect, and a right one passes all of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from contactlab.api import Effect, EffectView, Floats
from contactlab.testing import effect
from contactlab.testing.assertions import Check


@dataclass(frozen=True)
class Drag(Effect):
    """Forces -10 m v on the upper body, from 0.2 s on; one flaw or none."""

    flaw: str = ""

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
    check(Drag())


WRONG: list[tuple[Check, Effect]] = [
    (effect.gives_forces, Drag("does nothing")),
    (effect.gives_forces, Drag("undefined")),
    (effect.adds_to_what_is_there, Drag("sets the force")),
    (effect.follows_the_state, Drag("speed of the start")),
    (effect.remembers_nothing, Drag("counts its calls")),
    (effect.leaves_the_view_alone, Drag("stops the nodes")),
]


@pytest.mark.parametrize(("check", "part"), WRONG)
@pytest.mark.filterwarnings("ignore:invalid value")  # the logarithm that is to be caught
def test_wrong_effects_are_caught(caught: Any, check: Check, part: Effect) -> None:
    caught(check, part)


def test_every_check_has_a_wrong_part() -> None:
    assert {check for check, _ in WRONG} == set(effect.CHECKS)
