"""Which segment or vertex holds a node, against the nearest point of the whole master."""

from __future__ import annotations

import numpy as np
import pytest
from contactlab_segments.node_on_segment import NodeOnSegment

from contactlab.api import ContactView, Floats, Pieces
from contactlab.api.surface import SurfacePositions
from contactlab.kernels.contact.search import near_segments
from contactlab.testing.surfaces import Chains, chains

ROUND_OFF = 1e-13


def paired(at: Chains, reach: float = 10.0, memory: Floats | None = None) -> tuple[Pieces, int, ContactView]:
    """Pieces of surfaces with all segments near each other."""
    sides = SurfacePositions(at.nodes[at.slave.nodes], at.nodes[at.master.nodes])
    near = near_segments(sides.slave, at.slave.segments, sides.master, at.master.segments, 100.0)
    kept = np.zeros((2, len(at.slave.nodes))) if memory is None else memory
    view, algorithm = ContactView(at.slave, at.master, sides, near, reach, kept), NodeOnSegment()
    out = Pieces.allocate(2 * len(at.slave.nodes), algorithm.widths(at.slave, at.master), 2 * len(at.slave.nodes))
    return out, algorithm.pieces(view, out), view


def above(points: Floats, master: Floats) -> Chains:
    """A slave through points over a master, both left to right."""
    return chains(np.array(points, float), np.array(master, float))


def nearest_points(view: ContactView) -> tuple[Floats, Floats]:
    """Nearest point (m, 2) of the whole master to each slave node and its distance, by 20001 points per segment."""
    share = np.linspace(0.0, 1.0, 20001)[:, None]
    points = np.concatenate(
        [(1 - share) * view.at.master[i] + share * view.at.master[j] for i, j in view.master.segments]
    )
    distance = np.hypot(*(view.at.slave[:, None] - points[None]).transpose(2, 0, 1))
    return points[distance.argmin(axis=1)], distance.min(axis=1)


def test_pair_nodes_holds_each_node_at_the_nearest_point_of_the_master() -> None:
    """Of a smooth master that reaches beyond the slave: gaps and feet to the square of the spacing of the points."""
    x = np.linspace(-0.8, 0.8, 9)
    below = np.linspace(-1.1, 1.1, 8)
    at = above(np.stack([x, 0.05 + 0.1 * x**2], axis=1), np.stack([below, 0.02 * below**3], axis=1))
    pieces, count, view = paired(at)
    assert count == len(x)
    np.testing.assert_array_equal(pieces.slave[:count, 0], np.arange(len(x)))
    feet = np.einsum("pi,pid->pd", pieces.M[:count, :, 0] / pieces.T[:count, 0], view.at.master[pieces.master[:count]])
    points, distance = nearest_points(view)
    np.testing.assert_allclose(feet, points, atol=2e-5)
    normal = pieces.normal[pieces.multiplier[:count, 0]]
    np.testing.assert_allclose(((view.at.slave - feet) * normal).sum(axis=1), distance, atol=1e-8)


def test_pair_nodes_finds_the_closest_point_of_a_parabola() -> None:
    """The line to the node is along the normal there, and no other of 20001 points of the edge is nearer."""
    at = chains(np.array([[-0.3, 0.4], [0.1, 0.35], [0.4, 0.5]]), np.array([[-1.0, 0.0], [0.1, 0.2], [1.0, 0.1]]), 2)
    pieces, count, view = paired(at)
    assert count == 3
    edge = view.at.master[pieces.master[:3]]
    weight = pieces.M[:3, :, 0] / pieces.T[:3, 0]
    s = np.linspace(-1.0, 1.0, 20001)[:, None, None]
    points = 0.5 * s * (s - 1.0) * edge[:, 0] + 0.5 * s * (s + 1.0) * edge[:, 1] + (1.0 - s**2) * edge[:, 2]
    between = view.at.slave - np.einsum("pi,pid->pd", weight, edge)
    nearest = np.hypot(*(view.at.slave - points).transpose(2, 0, 1)).min(axis=0)
    np.testing.assert_allclose(np.hypot(*between.T), nearest, atol=1e-7)
    normal = pieces.normal[:3]
    np.testing.assert_allclose(between[:, 0] * normal[:, 1] - between[:, 1] * normal[:, 0], 0.0, atol=1e-13)


