"""Loads have the resultant and the moment of their profile, however narrow it is and wherever it lies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from contactlab.api import Floats, Function
from contactlab.api.part import Part
from contactlab.model.build import build
from contactlab.model.model import Model
from contactlab.parts.registry import Registry
from contactlab.scene.scene import Scene

RECTANGLE = {"use": "rectangle", "x": [-2.0, 2.0], "y": [-1.0, 0.0], "cells": [16, 4]}  # edges of 0.25
RING = {"use": "ring", "radii": [1.0, 2.0], "cells": [40, 2], "angles": [60.0, 240.0]}


@dataclass(frozen=True)
class Bell(Function):
    """exp(-(x - c)^2 / 2 w^2), of which nothing is declared."""

    width: float

    def values(self, at: Floats) -> Floats:
        return np.exp(-0.5 * ((at - 0.1234) / self.width) ** 2)


@dataclass(frozen=True)
class Box(Bell):
    """1 within the width on either side, and 0 elsewhere."""

    def values(self, at: Floats) -> Floats:
        return np.where(np.abs(at - 0.1234) < self.width, 1.0, 0.0)


PARTS = [
    (Part("function", name.__name__.lower(), f"{__name__}:{name.__name__}", "a test"), name) for name in (Bell, Box)
]
REGISTRY = Registry(classes=PARTS)


def made(on: str = "top", mesh: dict[str, Any] = RECTANGLE, element: str = "q1", **more: Any) -> Model:
    foot = {"on": "b.bottom" if on == "top" else "b.inner", "ux": 0.0, "uy": 0.0}
    scene = Scene.from_data({
        "time": {"end": 1.0},
        "integrator": "newton",
        "materials": {"m": {"use": "linear-elastic", "young": 1000.0, "poisson": 0.3, "density": 1e-9}},
        "bodies": {"b": {"element": element, "material": "m", "mesh": mesh}},
        "supports": [foot], **more,
    }, registry=REGISTRY)  # fmt: skip
    return build(scene, REGISTRY)


def forces(model: Model) -> Floats:
    out = np.zeros_like(model.reference)
    assert model.external_force(1.0, out)
    return out


def ellipse(half_width: float, centre: float, by: str = "x") -> dict[str, Any]:
    return {"by": by, "function": {"use": "half-ellipse", "half_width": half_width, "centre": centre}}


@pytest.mark.parametrize(
    ("load", "element"),
    [
        ({"pressure": 3.0}, "q1"),
        ({"pressure": 3.0, "follower": False}, "q1"),
        ({"ty": -3.0}, "q2"),
        pytest.param({"pressure": 3.0}, "q2", marks=pytest.mark.full),
    ],
)
def test_a_half_ellipse_has_its_resultant_and_its_place(load: dict[str, Any], element: str) -> None:
    """3 pi b/2 at its centre: three points of each edge gave -100 % to 242 %."""
    for half_width in (0.1, 0.02):
        for centre in (0.13, -1.01):
            model = made(element=element, loads=[{"on": "b.top", "profile": ellipse(half_width, centre), **load}])
            found = forces(model)[:, 1]
            assert found.sum() == pytest.approx(-1.5 * np.pi * half_width, rel=1e-9)
            assert model.reference[:, 0] @ found == pytest.approx(found.sum() * centre, abs=1e-10)
            assert not model.warnings


def test_a_half_ellipse_that_ends_with_the_edges_has_the_part_that_lies_on_them() -> None:
    found = forces(made(loads=[{"on": "b.top", "pressure": 3.0, "profile": ellipse(0.06, 2.0)}]))[:, 1]
    assert found.sum() == pytest.approx(-0.75 * np.pi * 0.06, rel=1e-9)


@pytest.mark.parametrize(("by", "element"), [("angle", "q1"), ("s", "q2")])
def test_curved_edges_are_split_by_angle_and_by_arc_length(by: str, element: str) -> None:
    """On an arc of radius 2; chords are shorter by a sixth of the square of 2.25 degrees, quadratic edges by less."""
    for centre in (100.3, 180.0, 213.0):
        place = centre if by == "angle" else np.radians(centre - 60.0) * 2.0
        width = 0.5 if by == "angle" else np.radians(1.0)
        model = made(
            "outer", RING, element, loads=[{"on": "b.outer", "pressure": 3.0, "profile": ellipse(width, place, by)}]
        )
        found = forces(model).sum(axis=0)
        length = np.pi * np.radians(0.5) if by == "angle" else 0.5 * np.pi * width
        assert np.hypot(*found) == pytest.approx(3.0 * length, rel=2e-3)
        # a chord's normal may be off by half of its angle, and it is that of the curve on quadratic ones
        off = 2.3 if element == "q1" else 0.05
        assert np.degrees(np.arctan2(-found[1], -found[0])) % 360.0 == pytest.approx(centre, abs=off)


def test_a_follower_keeps_its_resultant_as_the_edge_moves() -> None:
    """Stretched to twice its length an edge has twice the force of its pressure; turned, the force turns."""
    model = made(loads=[{"on": "b.top", "pressure": 3.0, "profile": ellipse(0.05, 0.13)}])
    model.position[:, 0] *= 2.0
    assert forces(model).sum(axis=0) == pytest.approx([0.0, -3.0 * np.pi * 0.05], rel=1e-9, abs=1e-12)
    model.position[:] = model.reference @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    assert forces(model).sum(axis=0) == pytest.approx([1.5 * np.pi * 0.05, 0.0], rel=1e-9, abs=1e-12)


def test_a_table_finer_than_the_edges_has_its_integral(tmp_path) -> None:
    """A thousand points at random, from a file and from the scene."""
    x = np.linspace(-2.0, 2.0, 1001)
    pairs = np.stack([x, np.random.default_rng(1).uniform(-1.0, 2.0, len(x))], axis=1)
    np.savetxt(path := tmp_path / "load.csv", pairs, delimiter=",", fmt="%.17g")
    for profile in ({"by": "x", "table": pairs.tolist()}, {"by": "x", "file": str(path)}):
        found = forces(made(loads=[{"on": "b.top", "ty": 1.0, "profile": profile}]))[:, 1]
        assert found.sum() == pytest.approx(np.trapezoid(pairs[:, 1], x), rel=1e-11)


@pytest.mark.parametrize(("name", "area"), [("bell", np.sqrt(2.0 * np.pi)), ("box", 2.0)])
@pytest.mark.parametrize("width", [0.3, 1e-2, 1e-3])
def test_functions_that_declare_no_breaks_are_halved_until_they_are_known(name: str, area: float, width: float) -> None:
    load = {"on": "b.top", "ty": 1.0, "profile": {"by": "x", "function": {"use": name, "width": width}}}
    model = made(loads=[load])
    assert forces(model)[:, 1].sum() == pytest.approx(area * width, rel=1e-8)
    assert not model.warnings


def test_a_load_on_nothing_is_told() -> None:
    (told,) = made(loads=[{"on": "b.top", "ty": 1.0, "profile": ellipse(0.5, 7.0)}]).warnings
    assert told.code == "load-resultant"
    assert "0 all along the edges" in told.text


def test_an_integral_that_two_rules_find_differently_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Between a bell of 1e-5 and its neighbours nobody looks, if it hides from the first places."""
    monkeypatch.setattr("contactlab.model.loading.edge_integrals.MOST", 10_000)  # pieces, reached all the same
    load = {"on": "b.top", "ty": 1.0, "profile": {"by": "x", "function": {"use": "bell", "width": 6e-6}}}
    (told,) = made(loads=[load]).warnings
    assert told.code == "load-resultant"
    assert told.key == "loads.0.profile"


