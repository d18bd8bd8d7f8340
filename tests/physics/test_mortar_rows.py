"""Rows of mortar contact: what T^-1 makes of the coefficients (docs/theory/rows.md)."""

from __future__ import annotations

import numpy as np
import pytest
from contactlab_mortar.mortar import MortarP0, MortarP1

from contactlab.api import ContactAlgorithm, Floats
from contactlab.contact.operator_pair import OperatorPair
from contactlab.testing.surfaces import Chains, chains, conditions, curved, dense, flat, pair_of, stations

P0, P1 = MortarP0(), MortarP1()
BOTH = pytest.mark.parametrize("algorithm", [P0, P1], ids=["P0", "P1"])
ROUND_OFF = 1e-12  # rows go through T^-1, whose condition number is below four


def line(slave: Floats, master: Floats) -> Chains:
    return chains(*(np.stack([x, np.zeros_like(x)], axis=1) for x in (slave, master)))


def weights(algorithm: ContactAlgorithm, at: Chains) -> Floats:
    """Scalar weights (k, N) of flat conditions: positive on the slave, negative on the master."""
    found = conditions(algorithm, at)
    return dense(found, found.normal_weight, len(at.nodes))[..., 1]


RANDOM = [
    line(stations(0.0, 3.0, 9, seed=s), stations(-0.1 * s, 3.0 + 0.1 * s, 4 + 3 * s, seed=s + 20)) for s in range(5)
]
PARTIAL = [
    line(stations(0.0, 3.0, 9, seed=1), stations(0.71, 2.13, 6, seed=2)),
    line(stations(0.0, 3.0, 9, seed=3), stations(1.3, 4.2, 8, seed=4)),
    line(stations(0.0, 3.0, 30, seed=5), stations(1.0, 2.0, 3, seed=6)),
]


@BOTH
@pytest.mark.parametrize("at", RANDOM + PARTIAL)
def test_rows_reproduce_constants_and_linear_functions(algorithm: ContactAlgorithm, at: Chains) -> None:
    """P 1 = 1 and P s = s: no force in a rigid motion, no gap in a common stretch or tilt."""
    w = weights(algorithm, at)
    assert len(w) > 2
    np.testing.assert_allclose(w.sum(axis=1), 0.0, atol=ROUND_OFF)
    np.testing.assert_allclose(w @ at.nodes[:, 0], 0.0, atol=10 * ROUND_OFF)


@BOTH
@pytest.mark.parametrize("at", RANDOM)
def test_a_fully_covered_slave_node_weighs_itself_alone(algorithm: ContactAlgorithm, at: Chains) -> None:
    """With T = D the slave weights are the identity: a row is one of node-on-segment with other weights P."""
    w = weights(algorithm, at)
    np.testing.assert_allclose(w[:, : len(at.slave.nodes)], np.eye(len(at.slave.nodes)), atol=ROUND_OFF)


@pytest.mark.parametrize(("algorithm", "decay"), [(P0, 0.1715729), (P1, 0.2679492)], ids=["P0", "P1"])
def test_weights_decay_along_the_master(algorithm: ContactAlgorithm, decay: float) -> None:
    """Rows are dense in principle and fall by a constant factor per node, so they can be cut."""
    h = 0.1
    at = line(h * np.arange(41), h * (np.arange(-1, 43) + 0.37))
    right = at.nodes[:, 0] > 2.0 + 3.0 * h  # beyond the support of the row's own multiplier
    right[: len(at.slave.nodes)] = False
    tail = np.abs(weights(algorithm, at)[20, right])[:10]
    np.testing.assert_allclose(tail[1:] / tail[:-1], decay, rtol=1e-6)


