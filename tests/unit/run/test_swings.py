"""Where values in time turn, however fast they do so and whatever they rest in between."""

from __future__ import annotations

import numpy as np
import pytest

from contactlab.api import Floats, Function
from contactlab.model.timing import Timing
from contactlab.run.swings import Swing, swings_of
from contactlab.scene.scene import Scene

END = 1.0


def swing(ramp: dict) -> Swing | None:
    """The swings of a load in a run of 1 s."""
    from contactlab.model.build import build

    scene = Scene.from_data({
        "time": {"end": END},
        "integrator": "newton",
        "materials": {"m": {"use": "linear-elastic", "young": 1.0, "poisson": 0.0, "density": 1.0}},
        "bodies": {"b": {"element": "q1", "material": "m",
                         "mesh": {"use": "rectangle", "x": [0.0, 1.0], "y": [0.0, 1.0], "cells": [1, 1]}}},
        "supports": [{"on": "b.bottom", "ux": 0.0, "uy": 0.0}],
        "loads": [{"on": "b.top", "ty": {"to": 1.0, **ramp}}],
    })  # fmt: skip
    timing: Timing = build(scene, scene.registry).timing
    found = swings_of(scene, timing)
    return found[0] if found else None


def sine(period: float, **more: float) -> dict:
    return {"ramp": "function", "function": {"use": "sine", "period": period}, **more}


def test_a_pulse_between_two_rests_is_seen_by_its_breaks() -> None:
    pulse = {"ramp": "function", "begin": 0.2, "function": {"use": "half-ellipse", "half_width": 1e-5, "centre": 0.3}}
    found = swing(pulse)
    assert found is not None
    assert found.turns == pytest.approx([0.5 - 1e-5, 0.5, 0.5 + 1e-5], abs=1e-7)
    assert 5e-6 < found.shortest < 1.1e-5


def test_rests_of_a_table_are_no_part_of_its_ways() -> None:
    found = swing({"ramp": "table", "points": [[0.0, 0.0], [0.1, 1.0], [0.8, 1.0], [0.9, 0.0]]})
    assert found is not None
    assert found.turns == pytest.approx([0.0, 0.8, 0.9])
    assert found.shortest == pytest.approx(0.1, rel=1e-3)


def test_a_jump_has_no_course_to_follow_but_the_rest_after_it() -> None:
    """A load that is taken off at once is no swing of 1e-7 s, and pulses are followed by what is between them."""
    off = swing({"ramp": "table", "points": [[0.0, 0.0], [0.6, 1.0], [0.6 + 1e-7, 0.0], [1.0, 0.0]]})
    assert off is not None
    assert off.turns == pytest.approx([0.0, 0.6, 0.6], abs=1e-6)
    assert off.shortest == pytest.approx(0.4, rel=1e-2)
    square = [[0.1 * k + 1e-7 * j, (k + j) % 2] for k in range(1, 10) for j in (0, 1)]
    pulses = swing({"ramp": "table", "points": square})
    assert pulses is not None
    assert pulses.shortest == pytest.approx(0.1, rel=1e-2)


@pytest.mark.parametrize(
    "ramp",
    [
        {"ramp": "linear"},
        {"ramp": "table", "points": [[0.0, 0.0], [0.5, 0.3], [0.6, 0.3], [2.0, 1.0]]},
        sine(8.0),
        sine(0.1, begin=0.99),
        {"ramp": "function", "function": {"use": "polynomial", "coefficients": [1.0]}},
    ],
)
def test_what_does_not_turn_within_the_run_is_no_swing(ramp: dict) -> None:
    assert swing(ramp) is None


class Ripple(Function):
    """A rise with a ripple of a thousandth."""

    def values(self, at: Floats) -> Floats:
        return at + 1e-3 * np.sin(300.0 * at)


def test_ripples_are_not_followed() -> None:
    from contactlab.run.swings import _turns

    times = np.linspace(0.0, 1.0, 4001)
    assert _turns(Ripple().values(times)) == [0, 4000]
    wave = np.sin(20.0 * times) + 1e-3 * np.sin(3000.0 * times)
    assert len(_turns(wave)) == 8
