"""Old factors in new iterations: they must not be seen in an answer, only in how often a matrix is factorised."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csc_array, diags_array, eye_array, kron, random_array

import contactlab
from contactlab.implicit import factor as factors
from contactlab.implicit.factor import Factor, ReusedFactor, preconditioned
from contactlab.run.simulation import simulate


def saddle_like(n: int) -> csc_array:
    """A grid's Laplacian, in other units below than above as forces and gaps are."""
    line = diags_array([-np.ones(n - 1), 2.0 * np.ones(n), -np.ones(n - 1)], offsets=[-1, 0, 1])
    grid = kron(line, eye_array(n)) + kron(eye_array(n), line)
    units = np.where(np.arange(n * n) < n, 1.0, 7e4)
    return csc_array(diags_array(units) @ grid)


@pytest.mark.parametrize("accuracy", [1e-3, 1e-8, 1e-12])
def test_a_changed_matrix_is_solved_as_exactly_as_asked(accuracy: float) -> None:
    """In the norm of rows scaled by their largest entries; ten per cent off in a few rows, as contact changes them."""
    matrix, draw = saddle_like(20), np.random.default_rng(1)
    change = random_array(matrix.shape, density=1e-4, rng=draw)
    changed = csc_array(matrix + 0.1 * diags_array(matrix.diagonal()) @ change)
    right = changed @ draw.normal(size=400)
    found = preconditioned(changed, right, Factor(matrix), accuracy)
    assert found is not None
    rows = abs(changed).max(axis=1).toarray().ravel()
    # twice: the recursion's residual and the true one part by round-off of the basis
    left = np.linalg.norm((right - changed @ found) / rows)
    assert left <= 2.0 * accuracy * np.linalg.norm(right / rows)


def test_another_matrix_is_given_up_soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """A preconditioner that does not fit costs a few solutions, not `MOST` of them."""
    matrix, draw = saddle_like(20), np.random.default_rng(1)
    other = csc_array(random_array(matrix.shape, density=0.05, rng=draw) + 10.0 * eye_array(400))
    factor, calls = Factor(matrix), []
    once = factor.once
    monkeypatch.setattr(factor, "once", lambda right: calls.append(1) or once(right))
    assert preconditioned(other, draw.normal(size=400), factor, 1e-10) is None
    assert len(calls) <= factors.MOST // 2


def test_other_unknowns_and_the_first_iteration_need_new_factors() -> None:
    matrix, right = saddle_like(10), np.ones(100)
    solver = ReusedFactor()
    solver.solve(matrix, right, (b"a",), np.inf)
    first = solver.factor
    solver.solve(matrix, right, (b"a",), 1e-3)
    assert solver.factor is first
    solver.solve(matrix, right, (b"b",), 1e-3)
    assert solver.factor is not first
    second = solver.factor
    solver.solve(matrix, right, (b"b",), np.inf)
    assert solver.factor is not second


@pytest.mark.parametrize("friction", [None, {"use": "coulomb", "mu": 0.2}], ids=["frictionless", "coulomb"])
def test_a_run_is_the_same_with_fewer_factors(friction: object, monkeypatch: pytest.MonkeyPatch) -> None:
    """As many iterations to the same answer within the tolerance of the solve (1e-8), and a third of factors less."""
    changes = {"level": 1, "integrator": {"use": "newton", "steps": 5}, "record.frames": 1}
    if friction:
        changes["contacts.0.friction"] = friction
    scene = contactlab.load_scene("disc-on-block").with_(changes)
    counted: list[int] = []

    class Counting(Factor):
        def __init__(self, matrix: csc_array) -> None:
            counted[-1] += 1
            super().__init__(matrix)

    monkeypatch.setattr(factors, "Factor", Counting)
    found = []
    for solve in (preconditioned, lambda *_: None):
        monkeypatch.setattr(factors, "preconditioned", solve)
        counted.append(0)
        found.append(simulate(scene))
    saved, plain = found
    assert counted[1] == plain.summary["iterations"] == saved.summary["iterations"]
    assert counted[0] <= 2 * counted[1] // 3
    a, b = (results.summary["reactions"]["block.bottom"][1] for results in found)
    assert a == pytest.approx(b, rel=1e-7)
    one, two = (results.contact["contacts.0"].last.pressure for results in found)
    np.testing.assert_allclose(one, two, atol=1e-6 * two.max())
