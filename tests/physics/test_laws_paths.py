"""Laws along paths with known answers (shear, rotation, stretching), driven by deformation gradients."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from contactlab_solids.hypoelastic import Hypoelastic
from contactlab_solids.linear_elastic import LinearElastic
from contactlab_solids.linear_hardening import LinearHardening
from contactlab_solids.neo_hookean import NeoHookean
from contactlab_solids.power_law import PowerLaw
from numpy.typing import ArrayLike
from scipy.optimize import fsolve

from contactlab.api import XX, XY, YY, ZZ, Floats, Material

YOUNG, POISSON, DENSITY = 7000.0, 0.3, 2.7e-9
SHEAR = YOUNG / 2.6
PAPER = PowerLaw(70000.0, 0.3, 2.7e-9, strength=348.0, prestrain=0.02, exponent=0.03)


def gradient(law: Material, before: Floats, after: Floats) -> Floats:
    """What a law is given when one point goes from `before` to `after`, both F (2, 2)."""
    if law.kinematics == "small":
        rows = after - np.eye(2)
    elif law.kinematics == "finite":
        rows = np.linalg.inv(after)
    else:
        rows = (after - before) @ np.linalg.inv(0.5 * (before + after))
    return np.ascontiguousarray(rows.reshape(4, 1))


def follow(law: Material, path: ArrayLike) -> tuple[Floats, Floats]:
    """Stress (4,) and history (h,) at the end of a path of deformation gradients, the first of them F = I."""
    history, stress = np.zeros((law.history_size, 1)), np.zeros((4, 1))
    steps = np.asarray(path, dtype=float)
    for before, after in pairwise(steps):
        law.stress(gradient(law, before, after), history, 1.0, stress, history)
    return stress[:, 0], history[:, 0]


def shears(amount: float, steps: int) -> list[Floats]:
    return [np.array([[1.0, g], [0.0, 1.0]]) for g in np.linspace(0.0, amount, steps + 1)]


def turns(angle: float, steps: int, base: Floats) -> list[Floats]:
    angles = np.linspace(0.0, angle, steps + 1)
    return [np.array([[math.cos(t), -math.sin(t)], [math.sin(t), math.cos(t)]]) @ base for t in angles]


# --- elastic -------------------------------------------------------------------------------------


def test_neo_hookean_confined_stretch() -> None:
    stress, _ = follow(NeoHookean(YOUNG, POISSON, DENSITY), [np.eye(2), np.diag([1.0, 0.9])])
    # mu (b - 1)/J + lambda ln J/J by hand, given to seven digits
    np.testing.assert_allclose(stress[[YY, XX, ZZ]], [-1041.148, -472.772, -472.772], atol=6e-4)


def test_neo_hookean_free_sides() -> None:
    law = NeoHookean(YOUNG, POISSON, DENSITY)
    lateral = fsolve(lambda s: follow(law, [np.eye(2), np.diag([s[0], 0.9])])[0][XX], 1.04)[0]
    stress, _ = follow(law, [np.eye(2), np.diag([lateral, 0.9])])
    assert lateral == pytest.approx(1.044997, abs=6e-7)
    np.testing.assert_allclose(stress[[YY, ZZ]], [-807.320, -263.418], atol=1e-3)


def test_jaumann_rate_in_simple_shear() -> None:
    """tau/mu = sin gamma and sigma_xx/mu = 1 - cos gamma, approached with the square of the step."""
    law = Hypoelastic(YOUNG, POISSON, DENSITY)
    exact = SHEAR * np.array([1.0 - math.cos(1.0), math.cos(1.0) - 1.0, 0.0, math.sin(1.0)])
    errors = [np.abs(follow(law, shears(1.0, steps))[0] - exact).max() / SHEAR for steps in (100, 200, 400)]
    assert errors[-1] < 1e-6  # 1/12 of the step's square
    assert errors[0] / errors[1] == pytest.approx(4.0, abs=0.05)
    assert errors[1] / errors[2] == pytest.approx(4.0, abs=0.05)


@pytest.mark.parametrize("steps", [1, 10, 100])
@pytest.mark.parametrize(
    "law",
    [
        Hypoelastic(YOUNG, POISSON, DENSITY),
        NeoHookean(YOUNG, POISSON, DENSITY),
        PAPER,
        LinearHardening(70000.0, 0.3, 2.7e-9, yield_stress=400.0, hardening=100.0),
    ],
    ids=lambda law: type(law).__name__,
)
def test_stress_turns_with_the_body(law: Material, steps: int) -> None:
    """A prestressed (and plastically deformed) point turned by 90 degrees, whatever the number of steps."""
    base = np.array([[1.06, 0.05], [0.02, 0.97]])
    before, history = follow(law, [np.eye(2), base])
    after, history_after = follow(law, [np.eye(2), *turns(0.5 * math.pi, steps, base)])
    scale = np.abs(before).max()
    expected = before[[YY, XX, ZZ, XY]] * [1.0, 1.0, 1.0, -1.0]
    np.testing.assert_allclose(after, expected, atol=1e-12 * scale * math.sqrt(steps))  # round-off per step
    if "equivalent_plastic_strain" in law.history_names:
        assert history[3] > 0.01
        assert history_after[3] == pytest.approx(history[3], rel=1e-12)


def test_small_rotation_leaves_hooke_without_stress() -> None:
    stress, _ = follow(LinearElastic(YOUNG, POISSON, DENSITY), [np.eye(2), np.array([[1.0, -1e-3], [1e-3, 1.0]])])
    assert np.abs(stress).max() == 0.0


# --- plastic -------------------------------------------------------------------------------------


def test_flow_stress_of_the_paper() -> None:
    np.testing.assert_allclose(PAPER.flow_stress(np.array([0.0, 0.1, 0.5])), [309.464, 326.554, 341.240], atol=6e-4)


def upsetting(law: Material, height: float, steps: int) -> tuple[Floats, Floats]:
    """Plane-strain compression to `height` with free sides."""
    path, wide = [np.eye(2)], 1.0
    history = np.zeros((law.history_size, 1))
    stress, trial = np.zeros((4, 1)), np.empty((law.history_size, 1))

    def side_stress(width: float, tall: float) -> float:
        law.stress(gradient(law, path[-1], np.diag([width, tall])), history, 1.0, stress, trial)
        return float(stress[XX, 0])

    for tall in np.linspace(1.0, height, steps + 1)[1:]:
        for _ in range(50):  # Newton by the secant: the sides must be free of stress
            value = side_stress(wide, tall)
            slope = (side_stress(wide + 1e-7, tall) - value) / 1e-7
            wide -= value / slope
            if abs(value) < 1e-9:
                break
        side_stress(wide, tall)
        history[:] = trial
        path.append(np.diag([wide, tall]))
    return stress[:, 0], history[:, 0]


@pytest.mark.parametrize("steps", [1, 5, 50])
def test_upsetting_to_half_height(steps: int) -> None:
    """Rigid-plastic limit: ep = (2/sqrt 3) ln 2, die pressure (2/sqrt 3) sigma_y(ep) = 399.456 MPa."""
    stress, history = upsetting(PAPER, 0.5, steps)
    strain = 2.0 / math.sqrt(3.0) * math.log(2.0)
    assert history[3] == pytest.approx(strain, rel=0.01)  # less the elastic part, 0.5 %
    assert -stress[YY] == pytest.approx(399.456, rel=0.01)
    # the path is proportional: one step gives what fifty give
    assert -stress[YY] == pytest.approx(-upsetting(PAPER, 0.5, 20)[0][YY], rel=2e-4)


def test_plastic_flow_keeps_the_volume() -> None:
    """After unloading every stress of a strongly sheared point, det F is 1."""
    law = LinearHardening(70000.0, 0.3, 2.7e-9, yield_stress=400.0)
    _, history = follow(law, shears(2.0, 7))

    def stresses(f: Floats) -> Floats:
        """In-plane stresses, and the rotation that is left free."""
        trial = f.reshape(2, 2)
        stress = np.zeros((4, 1))
        law.stress(gradient(law, trial, trial), history[:, None], 1.0, stress, np.zeros((4, 1)))
        return np.array([stress[XX, 0], stress[YY, 0], stress[XY, 0], f[2]])

    relaxed = fsolve(stresses, shears(2.0, 1)[-1].ravel(), xtol=1e-13).reshape(2, 2)
    # plane strain keeps a stress zz, whose elastic volume change is bounded by yield / bulk modulus
    stress = np.zeros((4, 1))
    law.stress(gradient(law, relaxed, relaxed), history[:, None], 1.0, stress, np.zeros((4, 1)))
    bulk = 70000.0 / (3.0 * 0.4)
    assert math.log(np.linalg.det(relaxed)) == pytest.approx(stress[ZZ, 0] / (3.0 * bulk), abs=1e-6)


@pytest.mark.parametrize("size", [1e-4, 1e-2, 0.3])
def test_return_lands_on_the_yield_surface(size: float) -> None:
    """Mises' Kirchhoff stress equals the yield stress after any step; the plastic strain never falls."""
    random = np.random.default_rng(3)
    points = 200
    laws = (
        PAPER,
        PowerLaw(70000.0, 0.3, 1e-9, 500.0, 1e-4, 0.5),
        LinearHardening(7e4, 0.3, 1e-9, 300.0, 2e4),
        LinearHardening(7e4, 0.3, 1e-9, 12000.0),  # elastic strains of 20 %
    )
    for law in laws:
        history, stress = np.zeros((law.history_size, points)), np.empty((4, points))
        rows = np.tile([[1.0], [0.0], [0.0], [1.0]], points)
        for _ in range(20):
            rows = rows + random.uniform(-size, size, (4, points))
            before = history.copy()
            law.stress(rows, history, 1.0, stress, history)
            step = history[3] - before[3]
            assert step.min() >= 0.0
            tau = stress / (rows[0] * rows[3] - rows[1] * rows[2])
            mean = tau[:3].mean(axis=0)
            mises = np.sqrt(1.5 * (((tau[:3] - mean) ** 2).sum(axis=0) + 2.0 * tau[3] ** 2))
            strength = law.flow_stress(history[3])
            yielded = step > 0.0
            # two logarithms and an exponential between them: a few digits above round-off of the moduli
            np.testing.assert_allclose(mises[yielded], strength[yielded], rtol=1e-9)
            assert (mises <= strength * (1.0 + 1e-9)).all()
            if size > 0.1:
                break  # a random walk of this size would fold the point over
        assert size < 0.1 or (history[3] > 0.0).any()


