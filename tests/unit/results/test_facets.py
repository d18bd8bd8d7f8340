"""Facets of a curve are as deep as its sagitta; turns that no curve has near them are kinks of the shape."""

from __future__ import annotations

import math

import numpy as np
import pytest

from contactlab.api import Floats, Surface
from contactlab.meshing.curves import facet_depths
from contactlab.meshing.mesh import surface_from_edges
from contactlab.results.facets import kinks


def surface(points: Floats, closed: bool = False) -> Surface:
    edges = np.stack([np.arange(len(points)), np.arange(1, len(points) + 1)], axis=1)
    edges[-1, 1] = 0
    return surface_from_edges((edges if closed else edges[:-1]).astype(np.int32))


def test_facets_of_a_circle_are_as_deep_as_their_sagitta() -> None:
    count, radius = 48, 2.0
    angle = 2.0 * math.pi * np.arange(count) / count
    points = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    depths = facet_depths(surface(points, closed=True), points)
    assert depths == pytest.approx(radius * (1.0 - math.cos(math.pi / count)), rel=2e-3)
    assert not kinks(surface(points, closed=True), points).any()


@pytest.mark.parametrize("halves", [1, 2, 4])
def test_straight_parts_of_a_facet_are_one_facet(halves: int) -> None:
    """Cells of a mesh file that a level divides keep the facets of the file."""
    angle = np.linspace(0.0, 1.0, 13)
    arc = 2.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    share = np.arange(12 * halves + 1) / halves
    points = np.stack([np.interp(share, np.arange(13), arc[:, k]) for k in range(2)], axis=1)
    depths = facet_depths(surface(points), points)
    sagitta = 2.0 * (1.0 - math.cos(0.5 * (angle[1] - angle[0])))
    assert depths[halves:-halves:halves] == pytest.approx(sagitta, rel=2e-3)
    assert np.count_nonzero(depths > 1e-12) == 11


def test_the_apex_of_a_wedge_is_a_kink_and_no_facet() -> None:
    x = np.linspace(-1.0, 1.0, 21)
    points = np.stack([x, 0.05 * np.abs(x)], axis=1)
    assert facet_depths(surface(points), points).max() < 1e-12
    assert np.flatnonzero(kinks(surface(points), points)).tolist() == [10]


def test_rounded_coordinates_are_no_kinks() -> None:
    x = np.linspace(-1.0, 1.0, 21)
    points = np.stack([x, np.round(0.05 * np.sin(7.0 * x) * 1e-3, 5)], axis=1)
    assert not kinks(surface(points), points).any()
