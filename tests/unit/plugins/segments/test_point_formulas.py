"""Contact at points by a formula: derivatives of pieces and normals against differences.

They run as plain Python here: each class of compiled ones takes seconds to compile.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest
from contactlab_segments.node_on_segment import NodeOnSegment

from contactlab.api import ContactView, Floats, GapGradients, PieceDerivatives, Pieces, PointContact, formula
from contactlab.api.surface import SurfacePositions
from contactlab.kernels.contact.search import near_segments
from contactlab.testing.surfaces import Chains, chains, curved, flat

H = 1e-6  # of central differences over surfaces of size one: their error and round-off over H are below 1e-9
AGREED = 2e-9


@pytest.fixture(autouse=True)
def in_python(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CONTACTLAB_PYTHON", "1")


class Nodes(NodeOnSegment):
    """As it is, in plain Python also where the compiled one was in use before."""


@dataclass(frozen=True)
class Seen(PointContact):
    """Nodes and what they see along their normals, and a little beside it."""

    points: ClassVar[int] = 0
    passes_patch_test: ClassVar[bool] = False
    aside: float = 0.01

    @formula
    def foot(x: Any, master: Any, p: Any) -> Any:
        """Where the line along the normal meets the master, less `aside`."""
        between = x.at - master.start
        return between.cross(x.normal) / master.edge().cross(x.normal) - p.aside


@dataclass(frozen=True)
class SeenFromGaussPoints(Seen):
    """The same from two points of each segment."""

    points: ClassVar[int] = 2


@dataclass(frozen=True)
class ClosestToGaussPoints(PointContact):
    """Closest points to three points of each segment."""

    points: ClassVar[int] = 3
    passes_patch_test: ClassVar[bool] = False

    @formula
    def foot(x: Any, master: Any) -> Any:
        """Of the segment's line."""
        edge = master.edge()
        return ((x.at - master.start) @ edge) / (edge @ edge)


ALGORITHMS = [Nodes, Seen, SeenFromGaussPoints, ClosestToGaussPoints]


def above(slave: Any, master: Any, order: int = 1) -> Chains:
    return chains(np.array(slave, float), np.array(master, float), order)


def rough(at: Chains, by: float) -> Chains:
    """The same surfaces with every node a little off: no symmetry, no plane left."""
    return at.moved(at.nodes + np.random.default_rng(7).normal(scale=by, size=at.nodes.shape))


SURFACES = {
    "curved": rough(curved(), 0.01),
    "quadratic": rough(flat(full=False, order=2), 0.003),
    # the middle node is above the vertex, the next beside it and a little deep
    "roof": above([[-0.5, 0.4], [0.02, 0.3], [0.5, 0.3]], [[-1.0, -0.5], [0.0, 0.0], [1.0, -0.5]]),
    "sunk": above([[-0.5, 0.0], [0.02, -0.04], [0.5, 0.0]], [[-1.0, 0.02], [0.0, 0.0], [0.02, 0.001], [1.0, -0.1]]),
    "valley": above([[-0.2, 0.21], [0.01, 0.1], [0.2, 0.23]], [[-1.0, 0.5], [0.0, 0.0], [1.0, 0.5]]),
    "corner": above([[-1.0, 0.31], [-0.1, 0.3], [0.4, 0.33]], [[-1.0, -0.6], [0.05, 0.02], [1.0, -0.6]]),
    "arc": above(
        [[-1.0, 0.31], [-0.1, 0.3], [0.4, 0.33]],
        [[-1.0, -0.6], [-0.06, -0.03], [0.02, -0.013], [0.1, -0.03], [1.0, -0.6]],
    ),
}


def view_of(algorithm: Any, at: Chains, nodes: Floats) -> ContactView:
    """What an algorithm sees of surfaces with nodes (N, 2), all segments near each other."""
    sides = SurfacePositions(np.ascontiguousarray(nodes[at.slave.nodes]), np.ascontiguousarray(nodes[at.master.nodes]))
    near = near_segments(sides.slave, at.slave.segments, sides.master, at.master.segments, 100.0)
    return ContactView(at.slave, at.master, sides, near, 0.5, np.zeros((algorithm.memory_size, len(at.slave.nodes))))


def pieces_of(algorithm: Any, view: ContactView) -> tuple[Pieces, int]:
    slots = algorithm.rows_per_node * len(view.slave.nodes)
    room = algorithm.capacity(view.slave, view.near)
    out = Pieces.allocate(room, algorithm.widths(view.slave, view.master), slots)
    return out, algorithm.pieces(view, out)