def test_short_and_long_steps_meet() -> None:
    """Series for small strains and steps against the general functions: a thousand steps or one, straight path."""
    for law in (PAPER, LinearHardening(70000.0, 0.3, 2.7e-9, 400.0, 100.0)):
        for end in (np.diag([1.04, 0.96]), np.diag([0.8, 1.1])):
            powers = [np.diag(np.diag(end) ** (n / 1000)) for n in range(1001)]
            many, many_history = follow(law, powers)
            one, one_history = follow(law, [np.eye(2), end])
            # stretching is proportional but for the yield point, which falls inside a step
            np.testing.assert_allclose(one, many, rtol=0.0, atol=1e-3 * np.abs(many).max())
            assert one_history[3] == pytest.approx(many_history[3], rel=1e-3)


def test_work_is_stored_or_dissipated() -> None:
    """Work of the stresses along a path that yields and turns back = Hencky energy + plastic work, and >= 0."""
    law = PAPER
    there = [np.array([[1.0, g], [0.3 * g, 1.0 - 0.4 * g]]) for g in np.linspace(0.0, 0.1, 2001)]
    path = [*there, *there[::-1][1:]]
    history, stress, work, losses = np.zeros((5, 1)), np.zeros((4, 1)), 0.0, [0.0]
    for before, after in pairwise(path):
        old = stress[:, 0] * np.linalg.det(before)
        rows = gradient(law, before, after)
        law.stress(rows, history, 1.0, stress, history)
        new = stress[:, 0] * np.linalg.det(after)
        rate = (after - before) @ np.linalg.inv(0.5 * (before + after))
        mean = 0.5 * (old + new)
        work += mean[XX] * rate[0, 0] + mean[YY] * rate[1, 1] + mean[XY] * (rate[0, 1] + rate[1, 0])
        lost = np.empty(1)
        law.dissipation(rows, history, lost)
        losses.append(float(lost[0] * np.linalg.det(after)))
    stored = np.empty(1)
    law.energy(rows, history, stored)
    assert min(np.diff(losses)) >= -1e-12
    assert losses[-1] > 10.0 * stored[0] > 0.0
    assert work == pytest.approx(losses[-1] + stored[0], rel=1e-5)  # trapezoidal work, error of order step^2