# --- from forces to pressures -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("algorithm", "own", "neighbour", "decay"),
    [(P0, 1.414214, -0.2426407, -0.1715729), (P1, 1.732051, -0.4641016, -0.2679492)],
    ids=["P0", "P1"],
)
def test_pressure_of_one_unit_nodal_force(
    algorithm: ContactAlgorithm, own: float, neighbour: float, decay: float
) -> None:
    """sqrt(2)/h or sqrt(3)/h at the node, and half the overshoot at its neighbours with P0 (given to 7 digits)."""
    h, n = 0.02, 101
    pair, _ = pair_of(algorithm, line(h * np.arange(n), np.array([-1.0, 1.0, 5.0])))
    force = np.zeros(n)
    force[50] = 1.0
    found = h * pair.tractions(force)
    np.testing.assert_allclose(found[[50, 49, 51]], [own, neighbour, neighbour], rtol=1e-6)
    np.testing.assert_allclose(found[52:56] / found[51:55], decay, rtol=1e-5)


@BOTH
@pytest.mark.parametrize("at", RANDOM + PARTIAL)
def test_pressure_carries_the_force(algorithm: ContactAlgorithm, at: Chains) -> None:
    """The pressure of any nodal forces y is T^-1 y, so its own nodal forces are y again."""
    pair, _ = pair_of(algorithm, at)
    kept = pair.coupling.owner == np.arange(pair.slots)
    y = np.where(kept, np.random.default_rng(1).uniform(size=pair.slots), 0.0)
    again = merged_coupling(pair) @ np.where(kept, pair.tractions(y), 0.0)
    np.testing.assert_allclose(again, y, atol=ROUND_OFF)


def merged_coupling(pair: OperatorPair) -> Floats:
    """T with rows and columns of merged multipliers added to their owners."""
    p, n = pair.pieces, pair.count
    T = np.zeros((pair.slots, pair.slots))
    rows = pair.coupling.owner[p.multiplier[:n]]
    np.add.at(T, (rows[:, :, None], rows[:, None, :]), p.T[:n] * (rows[:, :, None] >= 0) * (rows[:, None, :] >= 0))
    return T


# --- forces of both bodies ----------------------------------------------------------------------


@BOTH
@pytest.mark.parametrize("at", [flat(), flat(full=False), curved(), *PARTIAL])
def test_forces_on_both_bodies_cancel(algorithm: ContactAlgorithm, at: Chains) -> None:
    found = conditions(algorithm, at)
    y = np.random.default_rng(2).uniform(size=len(found.gap))
    force = np.einsum("k,kni->ni", y, dense(found, found.normal_weight, len(at.nodes)))
    pushed = np.abs(force[at.slave.nodes]).sum()
    np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=ROUND_OFF * pushed)
    np.testing.assert_allclose(force[at.slave.nodes].sum(axis=0), -force[at.master.nodes].sum(axis=0), rtol=ROUND_OFF)


@BOTH
@pytest.mark.parametrize("at", PARTIAL)
def test_a_uniform_pressure_crosses_a_partial_cover(algorithm: ContactAlgorithm, at: Chains) -> None:
    """Lambda = 1 gives the covered length as force, on either side, and no gap is felt where there is none."""
    pair, _ = pair_of(algorithm, at)
    x, n = at.nodes[:, 0], len(at.slave.nodes)
    covered = min(x[n - 1], x[n:].max()) - max(x[0], x[n:].min())
    y = merged_coupling(pair) @ (pair.coupling.owner == np.arange(pair.slots))
    found = conditions(algorithm, at)
    force = y[found.owner] @ dense(found, found.normal_weight, len(at.nodes))[..., 1]
    assert force[:n].sum() == pytest.approx(covered, abs=ROUND_OFF)
    assert force[n:].sum() == pytest.approx(-covered, abs=ROUND_OFF)
    assert force[:n].min() > -ROUND_OFF
    np.testing.assert_allclose(found.gap, 0.0, atol=ROUND_OFF)


# --- multipliers that are merged or dropped -----------------------------------------------------


@BOTH
@pytest.mark.parametrize(("beyond", "owner"), [(0.5, 6), (0.04, 5), (5e-4, 5), (1e-7, 5)])
def test_a_multiplier_with_little_cover_joins_its_neighbour(
    algorithm: ContactAlgorithm, beyond: float, owner: int
) -> None:
    """Below 5 % of its length it is merged, however little it is: P1 covers beyond^2/2 of it, P0 all of `beyond`."""
    h = 0.25
    begins = 5.0 * h if algorithm is P1 else 5.5 * h  # where the support of multiplier 6 begins
    pair, _ = pair_of(algorithm, line(h * np.arange(9), np.array([-1.0, begins + beyond * h])))
    assert pair.coupling.owner[6] == owner
    assert list(pair.coupling.owner[:6]) == list(range(6))
    np.testing.assert_array_equal(pair.coupling.owner[7:], -1)


