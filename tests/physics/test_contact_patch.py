"""Flat patch test: two blocks pressed together through meshes that do not match, solved in statics.

Both blocks are 1 x 0.5 with three layers of cells, E = 1e6, nu = 0, pressed by 0.01: the exact stress is -1e4
everywhere. Mortar contact must find it; one-pass node-on-segment must fail by exactly as much as an independent
static code found (errors of the slave's nodes and range of its nodal pressures, given to two or three digits).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from contactlab.api import Floats
from contactlab.model.bodies.stiffness import cell_stiffness
from contactlab.model.build import build
from contactlab.model.model import Model
from contactlab.parts.registry import default_registry
from contactlab.scene.scene import Scene
from contactlab.testing.surfaces import Chains, rows_of_pair


class Solution(NamedTuple):
    """Largest displacement error of the slave's and of all nodes over 0.01, and pressures over the exact 1e4."""

    slave_error: float
    error: float
    lowest: float
    highest: float


def patch(algorithm: str, top: int, bottom: int, *, swap: bool = False, turn: float = 0.0) -> Model:
    """The blocks with `top` and `bottom` segments at the interface; the upper one is the slave unless swapped."""
    mesh = {"use": "rectangle", "x": [0.0, 1.0]}
    body = {"element": "q1", "material": "m", "rotate": turn}
    return build(
        Scene.from_data(
            {
                "name": "patch",
                "time": {"end": 1.0},
                "integrator": "central-difference",
                "materials": {"m": {"use": "linear-elastic", "young": 1e6, "poisson": 0.0, "density": 1.0}},
                "bodies": {
                    "upper": body | {"mesh": mesh | {"y": [0.5, 1.0], "cells": [top, 3]}},
                    "lower": body | {"mesh": mesh | {"y": [0.0, 0.5], "cells": [bottom, 3]}},
                },
                "contacts": [{"slave": "upper.bottom", "master": "lower.top", "algorithm": algorithm, "swap": swap}],
            }
        ),
        default_registry(),
    )


def stiffness(model: Model) -> Floats:
    size = 2 * len(model.reference)
    out = np.zeros((size, size))
    for body in model.bodies:
        dof = (2 * body.cells[:, :, None] + np.arange(2)).reshape(len(body.cells), -1)
        np.add.at(out, (dof[:, :, None], dof[:, None, :]), cell_stiffness(body, model.reference))
    return out


def contact_rows(model: Model) -> tuple[Floats, Floats]:
    """G (k, 2N) and the length that each condition stands for."""
    assert model.contact is not None
    (pair,) = model.contact.pairs
    pair.update(model.reference, np.zeros((pair.algorithm.memory_size, len(pair.slave.nodes))))
    pair.compute_gaps(model.reference)
    rows = rows_of_pair(pair, Chains(model.reference, pair.slave, pair.master))
    out = np.zeros((rows.count, len(model.reference), 2))
    row = np.repeat(np.arange(rows.count), np.diff(rows.start[: rows.count + 1]))
    np.add.at(out, (row, rows.node[: len(row)]), rows.normal_weight[: len(row)])
    return out.reshape(rows.count, -1), rows.measure[: rows.count]


def pressed(model: Model, turn: float = 0.0) -> Solution:
    """The saddle point of stiffness and contact, all conditions closed, bottom and top moved along the blocks."""
    angle = np.radians(turn)
    along, across = np.array([np.sin(-angle), np.cos(angle)]), np.array([np.cos(angle), np.sin(angle)])
    height, width = model.reference @ along, model.reference @ across
    held = [(np.flatnonzero(np.abs(height) < 1e-9), along, 0.0), (np.flatnonzero(height > 1.0 - 1e-9), along, -0.01)]
    held += [(np.flatnonzero((np.abs(height - h) < 1e-9) & (np.abs(width) < 1e-9)), across, 0.0) for h in (0.0, 1.0)]
    size = 2 * len(model.reference)
    constraints = [(node, direction, value) for nodes, direction, value in held for node in nodes]
    C = np.zeros((len(constraints), size))
    for i, (node, direction, _) in enumerate(constraints):
        C[i, [2 * node, 2 * node + 1]] = direction
    G, measure = contact_rows(model)
    B = np.concatenate([G, C])
    matrix = np.block([[stiffness(model), -B.T], [B, np.zeros((len(B), len(B)))]])
    right = np.concatenate([np.zeros(size + len(G)), [value for *_, value in constraints]])
    solution = np.linalg.solve(matrix, right)
    u, y = solution[:size].reshape(-1, 2), solution[size : size + len(G)]
    error = np.abs(u - np.outer(-0.01 * height, along)).max(axis=1) / 0.01
    assert model.contact is not None
    slave = model.contact.pairs[0].slave.nodes
    pressure = y / measure / 1e4
    return Solution(float(error[slave].max()), float(error.max()), float(pressure.min()), float(pressure.max()))


MESHES = [(4, 5), (4, 7), (3, 10)]


@pytest.mark.parametrize("algorithm", ["mortar-p0", "mortar-p1"])
@pytest.mark.parametrize("swap", [False, True])
@pytest.mark.parametrize(("top", "bottom"), MESHES)
@pytest.mark.parametrize("turn", [0.0, 30.0])
def test_mortar_passes(algorithm: str, swap: bool, top: int, bottom: int, turn: float) -> None:
    found = pressed(patch(algorithm, top, bottom, swap=swap, turn=turn), turn)
    # round-off of a saddle point whose stiffness is 1e6
    assert found.error < 1e-11
    assert found.lowest == pytest.approx(1.0, abs=1e-11)
    assert found.highest == pytest.approx(1.0, abs=1e-11)


@pytest.mark.parametrize(
    ("top", "bottom", "slave_error", "lowest", "highest"),
    [(4, 5, 0.049, 0.898, 1.032), (4, 7, 0.078, 0.840, 1.037), (3, 10, 0.142, 0.742, 0.941)],
)
def test_node_on_segment_fails_as_it_should(
    top: int, bottom: int, slave_error: float, lowest: float, highest: float
) -> None:
    found = pressed(patch("node-on-segment", top, bottom))
    assert found.slave_error == pytest.approx(slave_error, abs=5e-4)
    assert found.lowest == pytest.approx(lowest, abs=5e-4)
    assert found.highest == pytest.approx(highest, abs=5e-4)


@pytest.mark.parametrize(("top", "bottom", "slave_error"), [(4, 5, 0.031), (4, 7, 0.015), (3, 10, 0.0063)])
def test_node_on_segment_fails_less_with_the_finer_side_as_slave(top: int, bottom: int, slave_error: float) -> None:
    found = pressed(patch("node-on-segment", top, bottom, swap=True))
    assert found.slave_error == pytest.approx(slave_error, abs=6e-4)


@pytest.mark.parametrize(("top", "bottom", "error"), [(4, 7, 0.0975), (3, 10, 0.1680)])
def test_the_worst_node_lies_on_the_free_master(top: int, bottom: int, error: float) -> None:
    assert pressed(patch("node-on-segment", top, bottom)).error == pytest.approx(error, abs=5e-5)