# --- at nodes ---------------------------------------------------------------------------------------

SUPPORT = {"on": "b.bottom", "ux": 0.0, "uy": 0.1}
GRAVITY = {"use": "gravity", "acceleration": [0.0, -1.0]}
SPRING = {"use": "spring", "on": "b.top", "stiffness": [0.0, 1.0]}


@pytest.mark.parametrize("table", ["supports", "gravity", "spring", "velocity"])
@pytest.mark.parametrize(("half_width", "told"), [(0.05, True), (0.3, True), (4.0, False)])
def test_profiles_that_nodes_do_not_see_are_told(table: str, half_width: float, told: bool) -> None:
    """Narrower than the edges, of some nodes with infinite slopes between them, and wide."""
    profile = {"profile": ellipse(half_width, 0.13)}
    more: dict[str, Any] = {
        "supports": {"supports": [SUPPORT | profile]},
        "gravity": {"effects": [GRAVITY | profile]},
        "spring": {"effects": [SPRING | profile]},
        "velocity": {"integrator": "implicit-dynamics"},
    }[table]
    if table == "velocity":
        body = {"element": "q1", "material": "m", "mesh": RECTANGLE, "velocity": [0.0, 1.0], **profile}
        more |= {"bodies": {"b": body}}
    warnings = [warning for warning in made(**more).warnings if warning.code == "coarse-profile"]
    assert [warning.key.rpartition(".")[2] for warning in warnings] == (["profile"] if told else [])


def test_a_cosine_along_a_support_needs_some_nodes_a_wave() -> None:
    """Straight lines between n nodes a wave miss (2 pi/n)^2/12 of it: 2 % at 13 nodes."""
    for nodes, told in ((8, True), (12, True), (15, False)):
        profile = {"by": "s", "cosine": [0.0, 1.0, 0.25 * nodes]}
        model = made(supports=[SUPPORT | {"profile": profile}])
        found = [warning.value for warning in model.warnings]
        assert bool(found) == told
        if found:
            assert found[0] == pytest.approx((2.0 * np.pi / nodes) ** 2 / 12.0, rel=0.1)
