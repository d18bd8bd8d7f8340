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


def test_nodes_are_watched_and_drawn_along_the_chains() -> None:
    """Whatever their order in the surface: chain by chain, each from its beginning."""
    shuffled = surface([10.0, 15.0, 0.0, 10.0], [1, 1, 0, 0])
    assert shuffled.along.tolist() == [2, 3, 0, 1] == watched_nodes(shuffled, 9)
