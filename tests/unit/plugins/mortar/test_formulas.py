"""Contact between segments by formulas: against differences, and compiled against plain ones.

They run as plain Python here, but for those of the shipped class that are compiled anyway.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest
from contactlab_mortar.mortar import MortarDual, MortarP0, MortarP1
from dense_pieces import AGREED, SURFACES, along, central, derivatives_of, drawn_move, fold, pieces_of, summed, view_of

from contactlab.api import Floats, GapGradients, SegmentContact, formula
from contactlab.formulas import segments

SIDES = ("nodes", "vertices")


@dataclass(frozen=True)
class Leaning(MortarP1):
    """Hats with a share of the other one."""

    lean: float = 0.0

    @formula
    def basis(xi: Any, p: Any) -> Any:
        """By a field of the part."""
        return 1.0 - xi + p.lean * xi, xi + p.lean * (1.0 - xi)


FOLDED = {**SURFACES, "fold": fold()}


@pytest.fixture(autouse=True)
def in_python(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CONTACTLAB_PYTHON", "1")
    monkeypatch.setattr(segments, "_of_class", cache(segments._Kernels))


def dense_derivatives(algorithm: Any, name: str) -> tuple[Floats, ...]:
    """dD, dM and dT by coordinates and entries of the dense matrices."""
    found, _, _, view = derivatives_of(algorithm, FOLDED[name])
    m, r, n = len(view.slave.nodes), len(view.master.nodes), found.count
    out = []
    for nodes, values, size in (
        (found.slave, found.dD, m), (found.master, found.dM, r), (found.multiplier, found.dT, m)
    ):  # fmt: skip
        dense = np.zeros((2 * (m + r), size, m))
        np.add.at(dense, (found.moved[:n, None, None], nodes[:n, :, None], found.multiplier[:n, None, :]), values[:n])
        out.append(dense)
    return tuple(out)


@pytest.mark.parametrize("vertices", SIDES)
@pytest.mark.parametrize("kind", [MortarP0, MortarP1, MortarDual])
@pytest.mark.parametrize("name", FOLDED)
def test_derivatives_are_central_differences(name: str, kind: Any, vertices: str) -> None:
    """Of D, M and T, and of the normals, along a random move of all nodes; also of a basis that asks for the cover."""
    at, algorithm = FOLDED[name], kind(vertices)
    found, pieces, _, view = derivatives_of(algorithm, at)
    move, n, k, expected = drawn_move(at), found.count, len(pieces.normal), central(algorithm, at, drawn_move(at))
    step = along(view, at, found.moved[:n], move)[:, None, None]
    sides = (found.slave, found.dD, len(at.slave.nodes)), (found.master, found.dM, len(at.master.nodes))
    for (nodes, values, size), wanted in zip((*sides, (found.multiplier, found.dT, k)), expected[:3], strict=True):
        change = np.zeros((size, k))
        np.add.at(change, (nodes[:n, :, None], found.multiplier[:n, None, :]), step * values[:n])
        # flanks that count in part bend: differences of them are worse
        np.testing.assert_allclose(change, wanted, atol=1e-7 if name == "steep" else AGREED)
    change, n = np.zeros_like(pieces.normal), found.normal_count
    step = along(view, at, found.normal_moved[:n], move)[:, None]
    np.add.at(change, found.normal_of[:n], step * found.dnormal[:n])
    # directions at ends turn by a hundred per segment where they begin to
    np.testing.assert_allclose(change, expected[3], atol=2e-6 * max(1.0, np.abs(expected[3]).max()))


@pytest.mark.parametrize("name", ["curved", "partly covered", "quadratic"])
def test_biorthogonal_multipliers_have_a_diagonal_t(name: str) -> None:
    """Whatever is covered of a segment; its sums are those of hats: the length that is covered."""
    view = view_of(FOLDED[name])
    T, hats = (summed(*pieces_of(algorithm, view), view)[2] for algorithm in (MortarDual("nodes"), MortarP1("nodes")))
    np.testing.assert_allclose(T, np.diag(np.diag(T)), atol=1e-15)
    np.testing.assert_allclose(np.diag(T), hats.sum(axis=1), atol=1e-15)


@pytest.mark.parametrize("vertices", SIDES)
@pytest.mark.parametrize("algorithm", [MortarP0, MortarP1, MortarDual])
@pytest.mark.parametrize("name", ["partly covered", "quadratic"])
def test_gradients_are_those_of_the_derivatives(name: str, algorithm: Any, vertices: str) -> None:
    """Of D^T x - M^T y - T^T r at fixed positions x and y and separations r, two multipliers being one."""
    view = view_of(FOLDED[name])
    pieces, count = pieces_of(algorithm(vertices), view)
    pieces.averaged, k = True, len(pieces.normal)  # what directions are at ends does not matter to separations
    owner, r = np.arange(k, dtype=np.int32), np.random.default_rng(5).normal(size=(k, 2))
    owner[3], owner[5] = 4, -1  # merged and dropped: the separations that T weighs are those of owners
    found = GapGradients.allocate(count, 2, algorithm.gradient_nodes, 4 * k)
    assert algorithm(vertices).gradients(view, pieces, count, owner, r, found)
    seen = np.where(owner[:, None] >= 0, r[owner], 0.0)
    dD, dM, dT = dense_derivatives(algorithm(vertices), name)
    wanted = np.einsum("zik,id->zkd", dD, view.at.slave) - np.einsum("zik,id->zkd", dM, view.at.master)
    wanted -= np.einsum("zik,id->zkd", dT, seen)
    got = np.zeros_like(wanted)
    for p in range(count):
        for v, node in enumerate(found.node[p]):
            for j in range(2):
                if node >= 0:
                    got[2 * node : 2 * node + 2, found.multiplier[p, j]] += found.value[p, j, :, v].T
    np.testing.assert_allclose(got, wanted, atol=1e-13)


def test_gradients_are_not_given_where_normals_are_not_the_averaged_ones() -> None:
    view = view_of(fold())
    pieces, count = pieces_of(MortarP1(), view)
    k = len(pieces.normal)
    found = GapGradients.allocate(count, 2, 12, 4 * k)
    assert not MortarP1().gradients(view, pieces, count, np.arange(k, dtype=np.int32), np.zeros((k, 2)), found)


def test_formulas_know_the_fields_of_their_part() -> None:
    view = view_of(FOLDED["curved"])
    hats, more = (summed(*pieces_of(algorithm, view), view)[2] for algorithm in (MortarP1(), Leaning(lean=0.5)))
    np.testing.assert_allclose(more.sum(), 1.5 * hats.sum(), rtol=1e-14)


def test_compiled_formulas_give_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    """Values and derivatives to round-off."""
    view = view_of(FOLDED["partly covered"])
    plain, (pieces, count) = dense_derivatives(MortarDual(), "partly covered"), pieces_of(MortarDual(), view)
    monkeypatch.delenv("CONTACTLAB_PYTHON")
    monkeypatch.setattr(segments, "_of_class", cache(segments._Kernels))
    found, number = pieces_of(MortarDual(), view)
    assert number == count
    np.testing.assert_allclose(found.M[:count], pieces.M[:count], atol=1e-15)
    for one, other in zip(dense_derivatives(MortarDual(), "partly covered"), plain, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-13)


def test_a_formula_that_asks_for_what_is_not_known_is_refused() -> None:
    with pytest.raises(TypeError, match=r"Wrong.basis: got the argument eta, allowed: covered, p, xi"):

        class Wrong(SegmentContact):
            @formula
            def basis(eta: Any) -> Any:
                """Not of this side."""
                return eta
