"""Contact forces of the forward-increment multipliers on single nodes, where everything is known exactly."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from contactlab_dynamics.central_difference import CentralDifference
from contactlab_dynamics.forward_increment import ForwardIncrement
from contactlab_dynamics.gauss_seidel import solve_dense, solve_sparse
from contactlab_segments.node_on_segment import NodeOnSegment

from contactlab.api import Floats, Rows, Solve
from contactlab.testing.gap_rows import coupled_normals, direct_forces, operator, rows_from, turned
from contactlab.testing.oscillator import Oscillator
from contactlab.testing.surfaces import chains, conditions, dense

DT = 0.01


class Walls:
    """Gap conditions G x + offset >= 0 that never turn, with Coulomb friction if mu is given."""

    def __init__(self, normal: Floats, offset: Floats, mu: float | None = None) -> None:
        self.normal, self.offset, self.mu = np.asarray(normal, float), np.asarray(offset, float), mu
        self.tangent = turned(self.normal) if mu is not None else None
        self.y = np.zeros((1 if mu is None else 2, len(self.offset)))
        self.enforcement = ForwardIncrement(tolerance=1e-13)
        self.slip = np.zeros(len(self.offset))

    def gap(self, position: Floats) -> Floats:
        return np.asarray((self.normal * position).sum(axis=(1, 2)) + self.offset)

    def rows(self, predicted: Floats, current: Floats) -> Rows:
        if self.tangent is None:
            return rows_from(self.normal, self.gap(predicted))
        slip = (self.tangent * (predicted - current)).sum(axis=(1, 2))
        return rows_from(self.normal, self.gap(predicted), tangent=self.tangent, slip=slip, coefficient=self.mu or 0.0)

    def solve(self, predicted: Floats, current: Floats, compliance: Floats, force: Floats) -> Solve:
        done = self.enforcement.solve(self.rows(predicted, current), compliance, self.y, force)
        if self.tangent is not None:
            self.slip = (self.tangent * (predicted - current + compliance * force)).sum(axis=(1, 2))
        return done

    def friction_work(self, mean_velocity: Floats, dt: float, compliance: Floats, force: Floats) -> tuple[float, float]:
        return 0.0, 0.0


def particles(walls: Walls, mass: Floats, velocity: Floats, stiffness: Floats | None = None) -> Oscillator:
    """Nodes at (0, 0), (1, 0) ... behind walls, on springs if stiffness is given."""
    springs = np.zeros(len(mass)) if stiffness is None else stiffness
    start, anywhere = np.asarray(velocity, float), np.zeros(len(mass))
    model = Oscillator(CentralDifference(), mass, springs, velocity=start, clearance=anywhere)
    model.contact = walls  # in place of the floor
    model.bind()
    return model


def test_a_node_stops_at_a_wall() -> None:
    """the force removes the penetration in one step, m depth/dt^2, and the node rests after the next."""
    mass, height, speed = 3.0, 0.0523, 2.0
    walls = Walls([[[0.0, 1.0]]], [height])
    model = particles(walls, np.array([mass]), [[0.0, -speed]])
    before = int(height / (speed * DT))
    for _ in range(before):
        model.advance(DT)
        assert walls.y[0, 0] == 0.0
    left = height - before * speed * DT
    depth = speed * DT - left
    model.advance(DT)
    assert walls.y[0, 0] == pytest.approx(mass * depth / DT**2, rel=1e-9)
    assert walls.gap(model.position)[0] == pytest.approx(0.0, abs=1e-15)
    model.advance(DT)
    assert model.state["velocity"][0, 1] == pytest.approx(0.0, abs=1e-13)
    for _ in range(5):
        model.advance(DT)
    assert walls.y[0, 0] == pytest.approx(0.0, abs=1e-9)  # no force once it rests
    assert walls.gap(model.position)[0] == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("phase", [0.0, 0.3, 0.5, 0.9])
def test_the_impulse_is_the_momentum(phase: float) -> None:
    """Two active steps share the momentum m v by the phase of arrival, whatever it is."""
    mass, speed = 2.0, 5.0
    walls = Walls([[[0.0, 1.0]]], [(3.0 - phase) * speed * DT])
    model = particles(walls, np.array([mass]), [[0.0, -speed]])
    forces = []
    for _ in range(8):
        model.advance(DT)
        forces.append(walls.y[0, 0])
    assert sum(forces) * DT == pytest.approx(mass * speed, rel=1e-9)
    assert forces[2] * DT == pytest.approx(phase * mass * speed, rel=1e-9, abs=1e-9)
    assert forces[3] * DT == pytest.approx((1.0 - phase) * mass * speed, rel=1e-9)


def test_two_equal_nodes_stop_each_other() -> None:
    """head-on with v and -v both stop; momentum is exact."""
    walls = Walls([[[-1.0, 0.0], [1.0, 0.0]]], [-0.5])
    model = particles(walls, np.array([2.0, 2.0]), [[3.0, 0.0], [-3.0, 0.0]])
    for _ in range(30):
        model.advance(DT)
        np.testing.assert_allclose(model.mass @ model.state["velocity"], 0.0, atol=1e-13)
    np.testing.assert_allclose(model.state["velocity"], 0.0, atol=1e-12)
    assert walls.gap(model.position)[0] == pytest.approx(0.0, abs=1e-14)


def test_unequal_nodes_share_their_momentum() -> None:
    walls = Walls([[[-1.0, 0.0], [1.0, 0.0]]], [-0.5])
    model = particles(walls, np.array([3.0, 1.0]), [[2.0, 0.0], [0.0, 0.0]])
    for _ in range(60):
        model.advance(DT)
    np.testing.assert_allclose(model.state["velocity"][:, 0], 1.5, rtol=1e-12)


def test_a_node_in_a_notch_meets_both_walls() -> None:
    """two rows on one node, walls at right angles: both gaps are closed, neither pulls."""
    slope = np.sqrt(0.5)
    walls = Walls([[[slope, slope]], [[-slope, slope]]], [0.1, 0.1])
    model = particles(walls, np.array([1.0]), [[0.7, -4.0]])
    for _ in range(30):
        model.advance(DT)
        assert np.all(walls.y >= 0.0)
    np.testing.assert_allclose(walls.gap(model.position), 0.0, atol=1e-13)
    np.testing.assert_allclose(model.state["velocity"], 0.0, atol=1e-11)


def test_node_on_segment_sees_both_walls_of_a_notch() -> None:
    """The same from geometry: at a sharp concave corner of the master a node carries two conditions."""
    notch = np.array([[-1.0, 1.0], [0.0, 0.0], [1.0, 1.0]])
    tip = np.array([[-0.4, 0.8], [0.02, 0.1], [0.4, 0.8]])
    at = chains(tip, notch)
    found = conditions(NodeOnSegment(), at)
    at_tip = np.flatnonzero(found.owner % 3 == 1)
    assert len(at_tip) == 2
    normal = dense(found, found.normal_weight, len(at.nodes))[at_tip, 1]
    np.testing.assert_allclose(np.sort(normal[:, 0]), [-np.sqrt(0.5), np.sqrt(0.5)], atol=1e-12)
    gap = np.array([0.1 + 0.02, 0.1 - 0.02]) * np.sqrt(0.5)
    np.testing.assert_allclose(np.sort(found.gap[at_tip]), np.sort(gap), atol=1e-12)
    rows = rows_from(dense(found, found.normal_weight, len(at.nodes))[at_tip], found.gap[at_tip] - 0.2)
    y, force, free = np.zeros((1, 2)), np.zeros((len(at.nodes), 2)), np.zeros((len(at.nodes), 2))
    free[1] = 1.0  # only the tip moves
    ForwardIncrement().solve(rows, free, y, force)
    moved = at.nodes + free * force
    left = dense(found, found.normal_weight, len(at.nodes))[at_tip]
    np.testing.assert_allclose((left * moved).sum(axis=(1, 2)) - 0.2, 0.0, atol=1e-10)


def swept(
    solve: Callable[..., Any], rows: Rows, compliance: Floats, y: Floats, tolerance: float = 1e-12
) -> tuple[Floats, Any]:
    """Forces on the nodes, and how the sweeps went; y is the warm start and becomes the multipliers."""
    force = np.zeros_like(compliance)
    return force, solve(rows.count, rows, compliance, y, force, tolerance, 500)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("mu", [None, 0.3])
def test_both_ways_of_sweeping_make_the_same_updates(seed: int, mu: float | None) -> None:
    """sweep by sweep the same, with and without friction, from a warm start, one row without compliance."""
    count = 40
    normal = coupled_normals(count, seed)
    rng = np.random.default_rng(seed)
    compliance = rng.uniform(0.3, 3.0, (count + 3, 2))
    compliance[np.any(normal[7] != 0.0, axis=1)] = 0.0
    gap, slip = rng.uniform(-1.0, 1.0, count), rng.uniform(-0.2, 0.2, count)
    tangent = {} if mu is None else {"tangent": turned(normal), "slip": slip, "coefficient": mu}
    rows = rows_from(normal, gap, **tangent)
    start = rng.uniform(0.0, 0.5, (1 if mu is None else 2, count))
    dense_y, sparse_y = start.copy(), start.copy()
    force, dense_solve = swept(solve_dense, rows, compliance, dense_y)
    other, sparse_solve = swept(solve_sparse, rows, compliance, sparse_y)
    assert dense_solve[0] == sparse_solve[0] > 5
    assert dense_solve[2] == sparse_solve[2] == 1
    # sums of some forty terms in another order
    np.testing.assert_allclose(dense_y, sparse_y, atol=1e-12 * sparse_y.max())
    np.testing.assert_allclose(force, other, atol=1e-12 * np.abs(other).max())
    assert dense_solve[3] == pytest.approx(sparse_solve[3], rel=1e-12)


@pytest.mark.parametrize("solve", [solve_dense, solve_sparse])
@pytest.mark.parametrize("seed", range(6))
def test_sweeps_find_the_direct_solution(seed: int, solve: Callable[..., Any]) -> None:
    """50 coupled rows with gaps of either sign, against the active sets of Lawson & Hanson."""
    count = 50
    normal = coupled_normals(count, seed)
    rng = np.random.default_rng(seed)
    compliance = rng.uniform(0.3, 3.0, (count + 3, 2))
    gap = rng.uniform(-1.0, 1.0, count)
    rows = rows_from(normal, gap)
    y = np.zeros((1, count))
    _, (sweeps, residual, rigid, _) = swept(solve, rows, compliance, y)
    expected = direct_forces(operator(normal, compliance), gap)
    assert 5 < np.count_nonzero(expected) < count  # a mixed active set
    np.testing.assert_allclose(y[0], expected, atol=1e-9 * expected.max())
    assert sweeps < 200
    assert residual <= 1e-12
    assert rigid == 0


# --- energy -------------------------------------------------------------------------------------


def discrete_energy(model: Oscillator, before: Floats) -> float:
    """H = 1/2 v M v + 1/2 u_n K u_{n+1}, `before` is u_n."""
    stored = 0.5 * (model.springs[:, None] * before * model.state["displacement"]).sum()
    return model.kinetic_energy() + float(stored)


@pytest.mark.parametrize("mu", [None, 0.4])
def test_energy_changes_by_exactly_the_work_at_the_gap(mu: float | None) -> None:
    """H_{n+1/2} - H_{n-1/2} = 1/2 y_n (g_{n+1} - g_{n-1}) + 1/2 y_t (d_{n+1} + d_n); without friction never a rise."""
    rng = np.random.default_rng(3)
    count = 12
    normal = coupled_normals(count, 9)
    reference = np.stack([np.arange(count + 3.0), np.zeros(count + 3)], axis=1)
    offset = rng.uniform(0.05, 0.5, count) - (normal * reference).sum(axis=(1, 2))
    walls = Walls(normal, offset, mu)
    model = particles(
        walls, rng.uniform(0.5, 2.0, count + 3), rng.normal(size=(count + 3, 2)), rng.uniform(1.0, 30.0, count + 3)
    )
    dt = 0.2 * model.stable_step()
    gaps = [walls.gap(model.position)] * 2
    before, slip = model.state["displacement"].copy(), walls.slip
    model.advance(dt)
    energies, touched = [discrete_energy(model, before)], 0
    gaps = [gaps[0], walls.gap(model.position)]
    for _ in range(400):
        slip, before = walls.slip, model.state["displacement"].copy()
        model.advance(dt)
        gaps = [*gaps[-2:], walls.gap(model.position)]
        energies.append(discrete_energy(model, before))
        work = 0.5 * walls.y[0] @ (gaps[-1] - gaps[-3])
        if mu is not None:
            work += 0.5 * walls.y[1] @ (walls.slip + slip)
        touched += int(np.count_nonzero(walls.y[0]))
        # round-off of energies of order ten, and what the sweeps leave of y g
        assert energies[-1] - energies[-2] == pytest.approx(work, abs=1e-10)
    assert touched > 50
    if mu is None:
        assert max(np.diff(energies)) < 1e-10
    assert energies[-1] < 0.95 * energies[0]
