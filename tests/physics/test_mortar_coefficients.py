"""Coefficients D and M of mortar contact against closed forms (docs/theory/mortar-operators.md)."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from contactlab_mortar.mortar import MortarP0, MortarP1

from contactlab.api import ContactAlgorithm, Floats
from contactlab.contact.operator_pair import OperatorPair
from contactlab.testing.surfaces import Chains, chains, pair_of, stations

P0, P1 = MortarP0(), MortarP1()
BOTH = pytest.mark.parametrize("algorithm", [P0, P1], ids=["P0", "P1"])
ROUND_OFF = 1e-12  # of sums of a dozen products of order one


def line(slave: Floats, master: Floats) -> Chains:
    """Flat surfaces with nodes at these abscissae, left to right."""
    return chains(*(np.stack([x, np.zeros_like(x)], axis=1) for x in (slave, master)))


def operators(pair: OperatorPair, at: Chains) -> tuple[Floats, Floats, Floats]:
    """D (slave nodes, multipliers), M (master nodes left to right, multipliers) and T, summed over the pieces."""
    p, n = pair.pieces, pair.count
    k = pair.slots
    D, M, T = np.zeros((len(at.slave.nodes), k)), np.zeros((len(at.master.nodes), k)), np.zeros((k, k))
    np.add.at(D, (p.slave[:n, :, None], p.multiplier[:n, None, :]), p.D[:n])
    np.add.at(M, (p.master[:n, :, None], p.multiplier[:n, None, :]), p.M[:n])
    np.add.at(T, (p.multiplier[:n, :, None], p.multiplier[:n, None, :]), p.T[:n])
    return D, M[::-1], T


def assembled(algorithm: ContactAlgorithm, slave: Floats, master: Floats) -> tuple[Floats, Floats, Floats]:
    at = line(slave, master)
    return operators(pair_of(algorithm, at)[0], at)


# --- D on full cover ----------------------------------------------------------------------------


def closed_form_d(x: Floats, own: float, shared: float) -> Floats:
    """D of the table: `own` of each segment at a node itself, `shared` for its neighbour."""
    h = np.diff(x)
    d = np.diag(own * (np.append(h, 0.0) + np.append(0.0, h)))
    return d + np.diag(shared * h, 1) + np.diag(shared * h, -1)


@pytest.mark.parametrize(("algorithm", "own", "shared"), [(P0, 3 / 8, 1 / 8), (P1, 1 / 3, 1 / 6)], ids=["P0", "P1"])
@pytest.mark.parametrize("x", [np.linspace(0.0, 3.0, 7), *(stations(0.0, 3.0, 9, seed=s) for s in range(4))])
def test_table_of_d(algorithm: ContactAlgorithm, own: float, shared: float, x: Floats) -> None:
    D, _, T = assembled(algorithm, x, np.linspace(-0.5, 3.5, 6))
    np.testing.assert_allclose(D, closed_form_d(x, own, shared), atol=ROUND_OFF, rtol=0.0)
    np.testing.assert_allclose(D, D.T, atol=ROUND_OFF, rtol=0.0)
    np.testing.assert_allclose(T, D, atol=0.0, rtol=0.0)  # linear traces under full cover


@BOTH
def test_row_sums_are_tributary_lengths(algorithm: ContactAlgorithm) -> None:
    x = stations(0.0, 3.0, 9, seed=5)
    D, *_ = assembled(algorithm, x, np.array([-1.0, 1.2, 4.0]))
    h = np.diff(x)
    np.testing.assert_allclose(D.sum(axis=1), 0.5 * (np.append(h, 0.0) + np.append(0.0, h)), atol=ROUND_OFF, rtol=0.0)


# --- M ------------------------------------------------------------------------------------------


def hat(x: Floats, k: int, s: Floats) -> Floats:
    """The linear hat of node k of the mesh x, zero outside the mesh."""
    return np.where((s >= x[0]) & (s <= x[-1]), np.interp(s, x, np.eye(len(x))[k]), 0.0)


def hat_primitive(x: Floats, k: int, s: Floats) -> Floats:
    """Integral of that hat from the left end to s, in closed form on each segment."""
    total = np.zeros_like(s)
    for a, b, rises in ((k - 1, k, True), (k, k + 1, False)):
        if a >= 0 and b < len(x):
            h = x[b] - x[a]
            t = np.clip((s - x[a]) / h, 0.0, 1.0)
            total = total + h * (0.5 * t**2 if rises else t - 0.5 * t**2)
    return total


def exact_m(linear: bool, slave: Floats, master: Floats) -> Floats:
    """M by primitives (P0), or by the product of linear functions between merged break points (P1)."""
    out = np.zeros((len(master), len(slave)))
    cells = np.concatenate([slave[:1], 0.5 * (slave[1:] + slave[:-1]), slave[-1:]])
    breaks = np.unique(np.concatenate([slave, master]))
    breaks = breaks[(breaks >= max(slave[0], master[0])) & (breaks <= min(slave[-1], master[-1]))]
    a, b = breaks[:-1], breaks[1:]
    for m in range(len(master)):
        if not linear:
            out[m] = np.diff(hat_primitive(master, m, np.clip(cells, master[0], master[-1])))
            continue
        for k in range(len(slave)):
            fa, fb, ga, gb = hat(master, m, a), hat(master, m, b), hat(slave, k, a), hat(slave, k, b)
            out[m, k] = ((b - a) / 6 * (2 * fa * ga + 2 * fb * gb + fa * gb + fb * ga)).sum()
    return out


MESHES = {
    "uneven": (stations(0.0, 3.0, 9, seed=1), stations(0.0, 3.0, 7, seed=2)),
    "much finer master": (stations(0.0, 3.0, 4, seed=3), stations(0.0, 3.0, 31, seed=4)),
    "much coarser master": (stations(0.0, 3.0, 31, seed=5), stations(0.0, 3.0, 4, seed=6)),
    "matching": (np.linspace(0.0, 3.0, 8), np.linspace(0.0, 3.0, 8)),
    "wide master": (stations(0.5, 2.5, 9, seed=7), stations(-1.0, 4.0, 9, seed=8)),
    "narrow master": (stations(0.0, 3.0, 9, seed=9), stations(0.71, 2.13, 6, seed=10)),
    "shifted": (stations(0.0, 3.0, 9, seed=11), stations(1.3, 4.2, 8, seed=12)),
}


@BOTH
@pytest.mark.parametrize("mesh", MESHES)
def test_m_is_the_exact_integral(algorithm: ContactAlgorithm, mesh: str) -> None:
    slave, master = MESHES[mesh]
    _, M, _ = assembled(algorithm, slave, master)
    np.testing.assert_allclose(M, exact_m(algorithm is P1, slave, master), atol=ROUND_OFF, rtol=0.0)


@pytest.mark.parametrize(
    ("algorithm", "shift", "weights"),
    [
        (P0, 1 / 2, [1 / 2, 1 / 2]),
        (P1, 1 / 2, [1 / 48, 23 / 48, 23 / 48, 1 / 48]),
        (P0, 1 / 4, [9 / 32, 22 / 32, 1 / 32]),
        (P1, 1 / 4, [1 / 384, 121 / 384, 235 / 384, 27 / 384]),
    ],
)
def test_shifted_equal_meshes_give_b_splines(algorithm: ContactAlgorithm, shift: float, weights: list[float]) -> None:
    """Convolutions of hats with hats or boxes are B-splines: cubic or quadratic ones at the shifted nodes."""
    h = 0.25
    _, M, _ = assembled(algorithm, h * np.arange(9), h * (np.arange(-3, 12) + shift))
    column = M[:, 4] / h
    found = column[np.abs(column) > 1e-14]
    # three and four master nodes push on a slave node, as in the paper's figure 5 (two where P0 meets its knots)
    np.testing.assert_allclose(found, weights, atol=ROUND_OFF, rtol=0.0)


# --- partial cover ------------------------------------------------------------------------------


def exact_d(linear: bool, slave: Floats, low: float, high: float) -> Floats:
    """D over low < s < high by fine Gauss rules between all break points."""
    middles = 0.5 * (slave[1:] + slave[:-1])
    breaks = np.unique(np.clip(np.concatenate([slave, middles, [low, high]]), low, high))
    points, weights = np.polynomial.legendre.leggauss(4)
    out = np.zeros((len(slave), len(slave)))
    cells = np.concatenate([slave[:1], middles, slave[-1:]])
    for a, b in pairwise(breaks):
        s = 0.5 * (a + b) + 0.5 * (b - a) * points
        for k in range(len(slave)):
            psi = hat(slave, k, s) if linear else ((s > cells[k]) & (s < cells[k + 1])).astype(float)
            for i in range(len(slave)):
                out[i, k] += 0.5 * (b - a) * weights @ (psi * hat(slave, i, s))
    return out


@BOTH
@pytest.mark.parametrize("mesh", ["narrow master", "shifted"])
def test_d_is_integrated_over_the_covered_part(algorithm: ContactAlgorithm, mesh: str) -> None:
    slave, master = MESHES[mesh]
    low, high = max(slave[0], master[0]), min(slave[-1], master[-1])
    D, *_ = assembled(algorithm, slave, master)
    np.testing.assert_allclose(D, exact_d(algorithm is P1, slave, low, high), atol=ROUND_OFF, rtol=0.0)


@BOTH
@pytest.mark.parametrize("mesh", MESHES)
def test_what_the_slave_takes_the_master_gives(algorithm: ContactAlgorithm, mesh: str) -> None:
    """Column sums of D and M agree: no multiplier leaves a resultant."""
    D, M, _ = assembled(algorithm, *MESHES[mesh])
    np.testing.assert_allclose(D.sum(axis=0), M.sum(axis=0), atol=ROUND_OFF, rtol=0.0)


@BOTH
@pytest.mark.parametrize("seed", range(5))
def test_curved_surfaces_keep_the_column_sums(algorithm: ContactAlgorithm, seed: int) -> None:
    rng = np.random.default_rng(seed)
    s, m = stations(-0.8, 0.8, 11, seed=seed), stations(-0.7, 0.9, 8, seed=seed + 50)
    slave = np.stack([s, 0.4 * s**2 + 0.01 * rng.uniform(size=len(s))], axis=1)
    at = chains(slave, np.stack([m, 0.1 * m**2 - 0.03 * np.cos(3 * m)], axis=1))
    D, M, _ = operators(pair_of(algorithm, at)[0], at)
    assert D.sum() > 1.0
    np.testing.assert_allclose(D.sum(axis=0), M.sum(axis=0), atol=ROUND_OFF, rtol=0.0)