@BOTH
def test_a_corner_that_hardly_touches_has_no_condition(algorithm: ContactAlgorithm) -> None:
    """With nothing to join and less than 1e-6 of its length a multiplier is dropped: its row would be round-off."""
    h = 0.25
    pair, _ = pair_of(algorithm, line(h * np.arange(9), np.array([2.0 - 1e-7 * h, 4.0])))
    assert len(pair.coupling.order) == 0


@BOTH
def test_the_multiplier_of_a_fixed_end_joins_its_neighbour(algorithm: ContactAlgorithm) -> None:
    """A node that cannot move has no condition; what it carries goes to its neighbour's multiplier."""
    at = line(np.linspace(0.0, 2.0, 9), np.linspace(-0.5, 2.5, 6))
    fixed = np.zeros(9, np.bool_)
    fixed[0] = True
    pair = OperatorPair("contact", algorithm, at.slave, at.master, at.nodes, 0, None, fixed)
    pair.update(at.nodes, np.zeros((0, 9)))
    assert list(pair.coupling.owner) == [1, *range(1, 9)]
    assert pair.cover[1] == pytest.approx(0.125 + 0.25, abs=ROUND_OFF)


# --- the gap of a curved pair -------------------------------------------------------------------


@BOTH
def test_gap_of_parallel_arcs_is_their_distance(algorithm: ContactAlgorithm) -> None:
    """Concentric arcs 0.02 apart: the polygons differ from them by h^2/8R, and so may the gap."""
    angle = np.linspace(-0.6, 0.6, 25)
    wide = np.linspace(-0.7, 0.7, 38)
    inner, outer = (np.stack([r * np.sin(a), -r * np.cos(a)], axis=1) for r, a in ((0.98, angle), (1.0, wide)))
    gap = conditions(algorithm, chains(inner, outer)).gap
    sagitta = 0.05**2 / 8
    np.testing.assert_allclose(gap[1:-1], 0.02, atol=sagitta)


def folding(angle: float, rise: float = 0.0) -> Chains:
    """A slave that lies on a plane up to a vertex at x = 0 and rises from there; the plane is turned by `rise`."""
    flank = 0.1 * np.array([[-2.0, 0.0], [-1.0, 0.0], [0.0, 0.0], [np.cos(angle), np.sin(angle)]])
    turn = np.array([[np.cos(rise), np.sin(rise)], [-np.sin(rise), np.cos(rise)]])
    return chains(flank, np.array([[-1.0, 0.0], [-0.03, 0.0], [1.0, 0.0]]) @ turn)


@BOTH
def test_a_vertex_is_pressed_along_the_normal_of_the_face(algorithm: ContactAlgorithm) -> None:
    """And smooth slaves along their own: to the last bit, for nothing is added there."""
    for angle in (0.65, 0.9, 1.3):
        np.testing.assert_allclose(pair_of(algorithm, folding(angle))[0].normals[2], [0.0, 1.0], atol=ROUND_OFF)
    for angle, rise in ((0.1, 0.0), (0.11, 0.05), (0.0, 0.3)):
        expected = np.array([-np.sin(0.5 * angle), np.cos(0.5 * angle)])
        found = pair_of(algorithm, folding(angle, rise))[0].normals[2]
        np.testing.assert_allclose(found, expected, atol=ROUND_OFF)


@BOTH
def test_normals_of_a_fold_turn_without_a_jump(algorithm: ContactAlgorithm) -> None:
    """As the flank lies down no step of its angle turns the normal by more than five times as much."""
    angles = np.linspace(0.0, 1.25, 126)
    normals = np.array([pair_of(algorithm, folding(angle))[0].normals[2] for angle in angles])
    assert np.hypot(*np.diff(normals, axis=0).T).max() < 5.0 * (angles[1] - angles[0])
