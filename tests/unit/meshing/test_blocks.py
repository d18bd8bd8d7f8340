"""Blocks and round bodies: areas, arcs, and nodes where they should be."""

from __future__ import annotations

import math

import numpy as np
import pytest
from contactlab_quads.q1 import Q1
from contactlab_quads.q2_lagrange import Q2Lagrange

from contactlab.api import Mesh, MeshSource
from contactlab.meshing import ArcBlock, Disc, QuadBlock, Rectangle, Ring
from contactlab.meshing.mesh import nodal_measure
from contactlab.testing.mesh import CHECKS

SQUARE = ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0))

SOURCES = {
    "graded rectangle": Rectangle((0.0, 1.0, 3.0), (0.0, 2.0), ((3, 4), 2), ((0.5, 2.0), 3.0)),
    "graded arc-block": ArcBlock(1.0, 0.8, 0.6, (6, 3), (3.0, 2.0)),
    "bulging quad-block": QuadBlock(SQUARE, (4, 3), (0.2, 0.1, -0.1, 0.3), (2.0, 0.5)),
    "disc": Disc(2.0, (4, 3), 0.5),
    "ring": Ring((1.0, 2.0), (8, 2)),
    "half ring": Ring((1.0, 2.0), (8, 2), (180.0, 360.0), 2.0),
}


@pytest.mark.parametrize("source", SOURCES.values(), ids=SOURCES)
@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
def test_meshes_are_sound_with_all_their_fields(source: MeshSource, check) -> None:
    check(source)


def area(mesh: Mesh, element) -> float:
    return float(nodal_measure(mesh, element).sum())


def test_quadratic_cells_reach_the_area_of_the_circle() -> None:
    """Error of a parabola through three points of an arc: of fourth order in the angle, a factor 16 per level."""
    errors = [abs(area(Disc(1.0, (4, 2)).mesh(Q2Lagrange(), level), Q2Lagrange()) - math.pi) for level in (1, 2, 4)]
    assert errors[0] < 1e-3
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(16.0, rel=0.1)


@pytest.mark.parametrize(
    ("source", "sets"), [(Disc(2.0, (4, 2)), {"arc": 2.0}), (SOURCES["ring"], {"inner": 1.0, "outer": 2.0})]
)
def test_nodes_of_round_sides_lie_on_the_circle(source: MeshSource, sets: dict[str, float]) -> None:
    mesh = source.mesh(Q2Lagrange(), 2)
    for name, radius in sets.items():
        on = mesh.nodes[np.unique(mesh.edges[name])]
        assert np.hypot(*on.T) == pytest.approx(np.full(len(on), radius), rel=1e-14)


def test_quarters_of_a_disc_make_its_arc() -> None:
    mesh = Disc(1.0, (3, 2)).mesh(Q1(), 1)
    parts = np.concatenate([mesh.edges[name] for name in ("right", "top", "left", "bottom")])
    assert sorted(map(tuple, parts.tolist())) == sorted(map(tuple, mesh.edges["arc"].tolist()))
    assert np.all(mesh.nodes[np.unique(mesh.edges["right"]), 0] >= math.sqrt(0.5) - 1e-12)


def test_a_bulge_is_a_circular_arc_of_that_height() -> None:
    """Rise b over the chord c: radius (c^2/4 + b^2)/(2 b)."""
    mesh = QuadBlock(SQUARE, (6, 6), (0.5, 0.0, 0.0, 0.0)).mesh(Q2Lagrange(), 1)
    low = mesh.nodes[np.unique(mesh.edges["bottom"])]
    radius = (1.0 + 0.25) / 1.0
    assert low[:, 1].min() == pytest.approx(-0.5)
    assert np.hypot(low[:, 0] - 1.0, low[:, 1] - (radius - 0.5)) == pytest.approx(np.full(len(low), radius))


def test_straight_sides_give_the_bilinear_map() -> None:
    """A trapezoid: the transfinite map of straight sides is bilinear, nodes spaced evenly on every line."""
    mesh = QuadBlock(((0.0, 0.0), (4.0, 0.0), (3.0, 1.0), (1.0, 1.0)), (4, 2)).mesh(Q1(), 1)
    middle = mesh.nodes[np.abs(mesh.nodes[:, 1] - 0.5) < 1e-12]
    assert np.sort(middle[:, 0]) == pytest.approx(np.linspace(0.5, 3.5, 5))


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: QuadBlock(SQUARE[::-1], (2, 2)), "counter-clockwise"),
        (lambda: QuadBlock(SQUARE, (2, 2), (1.5, 0.0, 0.0, 0.0)), "half the length"),
        (lambda: ArcBlock(1.0, 0.8, 0.6, (5, 3), (2.0, 1.0)), "even number"),
        (lambda: ArcBlock(1e300, 0.8, 0.6, (6, 2)), r"radius: got 1e\+300, allowed: below 1e\+150"),
        (lambda: Disc(-1.0, (2, 2)), "radius > 0"),
        (lambda: Ring((2.0, 1.0), (4, 2)), "inner < outer"),
        (lambda: Ring((1.0, 2.0), (2, 2)), "at least 3"),
        (lambda: Ring((1.0, 2.0), (4, 2), (0.0, 400.0)), "at most 360"),
    ],
)
def test_fields_that_make_no_body_are_refused(make, word: str) -> None:
    with pytest.raises(ValueError, match=word):
        make()