def test_tension_below_yield_is_elastic() -> None:
    _, history = follow(PAPER, [np.eye(2), np.diag([1.003, 1.0])])
    assert not history.any()


def test_neighbours_do_not_change_a_point() -> None:
    """Yielding neighbours decide which kernels a block runs, not what comes out."""
    random = np.random.default_rng(5)
    rows = np.array([[1.0], [0.0], [0.0], [1.0]]) + random.uniform(-0.02, 0.02, (4, 101))
    rows[:, :50] = np.array([[1.0], [0.0], [0.0], [1.0]]) + random.uniform(-1e-3, 1e-3, (4, 50))
    history, stress = np.zeros((5, 101)), np.empty((4, 101))
    PAPER.stress(rows, history, 1.0, stress, history)
    for p in range(101):
        own_history, own = np.zeros((5, 1)), np.empty((4, 1))
        PAPER.stress(np.ascontiguousarray(rows[:, p : p + 1]), own_history, 1.0, own, own_history)
        # a vector loop and its scalar rest may contract different products: a few units in the last place
        np.testing.assert_allclose(own[:, 0], stress[:, p], rtol=0.0, atol=1e-14 * 70000.0)
        np.testing.assert_allclose(own_history[:, 0], history[:, p], rtol=1e-12, atol=1e-15)
