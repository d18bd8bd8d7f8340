"""Parts of edge sets, several sides of a contact, and corners of a slave."""

from __future__ import annotations

import numpy as np
import pytest

from contactlab.errors import SceneError
from contactlab.meshing.mesh import split_at_corners, surface_from_edges


def test_a_part_of_an_edge_set_is_usable_everywhere(make) -> None:
    sets = {"left_half": {"of": "top", "x": [0.0, 1.0]}, "corner": {"of": "left_half", "x": [0.0, 0.5]}}
    model = make(
        {"bodies.upper.sets": sets, "contacts.0.slave": "upper.bottom"},
        loads=[{"on": "upper.left_half", "pressure": 1.0}],
        supports=[{"on": "lower.bottom", "ux": 0.0, "uy": 0.0}, {"on": "upper.corner", "ux": 0.0}],
    )
    assert {name: len(edges) for name, edges in model.bodies[0].mesh.edges.items()}["left_half"] == 2
    out = np.zeros_like(model.reference)
    model.external_force(0.0, out)
    assert out[:, 1].sum() == pytest.approx(-1.0)
    held = next(support.nodes for support in model.loading.supports if support.on == "upper.corner")
    assert sorted(model.reference[held, 0]) == [0.0, 0.5]


@pytest.mark.parametrize(
    ("part", "words"),
    [
        ({"of": "top", "x": [0.0, 0.7]}, ("cuts an edge", "0.5 and 1", "bodies.upper.sets.some.x")),
        ({"of": "top", "y": [5.0, 6.0]}, ("no edge lies", "y = 1 to 1")),
        ({"of": "tpo"}, ("no such edge set", '"top"')),
        ({"of": "top", "x": [1.0, 0.0]}, ("not allowed", "increasing")),
    ],
)
def test_parts_that_are_none_say_why(make, part: dict, words: tuple[str, ...]) -> None:
    with pytest.raises(SceneError) as caught:
        make({"bodies.upper.sets": {"some": part}})
    for word in words:
        assert word in str(caught.value)


def test_bounds_near_a_node_go_through_it_and_nodes_are_told_to_be_typed(make) -> None:
    """Nodes of a mesh file have coordinates of many digits: those of the message must be accepted."""
    wide = {"bodies.upper.mesh.x": [1000.1234567, 1002.1234567], "contacts": [], "supports": []}
    changes = {**wide, "bodies.upper.sets": {"some": {"of": "top", "x": [1000.0, 1000.7]}}}
    with pytest.raises(SceneError, match="within 1/1000 of an edge") as caught:
        make(changes)
    near = float(str(caught.value).split("nearest are at ")[1].split(" and ")[0])
    found = make({**changes, "bodies.upper.sets": {"some": {"of": "top", "x": [1000.0, near]}}})
    assert len(found.bodies[0].mesh.edges["some"]) == 1


def test_a_part_cannot_take_the_name_of_an_edge_set(make) -> None:
    with pytest.raises(SceneError, match="edge set of this name"):
        make({"bodies.upper.sets": {"bottom": {"of": "top"}}})


def body(x: list[float], y: list[float], cells: list[int]) -> dict:
    return {"element": "q1", "material": "m", "mesh": {"use": "rectangle", "x": x, "y": y, "cells": cells}}


TWO_BASES = {
    "left": body([-1.0, 1.1], [-1.0, 0.0], [5, 2]),
    "right": body([1.1, 3.0], [-1.0, 0.0], [4, 2]),
    "upper": body([0.0, 2.0], [0.0, 1.0], [4, 2]),
}


def test_two_masters_make_one_surface_without_a_seam(make) -> None:
    """Every slave node has full cover, and rows reproduce constants across the joint."""
    contact = {"slave": "upper.bottom", "master": ["left.top", "right.top"], "algorithm": "mortar-p1"}
    supports = [{"on": f"{name}.bottom", "ux": 0.0, "uy": 0.0} for name in ("left", "right")]
    model = make(bodies=TWO_BASES, contacts=[contact], supports=supports)
    pair = model.contact.pairs[0]
    assert len(pair.master.nodes) == 6 + 5
    assert pair.cover == pytest.approx(pair.coupling.full)
    start, end, weight = pair.weights().master
    sums = [weight[k, : end[k] - start[k]].sum() for k in range(pair.slots)]
    assert sums == pytest.approx(np.ones(5))


def test_edge_sets_of_different_order_do_not_mix(make) -> None:
    contact = {"slave": "upper.bottom", "master": ["left.top", "right.top"], "algorithm": "mortar-p1"}
    with pytest.raises(SceneError, match="different numbers of nodes") as caught:
        make({"bodies.right.element": "q2"}, bodies=TWO_BASES, contacts=[contact], supports=[])
    assert "left.top: 2, right.top: 3" in str(caught.value)


def around(edges: list[list[int]]) -> np.ndarray:
    return np.array(edges, np.int32)


SQUARE = np.array([[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [1.0, 0.5], [1.0, 1.0]])


def test_a_slave_is_cut_at_a_right_angle() -> None:
    """Two edges along x, two along y: five nodes become six, the corner once for each flank."""
    surface = surface_from_edges(around([[2, 3], [0, 1], [3, 4], [1, 2]]))
    cut = split_at_corners(surface, SQUARE)
    assert cut.nodes.tolist() == [0, 1, 2, 2, 3, 4]
    assert cut.segments.tolist() == [[0, 1], [1, 2], [3, 4], [4, 5]]
    assert cut.node_segments.tolist() == [[-1, 0], [0, 1], [1, -1], [-1, 2], [2, 3], [3, -1]]
    assert cut.edges.tolist() == cut.segments.tolist()


def test_quadratic_edges_are_cut_between_edges_only() -> None:
    """One edge along x and one along y, each with a middle node."""
    cut = split_at_corners(surface_from_edges(around([[0, 2, 1], [2, 4, 3]])), SQUARE)
    assert cut.nodes.tolist() == [0, 1, 2, 2, 3, 4]
    assert cut.edges.tolist() == [[0, 2, 1], [3, 5, 4]]


def test_a_closed_slave_with_corners_becomes_its_sides() -> None:
    ring = around([[0, 1], [1, 2], [2, 3], [3, 0]])
    cut = split_at_corners(surface_from_edges(ring), np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]))
    assert len(cut.nodes) == 8
    assert np.sum(cut.node_segments == -1) == 8
    assert sorted(cut.nodes.tolist()) == [0, 0, 1, 1, 2, 2, 3, 3]


@pytest.mark.parametrize(
    ("turn", "least", "nodes"), [(17.0, None, 3), (18.0, None, 4), (59.0, 60.0, 3), (61.0, 60.0, 4)]
)
def test_gentle_turns_stay_whole(turn: float, least: float | None, nodes: int) -> None:
    angle = np.radians(turn)
    x = np.array([[0.0, 0.0], [1.0, 0.0], [1.0 + np.cos(angle), np.sin(angle)]])
    assert len(split_at_corners(surface_from_edges(around([[0, 1], [1, 2]])), x, least).nodes) == nodes


@pytest.mark.parametrize(("facets", "nodes"), [(7, 7), (5, 10)])
def test_facets_of_a_curve_are_no_corners(facets: int, nodes: int) -> None:
    """A circle of 7 facets turns by 51 degrees at each node, one of 5 by 72, which are corners of any shape."""
    angle = 2.0 * np.pi * np.arange(facets) / facets
    ring = around([[i, (i + 1) % facets] for i in range(facets)])
    x = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    assert len(split_at_corners(surface_from_edges(ring), x).nodes) == nodes