def summed(p: Any, count: int, matrices: tuple[Floats, ...], sizes: tuple[int, int, int], by: Any) -> list[Floats]:
    """Dense D (m, k), M (l, k) and T (k, k) of pieces, each `by` a factor (p, 1, 1)."""
    found = []
    for nodes, values, size in zip((p.slave, p.master, p.multiplier), matrices, sizes, strict=True):
        dense = np.zeros((size, sizes[2]))
        np.add.at(dense, (nodes[:count, :, None], p.multiplier[:count, None, :]), by * values[:count])
        found.append(dense)
    return found


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("name", SURFACES)
def test_derivatives_are_central_differences(name: str, algorithm: Any) -> None:
    """Of D, M, T and the normals, along a random move of all nodes."""
    at, part = SURFACES[name], algorithm()
    view = view_of(part, at, at.nodes)
    pieces, count = pieces_of(part, view)
    assert count
    k = len(pieces.normal)
    out = PieceDerivatives.allocate(64 * count, part.widths(at.slave, at.master), 20 * k + 32 * count)
    assert part.derivatives(view, pieces, count, out)
    move = np.random.default_rng(3).normal(size=at.nodes.shape)
    moved = np.concatenate([move[at.slave.nodes], move[at.master.nodes]])
    sizes, n = (len(at.slave.nodes), len(at.master.nodes), k), out.count
    step = moved[out.moved[:n] // 2, out.moved[:n] % 2][:, None, None]
    changes = summed(out, n, (out.dD, out.dM, out.dT), sizes, step)
    turns, n = np.zeros((k, 2)), out.normal_count
    step = moved[out.normal_moved[:n] // 2, out.normal_moved[:n] % 2][:, None]
    np.add.at(turns, out.normal_of[:n], step * out.dnormal[:n])
    sides = []
    for sign in (H, -H):
        there, number = pieces_of(part, view_of(part, at, at.nodes + sign * move))
        assert number == count
        sides.append([*summed(there, number, (there.D, there.M, there.T), sizes, 1.0), there.normal])
    for change, high, low in zip([*changes, turns], *sides, strict=True):
        # directions at the ends of a slave of Gauss points turn by a hundred per segment where they begin to
        expected = (high - low) / (2.0 * H)
        np.testing.assert_allclose(change, expected, atol=AGREED * max(1.0, 100.0 * np.abs(expected).max()))


def test_surfaces_have_every_kind_of_piece() -> None:
    """On a segment, a parabola, at a vertex along the line and along the mean, in a concave corner, under corners."""
    kinds = set()
    for name, at in SURFACES.items():
        view = view_of(Nodes, at, at.nodes)
        pieces, count = pieces_of(Nodes(), view)
        for p in range(count):
            point, holder = pieces.segment[p]
            held = "parabola" if pieces.ends[p, 2] else "vertex" if holder < 0 else name
            kinds.add(f"under the {name}" if point < 0 else held)
    assert kinds >= {"under the corner", "under the arc", "parabola", "vertex", "curved", "valley"}


@pytest.mark.parametrize("name", SURFACES)
def test_gradients_of_normals_are_their_derivatives_with_feet_held(name: str) -> None:
    """Normals of nodes at moved positions, held by the same segments at the same shares."""
    at, part = SURFACES[name], Nodes()
    view = view_of(part, at, at.nodes)
    pieces, count = pieces_of(part, view)
    k = len(pieces.normal)
    found = GapGradients.allocate(count, 1, 1, 6 * k)
    none = np.zeros(k, np.int32)
    assert part.gradients(view, pieces, count, none, np.zeros((k, 2)), found)
    assert found.count == 0
    move = np.random.default_rng(5).normal(size=at.nodes.shape)
    moved, n = np.concatenate([move[at.slave.nodes], move[at.master.nodes]]), found.normal_count
    turns, sides = np.zeros((k, 2)), np.zeros((2, k, 2))
    step = moved[found.normal_moved[:n] // 2, found.normal_moved[:n] % 2][:, None]
    np.add.at(turns, found.normal_of[:n], step * found.dnormal[:n])
    for sign, out in zip((H, -H), sides, strict=True):
        part.normals(view_of(part, at, at.nodes + sign * move), pieces, count, out)
    expected = (sides[0] - sides[1]) / (2.0 * H)
    np.testing.assert_allclose(turns, expected, atol=AGREED * max(1.0, np.abs(expected).max()))
