"""State tracks and profiles of the timeline on slave surfaces of several chains."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
from contactlab_rerun.gathered import Surface
from contactlab_rerun.notes import track_names, watched_nodes

CONTACT = SimpleNamespace(slave_nodes=np.arange(7, 17))


def surface(s: list[float], chain: list[int]) -> Surface:
    field, state = np.zeros((1, len(s))), np.ones((1, len(s)), np.int32)
    return Surface(np.array(s), np.array(chain, np.int32), field, field, field, field, field, state)


def test_both_nodes_of_a_corner_have_a_track() -> None:
    corner = surface([0.0, 10.0, 10.0, 20.0], [0, 0, 1, 1])
    nodes = watched_nodes(corner, 9)
    assert nodes == [0, 1, 2, 3]
    assert track_names(corner, CONTACT, nodes) == [
        "s_0.0_node_7_chain_0",
        "s_10.0_node_8_chain_0",
        "s_10.0_node_9_chain_1",
        "s_20.0_node_10_chain_1",
    ]


def test_lanes_of_one_chain_are_named_by_arc_length_and_node() -> None:
    plain = surface([0.0, 0.5, 1.6], [0, 0, 0])
    names = track_names(plain, CONTACT, watched_nodes(plain, 9))
    assert names == ["s_0.00_node_7", "s_0.50_node_8", "s_1.60_node_9"]


def test_nodes_close_to_each_other_have_names_of_their_own() -> None:
    fine = surface([0.0, 0.0001, 0.0002, 100.0], [0, 0, 0, 0])
    names = track_names(fine, CONTACT, watched_nodes(fine, 9))
    assert [name.partition("_node")[0] for name in names] == ["s_0.0000", "s_0.0001", "s_0.0002", "s_100.0000"]


def test_nodes_are_watched_and_drawn_along_the_chains() -> None:
    """Whatever their order in the surface: chain by chain, each from its beginning."""
    shuffled = surface([10.0, 15.0, 0.0, 10.0], [1, 1, 0, 0])
    assert shuffled.along.tolist() == [2, 3, 0, 1] == watched_nodes(shuffled, 9)
