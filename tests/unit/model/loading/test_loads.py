"""Loads: resultants and moments of uniform tractions are known, whatever the mesh."""

from __future__ import annotations

import math

import numpy as np
import pytest

from contactlab.api import Floats
from contactlab.errors import SceneError
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


@pytest.mark.parametrize("component", ["tx", "ty"])
def test_dead_loads_vary_by_file_and_angle_too(make, component: str, tmp_path) -> None:
    path = tmp_path / "factor.csv"
    path.write_text("-180.0,2.0\n180.0,2.0\n")
    profile = {"by": "angle", "centre": [1.0, 0.0], "file": str(path)}
    model = make(loads=[{"on": "upper.top", component: 1.5, "profile": profile}])
    assert forces(model).sum() == pytest.approx(6.0, abs=1e-12)


def test_derivatives_of_a_varying_follower_load_are_those_of_its_forces(make) -> None:
    """Forces are linear in positions: central differences are exact but for round-off."""
    profile = {"by": "x", "cosine": [1.0, 0.7, 3.0]}
    model = make(loads=[{"on": "upper.top", "pressure": 3.0, "shear": 1.0, "profile": profile}])
    (load,) = model.loading.loads
    rows, columns, pressure, shear = load.derivatives()
    size = 2 * len(model.reference)
    found = np.zeros((size, size))
    np.add.at(found, (rows, columns), 3.0 * pressure + shear)
    by_differences = np.zeros((size, size))
    for dof in np.unique(columns):
        sides = []
        for step in (1e-3, -1e-3):
            model.position.ravel()[dof] += step
            sides.append(forces(model).ravel())
            model.position.ravel()[dof] -= step
        by_differences[:, dof] = (sides[0] - sides[1]) / 2e-3
    assert found == pytest.approx(by_differences, abs=1e-9)


@pytest.mark.parametrize("element", ["q1", "q2"])
def test_a_profile_by_arc_length_begins_where_the_edges_do(make, element: str) -> None:
    """The top runs from x = 2 to 0 with the body on its left: 3 (1 + s/2) has its larger end at x = 0."""
    profile = {"by": "s", "table": [[0.0, 1.0], [2.0, 2.0]]}
    model = make({"bodies.upper.element": element}, loads=[{"on": "upper.top", "pressure": 3.0, "profile": profile}])
    f = forces(model)
    assert f.sum(axis=0) == pytest.approx([0.0, -9.0], abs=1e-12)
    assert (2.0 - model.reference[:, 0]) @ f[:, 1] == pytest.approx(-10.0, abs=1e-12)


def test_a_mean_scales_the_resultant(make) -> None:
    """A step inside an edge, whose integral is 1.69995, scaled to a mean of 0.85 over a length of 2."""
    step = {"by": "x", "table": [[0.0, 0.0], [0.3, 0.0], [0.3001, 1.0], [2.0, 1.0]]}
    found = [
        forces(make(loads=[{"on": "upper.top", "pressure": 3.0, "profile": step | more}]))[:, 1].sum()
        for more in ({}, {"mean": 0.85})
    ]
    assert found == pytest.approx([-3.0 * 1.69995, -3.0 * 1.7], rel=1e-12)
    with pytest.raises(SceneError, match="no mean to be scaled"):
        make(loads=[{"on": "upper.top", "pressure": 3.0, "profile": {"by": "x", "cosine": [0.0, 1.0, 1.0], "mean": 1}}])


@pytest.mark.parametrize("by", ["x", "s"])
def test_supports_vary_from_node_to_node(make, by: str) -> None:
    """uy = 0.01 (1 - x/4) over the foot, whose arc length runs with x; beside it a support that holds nothing moves."""
    profile = {"by": by, "table": [[0.0, 1.0], [4.0, 0.0]]}
    support = {"on": "lower.bottom", "ux": 0.0, "uy": {"ramp": "linear", "to": 0.01}, "profile": profile}
    model = make(supports=[support])
    prescribed = model.prescribed
    y = prescribed.dof % 2 == 1
    x = model.reference[prescribed.dof[y] // 2, 0]
    assert prescribed.scale[y] == pytest.approx(0.01 * (1.0 - x / 4.0), abs=1e-15)
    with pytest.raises(SceneError, match=r"a mean under loads alone"):
        make(supports=[support | {"profile": profile | {"mean": 1.0}}])
