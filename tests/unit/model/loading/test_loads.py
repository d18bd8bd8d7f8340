"""Loads: resultants and moments of uniform tractions are known, whatever the mesh."""

from __future__ import annotations

import math

import numpy as np
import pytest

from contactlab.api import Floats
from contactlab.model.model import Model


def forces(model: Model, time: float = 0.0) -> Floats:
    out = np.full_like(model.reference, 7.0)
    assert model.external_force(time, out)
    return out


@pytest.mark.parametrize("element", ["q1", "q2", "q2-lagrange"])
@pytest.mark.parametrize(
    ("load", "resultant", "moment"),
    [
        ({"pressure": 3.0}, (0.0, -6.0), -6.0),
        ({"shear": 2.0}, (-4.0, 0.0), 4.0),
        ({"tx": 1.5, "ty": 0.5}, (3.0, 1.0), -2.0),
        ({"pressure": 3.0, "follower": False}, (0.0, -6.0), -6.0),
    ],
)
def test_resultants_are_traction_times_length(
    make, element: str, load: dict, resultant: tuple[float, float], moment: float
) -> None:
    """The top is 2 long, at y = 1, with its middle at x = 1; moments are about the origin."""
    model = make({"bodies.upper.element": element}, loads=[{"on": "upper.top", **load}])
    f, x = forces(model), model.reference
    assert f.sum(axis=0) == pytest.approx(resultant, abs=1e-13)
    assert x[:, 0] @ f[:, 1] - x[:, 1] @ f[:, 0] == pytest.approx(moment, abs=1e-13)


def test_only_follower_loads_turn_with_the_body(make) -> None:
    angle = 0.7
    for follower in (True, False):
        model = make(loads=[{"on": "upper.top", "pressure": 3.0, "follower": follower}])
        cos, sin = math.cos(angle), math.sin(angle)
        model.position[:] = 1.5 * model.reference @ np.array([[cos, sin], [-sin, cos]])
        expected = 1.5 * np.array([6.0 * sin, -6.0 * cos]) if follower else np.array([0.0, -6.0])
        assert forces(model).sum(axis=0) == pytest.approx(expected, abs=1e-12)


def test_a_closed_boundary_under_pressure_has_no_resultant(make) -> None:
    """Integral of the normal over a closed curve is zero, also on a curved one."""
    model = make(
        {"bodies.upper.mesh": {"use": "disc", "radius": 0.5, "cells": [3, 2]}, "bodies.upper.shift": [1.0, 0.5]},
        contacts=[],
        loads=[{"on": "upper.arc", "pressure": 10.0}],
    )
    assert forces(model).sum(axis=0) == pytest.approx([0.0, 0.0], abs=1e-13)


def test_loads_follow_their_course_in_time(make) -> None:
    ramp = {"ramp": "table", "to": 2.0, "points": [[0.0, 0.0], [1e-4, 1.0], [3e-4, 0.5]], "begin": 1e-4}
    model = make(loads=[{"on": "upper.top", "ty": ramp}])
    found = [forces(model, time)[:, 1].sum() for time in (0.0, 1e-4, 1.5e-4, 2e-4, 3e-4, 1.0)]
    assert found == pytest.approx([0.0, 0.0, 2.0, 4.0, 3.0, 2.0])


def test_the_work_of_a_load_is_its_force_times_the_way(make) -> None:
    """A free body of mass 2e-6 under 4 N for 1e-4 s: the ledger books exactly the kinetic energy it gains."""
    model = make(contacts=[], loads=[{"on": "upper.top", "tx": 2.0}])
    advance = model.bound_integrator().step
    dt = 0.5 * model.stable_step()
    for _ in range(50):
        advance(dt)
    work = model.state["work"]
    assert work[1] == pytest.approx(model.kinetic_energy() + work[0], rel=1e-12)
    momentum = model.mass[:15] @ model.state["velocity"][:15, 0]
    assert momentum == pytest.approx(4.0 * (50 - 0.5) * dt, rel=1e-12)  # the first step is half a step of force
