"""Statuses that go round in circles: a small system that provably cycles, and many that may.

n columns stand over a floor, coupled by a matrix K: u >= 0, y >= 0, K u = load + y, u y = 0. Positive principal minors
make the solution unique, and yet full corrections need not end (Ben Gharbia & Gilbert, Math. Programming 134, 2012).
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from contactlab_statics.active_set import ActiveSet
from scipy.sparse import csc_array, csr_array

from contactlab.api import Conditions, ContactDerivatives, Floats, Ints
from contactlab.implicit import trial
from contactlab.implicit.iteration import NewtonIteration, Outcome

TOLERANCE = 1e-8


class Columns:
    """Equations, contact and balance in one: only vertical displacements are free."""

    def __init__(self, coupling: Floats, load: Floats, start: Floats) -> None:
        n = len(load)
        self.coupling, self.load = coupling, load
        self.displacement = np.stack([np.zeros(n), start], axis=1)
        self.force = np.where(start > 0.0, 0.0, coupling @ start - load)[None, :]
        self.reference = np.stack([np.arange(n, dtype=float), np.zeros(n)], axis=1)
        self.prescribed = SimpleNamespace(dof=np.arange(0, 2 * n, 2))
        self.enforcement, self.contact = ActiveSet(), self
        ones = np.ones(n)
        self.conditions = Conditions(
            present=ones > 0.0, gap=np.zeros(n), slip=np.zeros(0), force=self.force, anchor=np.zeros((1, n)),
            measure=ones, size=ones, bound=np.zeros((3, 0)), stiffness=ones,
        )  # fmt: skip
        self.patterns: list[bytes] = []

    by_energy = False
    acts = True

    def of_stresses(self, diagonal: Floats) -> Floats:
        return diagonal

    def settled(self) -> bool:
        return True

    @property
    def position(self) -> Floats:
        return self.reference + self.displacement

    def internal_force(self, dt: float) -> None:
        """Linear: nothing to prepare."""

    def estimate(self, time: float) -> None:
        """Nothing is known of where a step ends."""

    def iterated(self) -> None:
        """Nobody records."""

    def folded(self) -> bool:
        return False

    def free_share(self, position: Floats, motion: Floats, depth: float) -> float:
        """All of it: conditions see surfaces from anywhere."""
        return 1.0

    def scale(self, flexibility: Floats) -> None:
        """Statuses do not depend on the contact's stiffness."""

    def evaluate(self, position: Floats) -> None:
        self.conditions.gap[:] = position[:, 1]

    def linearise(self, chosen: Ints) -> ContactDerivatives:
        n, c = len(self.load), len(chosen)
        self.patterns.append(chosen.tobytes())
        rows = csr_array((np.ones(c), (np.arange(c), 2 * chosen + 1)), shape=(c, 2 * n))
        return ContactDerivatives(rows, None, rows, None, csr_array((2 * n, 2 * n)))

    def update_stresses(self, dt: float) -> None:
        self.internal_force(dt)

    def unbalanced(self, out: Floats) -> tuple[Floats, ...]:
        inner = self.coupling @ self.displacement[:, 1]
        out[:, 0], out[:, 1] = 0.0, self.load + self.force[0] - inner
        return self.load, inner, self.force

    def stiffness(self, dt: float) -> Any:
        full = np.eye(2 * len(self.load))
        full[1::2, 1::2] = self.coupling
        return csc_array(full)


def solved(columns: Columns, most: int) -> Outcome:
    state: Any = {"displacement": columns.displacement, "multipliers": columns.force}
    equations: Any = columns
    found = NewtonIteration(equations, state, columns, TOLERANCE, most)
    return found.run(1.0, np.zeros(len(columns.load)))


def three_in_a_ring(share: float) -> Columns:
    """w_i = u_i + share u_(i+1) - 1, from the pattern in which the first column alone is open.

    With it open, u = (1, 0, 0) and w = (0, -1, share - 1); the second opens. Then u = (1 - share, 1, 0): the first
    closes, the second stays, the third opens as w < 0 there; and so on round the ring.
    """
    return Columns(np.eye(3) + share * np.roll(np.eye(3), 1, axis=1), np.ones(3), np.array([1.0, 0.0, 0.0]))


@pytest.mark.parametrize("share", [1.1, 1.3, 1.6])
def test_full_corrections_never_end(share: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Otherwise the next test would prove nothing: three patterns, again and again."""
    monkeypatch.setattr(trial, "CAREFUL", (1.0,))
    columns = three_in_a_ring(share)
    assert "100 iterations left" in solved(columns, 100).reason
    assert len(set(columns.patterns[3:])) == 3


@pytest.mark.parametrize("share", [1.1, 1.3, 1.6])
def test_a_circle_is_left_by_part_of_a_correction(share: float) -> None:
    """All columns end open, at 1/(1 + share); within as many iterations as a step may take."""
    columns = three_in_a_ring(share)
    outcome = solved(columns, 25)
    assert outcome.reason == ""
    assert any("cycle" in row.note and row.length < 1.0 for row in outcome.trace)
    # the tolerance on forces is relative to a load of 1, the matrix's inverse is below 1
    np.testing.assert_allclose(columns.displacement[:, 1], 1.0 / (1.0 + share), atol=10.0 * TOLERANCE)


@pytest.mark.parametrize("n", [3, 5, 7, 20])
def test_strongly_coupled_columns_end(n: int) -> None:
    """Positive definite matrices that are far from symmetric, starts at random: every one is solved.

    The solution is looked at, not how it was found: no overlap, no pull, forces on closed columns alone.
    """
    draw = np.random.default_rng(n)
    for _ in range(10):
        a, b = draw.normal(size=(2, n, n))
        coupling = 0.02 * np.eye(n) + (a - a.T) / np.sqrt(n) + 0.05 * b @ b.T / n
        columns = Columns(coupling, draw.normal(size=n), np.maximum(draw.normal(size=n), 0.0))
        assert solved(columns, 100).reason == ""
        u, y = columns.displacement[:, 1], columns.force[0]
        size = max(1.0, float(np.abs(y).max()), float(np.abs(u).max()))
        assert min(u.min(), y.min()) > -1e-6 * size
        assert np.abs(u * y).max() < 1e-6 * size**2
        np.testing.assert_allclose(coupling @ u, columns.load + y, atol=1e-6 * size)
