"""Requests that only the mesh shows to be wrong."""

from __future__ import annotations

import pytest

from contactlab.errors import SceneError
from contactlab.meshing.inside import depths_inside


def refused(make, changes: dict, *words: str, **tables) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(SceneError) as caught:
        make(changes, **tables)
    for word in words:
        assert word in str(caught.value)


def test_surfaces_that_turn_their_backs_are_refused(make) -> None:
    refused(make, {"contacts.0.slave": "upper.top"}, "face away from each other", "upper.top", "contacts.0")


def test_surfaces_that_look_away_from_each_other_are_refused(make) -> None:
    refused(make, {"contacts.0.slave": "upper.top", "contacts.0.master": "lower.bottom"}, "face away", "2 mm")


def test_bodies_far_apart_and_side_by_side_are_accepted(make) -> None:
    assert make({"bodies.upper.shift": [40.0, 60.0]}).contact is not None


def test_a_body_inside_another_is_refused_where_no_condition_sees_it(make) -> None:
    """The upper block stands with its corner in the lower one; only a side of it is declared as slave."""
    refused(
        make,
        {"bodies.upper.shift": [1.7, -0.3], "contacts.0.slave": "upper.left", "contacts.0.master": "lower.right"},
        "overlap", "0.3 mm",
    )  # fmt: skip


def test_a_held_slave_is_refused(make) -> None:
    supports = [{"on": "upper", "ux": 0.0, "uy": 0.0}]
    refused(make, {}, "held by supports", "swap = true", supports=supports)


NEWTON = {"integrator": "newton"}


def test_statics_asks_for_supports(make) -> None:
    refused(make, NEWTON, "no support holds this body", "bodies.upper", "lower alone touches it")
    refused(
        make, NEWTON, "free to move", "free for sliding along x", contacts=[],
        supports=[{"on": "lower.bottom", "ux": 0.0, "uy": 0.0}, {"on": "upper.bottom", "uy": 0.0}],
    )  # fmt: skip


def test_statics_takes_a_body_that_a_load_presses_on_another(make) -> None:
    loads = [{"on": "upper.top", "pressure": 1.0}]
    assert make({**NEWTON, "time.end": 1.0}, loads=loads).contact is not None


def test_auto_asks_for_something_that_pushes_back(make) -> None:
    refused(make, {"time.end": "auto"}, "no support holds this body", "lower alone touches it")


def test_dynamics_lets_bodies_fly(make) -> None:
    assert make(contacts=[], supports=[]).contact is None


def test_depth_inside_a_polygon_is_the_distance_to_its_boundary() -> None:
    import numpy as np

    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    edges = np.array([[0, 1], [1, 2], [2, 3], [3, 0]], np.int32)
    points = np.array([[1.0, 2.0], [2.0, 3.5], [5.0, 2.0], [-1.0, 0.0], [2.0, 2.0]])
    assert depths_inside(points, square, edges) == pytest.approx([1.0, 0.5, 0.0, 0.0, 2.0])


def test_a_mesh_file_that_cannot_be_meshed_names_the_key(make, tmp_path) -> None:
    (tmp_path / "x.msh").write_text("no mesh")
    mesh = {"use": "file", "path": str(tmp_path / "x.msh")}
    refused(make, {"bodies.upper.mesh": mesh}, "no mesh can be made", "bodies.upper.mesh", "cannot read")


def test_two_supports_that_disagree_are_refused(make) -> None:
    supports = [
        {"on": "lower.bottom", "ux": 0.0, "uy": 0.0},
        {"on": "lower.left", "uy": {"ramp": "linear", "to": 0.0}},
        {"on": "lower.right", "uy": {"ramp": "linear", "to": 0.1}},
    ]
    refused(make, {}, "two different displacements", "0.1 (linear) after 0", supports=supports)
    refused(
        make, {}, "a rotation after 0",
        supports=[supports[0], {"on": "lower.left", "turn": {"to": 1.0}}],
    )  # fmt: skip
