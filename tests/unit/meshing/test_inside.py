"""Which points are inside a boundary, and how deep: against brute force, and in time that grows with their number."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contactlab.api import Floats, Ints
from contactlab.meshing import inside
from contactlab.meshing.inside import depths_inside, windings


def brute_force(points: Floats, positions: Floats, edges: Ints) -> Floats:
    """Every point against every edge."""
    a, b = positions[edges[:, 0]], positions[edges[:, 1]]
    out = np.zeros(len(points))
    for i, (x, y) in enumerate(points):
        turns = 0
        for (ax, ay), (bx, by) in zip(a, b, strict=True):
            if (ay <= y) != (by <= y):
                side = (bx - ax) * (y - ay) - (by - ay) * (x - ax)
                turns += 1 if by > y and side > 0 else -1 if by <= y and side <= 0 else 0
        if turns:
            share = np.clip(((points[i] - a) * (b - a)).sum(1) / ((b - a) ** 2).sum(1), 0.0, 1.0)
            out[i] = np.hypot(*(a + share[:, None] * (b - a) - points[i]).T).min()
    return out


def ring(count: int, radius: Floats) -> tuple[Floats, Ints]:
    angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    nodes = np.arange(count)
    return radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1), np.stack([nodes, (nodes + 1) % count], 1)


@pytest.mark.full
@given(seed=st.integers(0, 10_000), count=st.integers(3, 60), flat=st.booleans())
@settings(max_examples=60, deadline=None)
@pytest.mark.parametrize("together", [inside.TOGETHER, 64])  # all pairs at once, or bins in several pieces
def test_as_brute_force_says(together: int, seed: int, count: int, flat: bool) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(inside, "TOGETHER", together)
        _as_brute_force_says(seed, count, flat)


def _as_brute_force_says(seed: int, count: int, flat: bool) -> None:
    chance = np.random.default_rng(seed)
    positions, edges = ring(count, chance.uniform(0.3, 1.0, count))
    points = chance.uniform(-1.1, 1.1, (80, 2)) * ([1.0, 0.05] if flat else [1.0, 1.0])
    assert depths_inside(points, positions, edges) == pytest.approx(brute_force(points, positions, edges), abs=1e-12)
    for around in (positions, positions[:, ::-1]):  # points spread along either axis
        sign = 1.0 if around is positions else -1.0
        turns = windings(points if sign > 0.0 else points[:, ::-1], around, edges)
        assert set(np.unique(sign * turns)) <= {0.0, 1.0}, "the boundary has its inside on its left, or right"


def test_pairs_grow_with_points_and_edges(monkeypatch: pytest.MonkeyPatch) -> None:
    looked_at: list[int] = []
    pairs = inside._pairs

    def counted(*arguments: Floats) -> object:
        for point, edge in pairs(*arguments):
            looked_at[-1] += len(point)
            yield point, edge

    monkeypatch.setattr(inside, "_pairs", counted)
    for count in (1000, 4000, 16000):
        positions, edges = ring(count, np.ones(count))
        looked_at.append(0)
        points = positions[: count // 2] * 0.99
        depth = depths_inside(points, positions, edges)
        assert depth == pytest.approx(0.01 * np.ones(count // 2), abs=1e-4)
    # 16 times as many points and edges
    assert looked_at[2] < 20 * looked_at[0]


@given(seed=st.integers(0, 10_000))
@settings(max_examples=60, deadline=None)
def test_long_edges_are_found_from_their_ends(seed: int) -> None:
    """The point in line with the longest edge, beyond the end of which it lies: round-off must not hide that edge."""
    chance = np.random.default_rng(seed)
    positions = np.array([[0.0, 0.0], [chance.uniform(1.0, 3.0), 0.0], [1.0, 2.0]]) + chance.uniform(-1.0, 1.0, 2)
    edges = np.array([[0, 1], [1, 2], [2, 0]])
    points = positions.mean(axis=0) + 1e-9 * chance.uniform(-1.0, 1.0, (5, 2))
    points = np.concatenate([points, positions + 1e-12 * (positions.mean(axis=0) - positions)])
    assert depths_inside(points, positions, edges) == pytest.approx(brute_force(points, positions, edges), abs=1e-11)


def test_one_long_edge_does_not_make_all_short_ones_candidates(monkeypatch: pytest.MonkeyPatch) -> None:
    """A block with fine edges below and long ones elsewhere, nodes just within: 4 times as many, 4 times the work."""
    looked_at: list[int] = []
    distance = inside._distance

    def counted(point: Floats, a: Floats, b: Floats) -> Floats:
        looked_at[-1] += len(a)
        return distance(point, a, b)

    monkeypatch.setattr(inside, "_distance", counted)
    for count in (1100, 4400):  # more pairs than are looked at one by one
        x = np.linspace(0.0, 1.0, count)
        positions = np.concatenate([np.stack([x, np.zeros(count)], axis=1), [[1.0, 1.0], [0.0, 1.0]]])
        nodes = np.arange(count + 2)
        points = np.stack([x[1:-1], np.full(count - 2, 1e-5)], axis=1)
        looked_at.append(0)
        depth = depths_inside(points, positions, np.stack([nodes, (nodes + 1) % (count + 2)], axis=1))
        assert depth == pytest.approx(np.minimum(1e-5, np.minimum(x, 1.0 - x)[1:-1]), rel=1e-9)
    assert looked_at[1] < 6 * looked_at[0]
