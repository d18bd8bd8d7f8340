"""Friction of surfaces that close within a load step: the run knows by how much its shear is off."""

from __future__ import annotations

import pytest

import contactlab
from contactlab.results.results import Results
from contactlab.scene.scene import Scene

GAP, DOWN, ALONG, YOUNG = 0.0035, 0.01, 0.002, 1000.0


def landed(steps: int, algorithm: str, share: float = 1.0, mu: float = 2.0, width: float = 1.0) -> Results:
    """A square that moves by a share of DOWN and ALONG; it touches a rough floor after 0.35 of both."""
    return contactlab.simulate(Scene.from_data({
        "format": 1, "name": "landing", "integrator": {"use": "newton", "steps": steps},
        "record": {"frames": 1, "recorders": []},
        "materials": {"m": {"use": "linear-elastic", "young": YOUNG, "poisson": 0.0, "density": 1e-9}},
        "bodies": {"b": {
            "material": "m", "element": "q1",
            "mesh": {"use": "rectangle", "x": [0.0, width], "y": [GAP, 1.0 + GAP], "cells": [2, 1]},
        }},
        "rigid": {"floor": {"line": [[2.0 * width, 0.0], [-width, 0.0]]}},
        "contacts": [{
            "slave": "b.bottom", "master": "floor", "algorithm": algorithm, "friction": {"use": "coulomb", "mu": mu},
        }],
        "supports": [{
            "on": "b.top",
            "ux": {"ramp": "linear", "to": share * ALONG}, "uy": {"ramp": "linear", "to": -share * DOWN},
        }],
    }))  # fmt: skip


@pytest.mark.parametrize("algorithm", ["mortar-p1", "node-on-segment"])
def test_the_slip_before_a_touch_that_friction_holds_in_error_is_told_with_its_share_of_the_shear(
    algorithm: str,
) -> None:
    stiffness, touch = YOUNG / 2.0, GAP / DOWN
    coarse, exact = landed(10, algorithm), landed(20, algorithm)
    # the floor holds since the touch, which is the end of a step: simple shear of the square
    assert exact.summary["reactions"]["b.top"][0] == pytest.approx(stiffness * ALONG * (1.0 - touch), rel=1e-6)
    assert not exact.warnings
    # in ten steps since the start of the one in which it closes
    assert coarse.summary["reactions"]["b.top"][0] == pytest.approx(stiffness * ALONG * 0.7, rel=1e-6)
    (warning,) = coarse.warnings
    assert (warning.code, warning.key) == ("friction-steps", "integrator.steps")
    # all is linear: the estimate is the error
    assert warning.value == pytest.approx((touch - 0.3) / 0.7, rel=1e-6)


@pytest.mark.parametrize("algorithm", ["mortar-p1", "node-on-segment"])
def test_surfaces_that_slide_only_by_the_slip_before_they_touched_are_told(algorithm: str) -> None:
    """From 0.35 to 0.4 of both motions the floor holds: the shear is 0.1 of the pressure, below mu = 0.12.

    A step from 0.2 to 0.4 counts four times this shear, so that friction gives way at its bound. The square is wide:
    at its ends the moment of the shear changes the pressure by 1/width.
    """
    wide = 1e4
    touched = (0.4 - GAP / DOWN) * ALONG
    coarse, exact = (landed(steps, algorithm, 0.4, 0.12, wide) for steps in (2, 8))
    assert exact.summary["reactions"]["b.top"][0] == pytest.approx(wide * YOUNG / 2.0 * touched, rel=1e-6)
    assert not exact.warnings
    bound = 0.12 * YOUNG * (0.4 * DOWN - GAP)
    assert coarse.summary["reactions"]["b.top"][0] == pytest.approx(wide * bound, rel=1e-6)
    (warning,) = coarse.warnings
    assert (warning.code, warning.key) == ("friction-steps", "integrator.steps")
    assert warning.value == pytest.approx(1.0 - YOUNG / 2.0 * touched / bound, rel=1e-3)


def test_a_curve_that_touches_where_it_moves_straight_has_no_slip_before() -> None:
    """A roll whose lowest node comes straight down on a floor: there is no shear, and none is estimated.

    The open nodes on both sides of it slide, to opposite sides.
    """
    results = contactlab.simulate(Scene.from_data({
        "integrator": {"use": "newton", "steps": 5}, "record": {"frames": 1, "recorders": []},
        "materials": {"m": {"use": "linear-elastic", "young": YOUNG, "poisson": 0.3, "density": 1e-9}},
        "bodies": {"roll": {
            "material": "m", "element": "q1", "shift": [0.0, 1.005],
            "mesh": {"use": "ring", "radii": [0.5, 1.0], "cells": [12, 2], "angles": [-150.0, -30.0]},
        }},
        "rigid": {"floor": {"line": [[2.0, 0.0], [-2.0, 0.0]]}},
        "contacts": [{
            "slave": "roll.outer", "master": "floor", "algorithm": "node-on-segment",
            "friction": {"use": "coulomb", "mu": 0.3},
        }],
        "supports": [{"on": "roll.inner", "ux": 0.0, "uy": {"ramp": "linear", "to": -0.02}}],
    }))  # fmt: skip
    curve = results.contact["contacts.0"].last
    assert abs(curve.shear).max() <= 1e-6 * curve.pressure.max()  # residual of the steps
    assert "friction-steps" not in {warning.code for warning in results.warnings}


def rolled(steps: int) -> Results:
    """A wheel, driven by its inside, that rolls by three widths of its contact and slips by a share of it (Carter)."""
    wheel = {"use": "ring", "radii": [8.0, 10.0], "cells": [60, 3], "angles": [-112.0, -74.0]}
    away = {"ramp": "linear", "begin": 1.0, "duration": 1.0}
    turn = {"to": -17.3, "about": [0.0, 10.0]} | away  # 3 mm at the radius, and 0.8 % more
    return contactlab.simulate(Scene.from_data({
        "integrator": {"use": "newton", "steps": steps}, "record": {"frames": 20, "recorders": []},
        "materials": {"m": {"use": "neo-hookean", "young": 1000.0, "poisson": 0.3, "density": 1e-9}},
        "bodies": {
            "wheel": {"element": "q1", "material": "m", "mesh": wheel, "shift": [0.0, 10.0]},
            "rail": {
                "element": "q1", "material": "m",
                "mesh": {"use": "rectangle", "x": [-2.0, 5.0], "y": [-2.0, 0.0], "cells": [56, 4]},
            },
        },
        "contacts": [{
            "slave": "wheel.outer", "master": "rail.top", "algorithm": "mortar-p1",
            "friction": {"use": "coulomb", "mu": 0.2},
        }],
        "supports": [
            {"on": "rail.bottom", "ux": 0.0, "uy": 0.0},
            {"on": "wheel.inner", "uy": {"ramp": "linear", "to": -0.04, "duration": 1.0}, "ux": {"to": 3.0} | away,
             "turn": turn},
        ],
    }))  # fmt: skip


def test_rolling_in_steps_that_exchange_much_of_the_contact_is_told() -> None:
    """Friction of nodes that enter and stick follows from slips of the whole step: 10 % of the force and more."""
    coarse, fine = rolled(10), rolled(50)
    shear = [results.summary["contacts"]["contacts.0"]["resultant"][0] for results in (coarse, fine)]
    assert abs(shear[0] / shear[1] - 1.0) > 0.1
    told = [{warning.code for warning in results.warnings} for results in (coarse, fine)]
    assert "friction-steps" in told[0] - told[1]