def test_pair_nodes_takes_the_line_between_convex_vertices_and_both_sides_of_a_concave_one() -> None:
    roof = [[-1.0, -0.5], [0.0, 0.0], [1.0, -0.5]]
    pieces, count, _ = paired(above([[-0.3, 0.6], [0.02, 0.3], [0.3, 0.6]], roof), reach=0.35)
    assert count == 1
    assert pieces.multiplier[0, 0] == 1
    np.testing.assert_allclose(pieces.normal[1], np.array([0.02, 0.3]) / np.hypot(0.02, 0.3), atol=ROUND_OFF)
    assert pieces.M[0].max() == pieces.M[0].sum() == pieces.T[0].item()
    valley = [[-1.0, 0.5], [0.0, 0.0], [1.0, 0.5]]
    pieces, count, _ = paired(above([[-0.01, 0.1], [0.0, 0.1], [0.01, 0.1]], valley))
    assert count == 6
    normals = {tuple(np.round(pieces.normal[k], 12)) for k in pieces.multiplier[:count, 0]}
    size = np.hypot(1.0, 0.5)
    assert normals == {tuple(np.round(np.array([side, 1.0]) / [2 * size, size], 12)) for side in (1.0, -1.0)}


def test_pair_nodes_keeps_corners_of_the_master_outside_the_slaves_segments() -> None:
    """Along the segment's normal, where it is: at 0.2 of the segment, by a distance of 0.3 cos(0.1)."""
    turned = np.array([[np.cos(0.1), np.sin(0.1)], [-np.sin(0.1), np.cos(0.1)]])
    slave = (np.array([[-1.0, 0.3], [-0.1, 0.3], [0.4, 0.3]]) - [0.0, 0.3]) @ turned + [0.0, 0.3]
    corner = 0.3 * np.cos(0.1) * np.array([np.sin(0.1), -np.cos(0.1)]) + [0.0, 0.3]
    pieces, count, view = paired(above(slave, np.add(corner, [[-1.0, -0.6], [0.0, 0.0], [1.0, -0.6]])), reach=0.4)
    assert count == 1
    np.testing.assert_array_equal(np.sort(pieces.slave[0]), [1, 2])
    normal = pieces.normal[pieces.multiplier[0, 0]]
    np.testing.assert_allclose(normal, np.array([-np.sin(0.1), np.cos(0.1)]), atol=ROUND_OFF)
    weight = pieces.D[0, :, 0] / pieces.T[0, 0, 0]
    np.testing.assert_allclose(weight[np.argsort(pieces.slave[0])], [0.8, 0.2], atol=1e-12)
    foot = weight @ view.at.slave[pieces.slave[0]]
    np.testing.assert_allclose((foot - corner) @ normal, 0.3 * np.cos(0.1), atol=ROUND_OFF)
    np.testing.assert_allclose(pieces.M[0, :, 0] / pieces.T[0, 0, 0] @ view.at.master[pieces.master[0]], corner)


@pytest.mark.parametrize(
    ("points", "held"),
    [
        ([[-1.4, 0.1], [-1.1, 0.1]], 0),  # beyond the end
        ([[0.3, 0.9], [0.5, 0.9]], 0),  # far
        ([[0.3, -1.2], [0.5, -1.2]], 0),  # deep
        ([[0.3, 0.1], [0.5, -0.1]], 2),  # near
        ([[-1.1, 0.1], [-0.5, 0.1]], 2),  # the end is below the segment
        ([[-1.01, 0.1], [-0.2, 0.1]], 2),  # beyond the end by a hundredth of either segment
        ([[-1.01, 0.1], [-0.91, 0.1]], 2),  # the corner holds with a segment that it faces
        ([[-1.11, 0.1], [-1.01, 0.1]], 0),  # beyond the end by a tenth of its own segment
    ],
)
def test_pair_nodes_holds_none_that_is_far_or_deep_or_beyond_an_end(points: list[list[float]], held: int) -> None:
    ground = [[-1.0, 0.0], [0.0, 0.0], [1.0, 0.0]]
    assert paired(above(points, ground), reach=0.5)[1] == held


def test_pair_nodes_stays_with_its_segment_until_another_is_nearer_by_two_hundredths() -> None:
    """Both flanks of a valley of 90 degrees are as far from a node above its vertex: the remembered one stays."""
    valley = [[-1.0, 0.09], [0.0, 0.0], [1.0, 0.09]]  # less than ten degrees: one segment holds
    for last in (1.0, 2.0):
        memory = np.array([[last] * 3, [0.0] * 3])
        pieces, count, view = paired(above([[-0.2, 0.2], [0.0, 0.2], [0.2, 0.2]], valley), memory=memory)
        held = pieces.master[list(pieces.slave[:count, 0]).index(1)]
        np.testing.assert_array_equal(np.sort(held), np.sort(view.master.segments[int(last) - 1]))
        assert memory[0, 1] == last
