"""Large systems are put in order by nested dissection: a permutation that fills in little, and no other answer."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import block_array, csc_array, diags_array, eye_array, kron

import contactlab
from contactlab.implicit import factor
from contactlab.implicit.dissection import dissected
from contactlab.implicit.factor import Factor
from contactlab.run.simulation import simulate


def grid(n: int) -> tuple[csc_array, np.ndarray]:
    """Both directions of n x n nodes, coupled with their neighbours, and their places (2 n^2, 2) in any order."""
    line = diags_array([-np.ones(n - 1), 2.5 * np.ones(n), -np.ones(n - 1)], offsets=[-1, 0, 1])
    matrix = kron(kron(line, eye_array(n)) + kron(eye_array(n), line), np.array([[2.0, 0.5], [0.5, 2.0]]))
    nodes = np.random.default_rng(1).permutation(n * n)
    both = (2 * nodes[:, None] + np.arange(2)).ravel()
    places = np.stack(np.divmod(nodes, n), axis=1).repeat(2, axis=0).astype(float)
    return csc_array(csc_array(matrix)[both][:, both]), places


def with_multipliers(matrix: csc_array, number: int) -> csc_array:
    """Unknowns more, each coupled with one of the first, without a diagonal: what contact adds."""
    rows = csc_array(eye_array(number, matrix.shape[0]))
    return csc_array(block_array([[matrix, rows.T], [rows, None]]))


def fill(matrix: csc_array, ordering: str) -> int:
    options = {"SymmetricMode": True}
    found = factor.splu(matrix, permc_spec=ordering, diag_pivot_thresh=factor.PIVOT, options=options)
    return int(found.nnz)


def test_fill_approaches_that_of_minimum_degree() -> None:
    """Which fills in less on small grids, a third here, and more on large ones (docs/statics.md): the share must fall.

    Rows of nodes one after another, no order at all, would fill in three times as much on the larger grid.
    """
    shares = []
    for n in (20, 80):
        matrix, places = grid(n)
        order = dissected(matrix, places)
        assert np.array_equal(np.sort(order), np.arange(2 * n * n)), "every unknown once"
        shares.append(fill(csc_array(matrix[order][:, order]), "NATURAL") / fill(matrix, "MMD_AT_PLUS_A"))
    assert shares[1] < shares[0] < 1.5


def test_an_order_changes_no_solution(monkeypatch: pytest.MonkeyPatch) -> None:
    """Multipliers stand at the nodes that they hold. Both solutions are refined to round-off."""
    matrix, places = grid(15)
    system = with_multipliers(matrix, 40)
    right = np.random.default_rng(2).normal(size=system.shape[0])
    without = Factor(system).solve(right)
    monkeypatch.setattr(factor, "FROM", 1)
    ordered = Factor(system, places)
    assert ordered.order is not None
    np.testing.assert_allclose(ordered.solve(right), without, rtol=0.0, atol=1e-12 * np.abs(without).max())


def test_a_run_ends_alike_in_either_order(monkeypatch: pytest.MonkeyPatch) -> None:
    """Friction and both kinds of multipliers; to the tolerance of the steps, 1e-8."""
    friction = {"use": "coulomb", "mu": 0.2}
    keys = {"integrator": {"use": "newton", "steps": 2}, "record.frames": 1, "contacts.0.friction": friction}
    scene = contactlab.load_scene("disc-on-block").with_({"level": 1, "supports.1.uy.to": -0.02} | keys)
    expected = simulate(scene)
    monkeypatch.setattr(factor, "FROM", 1)
    found = simulate(scene)
    assert found.status == expected.status == "finished"
    pressures = [np.asarray(run.contact["contacts.0"].last.pressure) for run in (found, expected)]
    np.testing.assert_allclose(*pressures, rtol=0.0, atol=1e-7 * pressures[1].max())
