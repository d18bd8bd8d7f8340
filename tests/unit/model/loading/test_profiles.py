"""Profiles by functions that are parts, profiles of fields, and functions of time."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
import pytest

from contactlab.api import Floats, Function
from contactlab.api.part import Part
from contactlab.errors import PartError, SceneError
from contactlab.model.build import build
from contactlab.model.model import Model
from contactlab.parts.provenance import parts_of
from contactlab.parts.registry import Registry
from contactlab.scene.scene import Scene

ELLIPSE = {"use": "half-ellipse", "half_width": 0.5, "centre": 1.0}


def forces(model: Model, time: float = 0.0) -> Floats:
    out = np.zeros_like(model.reference)
    assert model.external_force(time, out)
    return out


def test_a_load_varies_by_a_function_as_by_a_table_of_its_values(make) -> None:
    """2 + 3 x - x^2 at the integration points; a table straight between points is as good as its points are near."""
    x = np.linspace(0.0, 2.0, 2001)
    table = np.stack([x, 2.0 + 3.0 * x - x**2], axis=1).tolist()
    function = {"use": "polynomial", "coefficients": [2.0, 3.0, -1.0]}
    found = [
        forces(make(loads=[{"on": "upper.top", "pressure": 3.0, "profile": {"by": "x", **how}}]))
        for how in ({"table": table}, {"function": function})
    ]
    assert found[1] == pytest.approx(found[0], abs=3e-6)  # 1e-3 squared, of a slope of at most 3
    # the integral is 4 + 6 - 8/3; three points are exact for a parabola
    assert found[1][:, 1].sum() == pytest.approx(-3.0 * (10.0 - 8.0 / 3.0), rel=1e-13)


def test_a_mean_keeps_the_resultant_of_a_function(make) -> None:
    profile = {"by": "x", "function": ELLIPSE, "mean": 0.4}
    found = forces(make(loads=[{"on": "upper.top", "pressure": 3.0, "profile": profile}]))
    assert found.sum(axis=0) == pytest.approx([0.0, -2.4], abs=1e-13)


def test_gravity_and_springs_vary_over_a_body(make) -> None:
    """(1 + y) g over 0 < y < 1 and the lumped masses: the sum over nodes of m (1 + y) g."""
    line = {"by": "y", "function": {"use": "polynomial", "coefficients": [1.0, 1.0]}}
    gravity = {"use": "gravity", "acceleration": [0.0, -10.0], "on": ["upper"], "profile": line}
    model = make(effects=[gravity])
    own = model.reference[:, 1] >= 0.0
    own &= np.arange(len(own)) < model.bodies[0].count
    expected = -10.0 * np.where(own, model.mass * (1.0 + model.reference[:, 1]), 0.0)
    assert forces(model)[:, 1] == pytest.approx(expected, rel=1e-14)
    springs = make(effects=[{"use": "spring", "on": "lower.bottom", "stiffness": [0.0, 12.0], "profile": line}])
    springs.state["displacement"][:, 1] = 0.1  # at y = -1 the factor is 0
    assert not forces(springs).any()


def test_initial_velocities_vary_over_a_body(make) -> None:
    model = make(
        {"bodies.upper.velocity": [3.0, -2.0], "bodies.upper.profile": {"by": "x", "table": [[0.0, 1.0], [2.0, 0.0]]}}
    )
    own = slice(0, model.bodies[0].count)
    x = model.reference[own, 0]
    assert model.state["velocity"][own] == pytest.approx(np.outer(1.0 - x / 2.0, [3.0, -2.0]), abs=1e-14)


def test_values_in_time_follow_a_function_and_a_file(make, tmp_path) -> None:
    path = tmp_path / "way.csv"
    path.write_text("0.0,0.0\n1e-4,1.0\n3e-4,0.5\n")
    wave = {"ramp": "function", "to": 2.0, "begin": 1e-4, "function": {"use": "sine", "period": 4e-4}}
    model = make(loads=[{"on": "upper.top", "pressure": wave}, {"on": "upper.left", "tx": {
        "ramp": "table", "to": 5.0, "file": str(path)}}])  # fmt: skip
    for time, pressure, tx in ((0.0, 0.0, 0.0), (1e-4, 0.0, 1.0), (2e-4, 1.0, 0.75), (4e-4, -1.0, 0.5)):
        assert forces(model, time).sum(axis=0) == pytest.approx([5.0 * tx, -2.0 * 2.0 * pressure], abs=1e-12)


@pytest.mark.parametrize(
    ("tables", "says"),
    [
        ({"loads": [{"on": "upper.top", "tx": 1.0, "profile": {"by": "x", "function": "half-elipse"}}]},
         r"loads.0.profile.function.*no function of this name.*did you mean"),
        ({"loads": [{"on": "upper.top", "tx": 1.0, "profile": {"by": "x", "function": "half-ellipse"}}]},
         r"half_width.*missing"),
        ({"loads": [{"on": "upper.top", "tx": 1.0, "profile": {"by": "x", "function": {**ELLIPSE, "half_width": 0}}}]},
         r"half_width"),
        ({"loads": [{"on": "upper.top", "tx": 1.0, "profile": {"by": "x", "function": ELLIPSE, "cosine": [1, 1, 1]}}]},
         "one of these four"),
        ({"loads": [{"on": "upper.top", "tx": {"ramp": "function", "to": 1.0}}]}, "a function with ramp"),
        ({"loads": [{"on": "upper.top", "tx": {"ramp": "linear", "to": 1.0, "function": ELLIPSE}}]}, "else none"),
        ({"loads": [{"on": "upper.top", "tx": {"ramp": "function", "to": 1.0, "duration": 1.0, "function": ELLIPSE}}]},
         "none with times in seconds"),
        ({"loads": [{"on": "upper.top", "tx": {"ramp": "table", "to": 1.0, "file": "nowhere.csv"}}]},
         "the file cannot be read"),
        ({"effects": [{"use": "gravity", "acceleration": [0.0, 1.0], "profile": {"by": "s", "function": ELLIPSE}}]},
         r"effects.0.profile.by.*no arc length"),
        ({"effects": [{"use": "gravity", "acceleration": [0.0, 1.0],
                       "profile": {"by": "x", "function": ELLIPSE, "mean": 1.0}}]}, "no resultant to keep"),
        ({"effects": [{"use": "gravity", "acceleration": [0.0, 1.0], "profile": {"by": "x"}}]}, "one of these four"),
    ],
)  # fmt: skip
def test_mistakes_are_told_where_they_are(make, tables: dict, says: str) -> None:
    with pytest.raises((SceneError, PartError)) as error:
        make(**tables)
    text = " ".join(str(error.value).split())
    assert re.search(says, text), text


@dataclass(frozen=True)
class Wrong(Function):
    """Gives what is no number, as its field says."""

    how: str

    def values(self, at: Floats) -> Floats:
        if self.how == "raises":
            raise RuntimeError("no data")
        return {"nan": np.where(at > 1.0, np.nan, 1.0), "short": at[1:]}[self.how]


@pytest.mark.parametrize(("how", "says"), [("nan", "nan at"), ("short", "shape"), ("raises", "RuntimeError: no data")])
def test_functions_that_give_no_numbers_are_told(how: str, says: str) -> None:
    registry = Registry(classes=[(Part("function", "wrong", f"{__name__}:Wrong", "wrong"), Wrong)])
    scene = Scene.from_data(
        {
            "integrator": "newton",
            "materials": {"m": {"use": "linear-elastic", "young": 1.0, "poisson": 0.0, "density": 1.0}},
            "bodies": {"b": {"element": "q1", "material": "m",
                             "mesh": {"use": "rectangle", "x": [0.0, 2.0], "y": [0.0, 1.0], "cells": [4, 2]}}},
            "supports": [{"on": "b.bottom", "ux": 0.0, "uy": 0.0}],
            "loads": [{"on": "b.top", "ty": 1.0, "profile": {"by": "x", "function": {"use": "wrong", "how": how}}}],
        },
        registry=registry,
    )  # fmt: skip
    assert parts_of(scene, registry)["loads.0.profile.function"].startswith("wrong (")
    with pytest.raises(PartError, match=says) as error:
        build(scene, registry)
    assert "loads.0.profile.function" in str(error.value)
