"""Flow along the straight path of a step: second order, objective, with its own tangent."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from contactlab_solids.linear_hardening import LinearHardening
from contactlab_solids.power_law import PowerLaw

from contactlab.api import Floats, Material
from contactlab.model.bodies.straight_path import Path, StraightPath

LAWS = (
    PowerLaw(young=70000.0, poisson=0.3, density=2.7e-9, strength=348.0, prestrain=0.02, exponent=0.03),
    PowerLaw(young=7000.0, poisson=0.3, density=2.7e-9, strength=348.0, prestrain=0.02, exponent=0.3),
    LinearHardening(young=7000.0, poisson=0.3, density=2.7e-9, yield_stress=100.0, hardening=50.0),
)
laws = pytest.mark.parametrize("law", LAWS, ids=["aluminium", "soft", "linear"])


def turning(time: float) -> Floats:
    """F^-1 (4, 3) of points that are stretched first, and sheared more and more."""
    f = np.tile(np.eye(2), (3, 1, 1))
    f[:, 0, 0] += np.array([0.1, -0.05, 0.08]) * time
    f[:, 1, 1] -= np.array([0.08, -0.06, 0.05]) * time
    f[:, 0, 1] += np.array([0.2, 0.1, -0.3]) * time**2
    return np.ascontiguousarray(np.linalg.inv(f).reshape(-1, 4).T)


def follow(law: Material, steps: int, along: bool) -> tuple[Floats, Floats]:
    """Stress and history after a turning path in load steps, along the path or by the law alone."""
    path, history = StraightPath(law), np.zeros((law.history_size, 3))
    stress, new = np.empty((4, 3)), np.empty_like(history)
    for number in range(steps):
        path.start = turning(number / steps) if along else None
        path.stress(turning((number + 1) / steps), history, 0.0, stress, new)
        history[:] = new
    return stress, history


@laws
def test_flow_that_turns_is_of_second_order(law: Material) -> None:
    exact, _ = follow(law, 512, along=True)
    errors = {
        along: [np.abs(follow(law, steps, along)[0] - exact).max() for steps in (16, 32, 64)] for along in (True, False)
    }
    orders = {along: np.log2(np.array(each[:-1]) / np.array(each[1:])) for along, each in errors.items()}
    assert (orders[True] > 1.7).all(), errors
    assert (orders[False] < 1.2).all(), errors
    assert errors[True][0] < 0.3 * errors[False][0]


@laws
def test_both_go_to_the_same_state(law: Material) -> None:
    for one, other in zip(follow(law, 64, True), follow(law, 4096, False), strict=True):
        scale = np.abs(other).max(axis=1, keepdims=True)
        assert np.abs(one - other).max() <= 2e-3 * scale.max()


@laws
def test_a_point_on_the_yield_surface_stays_on_it(law: PowerLaw | LinearHardening) -> None:
    """After a step of any size Mises' stress of the Kirchhoff stress is the yield stress of the plastic strain."""
    stress, history = follow(law, 3, True)
    kirchhoff = stress / np.linalg.det(turning(1.0).T.reshape(-1, 2, 2))
    deviator = kirchhoff[:3] - kirchhoff[:3].mean(axis=0)
    mises = np.sqrt(1.5 * ((deviator**2).sum(axis=0) + 2.0 * kirchhoff[3] ** 2))
    assert mises == pytest.approx(law.flow_stress(history[3]), rel=1e-10)


@laws
@pytest.mark.parametrize("angle", [0.1, 1.5])
def test_a_rigid_rotation_makes_nothing_flow(law: Material, angle: float) -> None:
    """Straight lines between positions would shrink the body on its way, by 1 - cos(angle/2)."""
    stress, history = follow(law, 8, True)
    cos, sin = np.cos(angle), np.sin(angle)
    turn = np.array([[cos, -sin], [sin, cos]])
    path = StraightPath(law)
    path.start = turning(1.0)
    # a hair further on the way as well, so that every point flows
    end = np.ascontiguousarray((turning(1.0 + 1e-9).T.reshape(-1, 2, 2) @ turn.T).reshape(-1, 4).T)
    turned, new = np.empty_like(stress), np.empty_like(history)
    path.stress(end, history, 0.0, turned, new)
    assert (new[3] > history[3]).all()
    assert np.abs(new - history)[:4].max() < 1e-8
    there = np.array([[[xx, xy], [xy, yy]] for xx, yy, _, xy in stress.T])
    expected = turn @ there @ turn.T
    assert turned[[0, 1, 3]] == pytest.approx(expected[:, [0, 1, 0], [0, 1, 1]].T, abs=1e-3)


@laws
def test_the_tangent_is_the_derivative(law: Material) -> None:
    _, history = follow(law, 8, True)
    path = StraightPath(law)
    path.start, end = turning(1.0), turning(1.1)
    tangent = np.empty((4, 4, 3))
    path.tangent(end, history, 0.0, tangent)
    high, low, spare, size = np.empty((4, 3)), np.empty((4, 3)), np.empty_like(history), 1e-6
    for j in range(4):
        for out, sign in ((high, 1.0), (low, -1.0)):
            moved = end.copy()
            moved[j] += sign * size
            path.stress(moved, history, 0.0, out, spare)
        found = (high - low) / (2.0 * size)
        assert tangent[:, j] == pytest.approx(found, abs=1e-5 * np.abs(tangent).max())


def test_points_that_do_not_flow_are_the_laws_own() -> None:
    law = LAWS[0]
    path, gradient = StraightPath(law), np.array([[1.0001], [0.0], [0.0], [1.0]])
    path.start = np.array([[1.0], [0.0], [0.0], [1.0]])
    history = np.zeros((law.history_size, 1))
    results = []
    for each in (path, law):
        stress, new, tangent = np.empty((4, 1)), np.empty_like(history), np.empty((4, 4, 1))
        each.stress(gradient, history, 0.0, stress, new)
        each.tangent(gradient, history, 0.0, tangent)
        results.append((stress, new, tangent))
    for one, other in zip(*results, strict=True):
        assert np.array_equal(one, other)


def test_equal_parts_of_a_path_change_the_body_equally() -> None:
    path = Path(LAWS[0], turning(0.2), turning(1.0), np.arange(3, dtype=np.int32))
    eighths = [path.at(number / 8).T.reshape(-1, 2, 2) for number in range(9)]
    first = np.linalg.inv(eighths[0]) @ eighths[1]
    for before, after in pairwise(eighths):
        assert np.linalg.inv(before) @ after == pytest.approx(first, abs=1e-13)
