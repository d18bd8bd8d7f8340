"""Contact on quadratic traces: coupling tables, reproduction, equal force with Q1, no saw-tooth."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from contactlab_mortar.mortar import MortarP0, MortarP1
from tiers import some

from contactlab.api import ContactAlgorithm
from contactlab.contact.operator_pair import OperatorPair
from contactlab.model.build import build
from contactlab.parts.registry import default_registry
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene, load_scene
from contactlab.studies.measures import mutual_difference
from contactlab.studies.profile import Profile
from contactlab.testing import contact

COULOMB = {"use": "coulomb", "mu": 0.2}
TABLES = {
    # units of the edge length: rows (vertex, mid, vertex) traces, columns multipliers
    "mortar-p1": np.array([[7 / 48, 1 / 24, -1 / 48], [1 / 8, 5 / 12, 1 / 8], [-1 / 48, 1 / 24, 7 / 48]]),
    "mortar-p0": np.array([[1 / 6, 1 / 48, -1 / 48], [5 / 48, 11 / 24, 5 / 48], [-1 / 48, 1 / 48, 1 / 6]]),
    "mortar-dual": np.array([[11 / 48, -1 / 24, -1 / 48], [1 / 24, 7 / 12, 1 / 24], [-1 / 48, -1 / 24, 11 / 48]]),
}
VERTEX_TABLES = {
    "mortar-p1": np.array([[1 / 6, 0.0], [1 / 3, 1 / 3], [0.0, 1 / 6]]),
    # half an edge each: integrals of the parabolas from 0 to 1/2 and from 1/2 to 1
    "mortar-p0": np.array([[5 / 24, -1 / 24], [1 / 3, 1 / 3], [-1 / 24, 5 / 24]]),
    "mortar-dual": np.array([[1 / 3, -1 / 6], [1 / 3, 1 / 3], [-1 / 6, 1 / 3]]),
}
KINDS = [(name, where) for name in TABLES for where in ("nodes", "vertices")]


def pressed_blocks(algorithm: Any, slave: list[float], cells: tuple[int, int], element: str = "q2") -> Scene:
    """Two flat blocks face to face; `slave` gives the upper block's span."""
    law = {"use": "linear-elastic", "young": 1000.0, "poisson": 0.0, "density": 1e-9}
    body = {"element": element, "material": "m"}
    return Scene.from_data(
        {
            "name": "blocks",
            "time": {"end": 1e-6},
            "integrator": "central-difference",
            "materials": {"m": law},
            "bodies": {
                "upper": {**body, "mesh": {"use": "rectangle", "x": slave, "y": [0.0, 0.5], "cells": [cells[0], 1]}},
                "lower": {
                    **body,
                    "mesh": {"use": "rectangle", "x": [0.0, 1.0], "y": [-0.5, 0.0], "cells": [cells[1], 1]},
                },
            },
            "contacts": [{"slave": "upper.bottom", "master": "lower.top", "algorithm": algorithm}],
            "supports": [{"on": "upper.top", "ux": 0.0, "uy": 0.0}, {"on": "lower.bottom", "ux": 0.0, "uy": 0.0}],
        }
    )


def updated_pair(scene: Scene) -> tuple[OperatorPair, np.ndarray]:
    model = build(scene, default_registry())
    assert model.contact is not None
    pair = model.contact.pairs[0]
    pair.update(model.position, np.zeros((1, len(pair.slave.nodes))))
    pair.compute_gaps(model.position)
    return pair, model.position


def dense(pair: OperatorPair, nodes: np.ndarray, values: np.ndarray, count: int) -> np.ndarray:
    """D or M as a full matrix."""
    matrix = np.zeros((count, pair.slots))
    for p in range(pair.count):
        for i, node in enumerate(nodes[p]):
            for j, k in enumerate(pair.pieces.multiplier[p]):
                matrix[node, k] += values[p, i, j]
    return matrix


@pytest.mark.parametrize("algorithm", TABLES)
@pytest.mark.parametrize("element", ["q2", "q2-lagrange"])
def test_coupling_table_of_one_edge(algorithm: str, element: str) -> None:
    """D of a single quadratic edge over a master of another mesh; exact but for round-off."""
    pair, _ = updated_pair(pressed_blocks(algorithm, [0.0, 1.0], (1, 3), element))
    d = dense(pair, pair.pieces.slave, pair.pieces.D, len(pair.slave.nodes))
    assert d == pytest.approx(TABLES[algorithm], abs=1e-14)
    assert d.sum(axis=1) == pytest.approx([1 / 6, 2 / 3, 1 / 6], abs=1e-14)


@pytest.mark.parametrize("algorithm", VERTEX_TABLES)
def test_multipliers_at_the_ends_of_edges(algorithm: str) -> None:
    """D of one edge, and T: hats over whole edges; mid nodes have neither multiplier nor length."""
    spec = {"use": algorithm, "multipliers": "vertices"}
    pair, _ = updated_pair(pressed_blocks(spec, [0.0, 1.0], (1, 3)))
    d = dense(pair, pair.pieces.slave, pair.pieces.D, len(pair.slave.nodes))
    ends = pair.slave.edges[0, :2]
    assert d[:, ends][[*ends, pair.slave.edges[0, 2]]] == pytest.approx(VERTEX_TABLES[algorithm][[0, 2, 1]], abs=1e-14)
    assert pair.cover[ends] == pytest.approx([0.5, 0.5], abs=1e-14)
    middle = pair.between[0]
    assert pair.coupling.full[ends] == pytest.approx([0.5, 0.5], abs=1e-14)
    assert len(pair.coupling.order) == 2
    assert pair.coupling.owner[middle].tolist() == [-1]
    assert pair.coupling.full[middle].tolist() == [0.0]


@pytest.mark.parametrize("algorithm", [MortarP0(multipliers="vertices"), MortarP1(multipliers="vertices")], ids=repr)
def test_multipliers_at_the_ends_of_edges_pass_all_checks(algorithm: ContactAlgorithm) -> None:
    """What every algorithm must, the patch test on quadratic edges included."""
    for check in contact.CHECKS:
        check(algorithm)


@pytest.mark.parametrize(("algorithm", "multipliers"), KINDS)
@pytest.mark.parametrize("span", [[0.0, 1.0], [0.13, 1.31]], ids=["full cover", "partial cover"])
def test_rows_reproduce_constants_and_lines(algorithm: str, multipliers: str, span: list[float]) -> None:
    """Both sides weigh constants alike and see the same linear function, also on partial cover.

    The tolerance is the cut of the rows, 1e-13 per weight.
    """
    pair, _ = updated_pair(pressed_blocks({"use": algorithm, "multipliers": multipliers}, span, (3, 4)))
    weights = pair.weights()
    for k in pair.coupling.order:
        sums = []
        for (start, end, weight), x in ((weights.slave, pair.at.slave), (weights.master, pair.at.master)):
            w = weight[k, : end[k] - start[k]]
            sums.append((w.sum(), w @ x[start[k] : end[k], 0]))
        assert sums[0] == pytest.approx(sums[1], abs=1e-11)
        assert sums[0][0] == pytest.approx(1.0, abs=1e-11)


@pytest.mark.parametrize(("algorithm", "multipliers"), KINDS)
def test_forces_cancel_on_partial_cover(algorithm: str, multipliers: str) -> None:
    """Any multipliers push both bodies with opposite resultants and no moment on a flat interface."""
    scene = pressed_blocks({"use": algorithm, "multipliers": multipliers}, [0.13, 1.31], (3, 4))
    scene = scene.with_({"bodies.upper.velocity": [0.0, -1e5]})
    model = build(scene, default_registry())
    step = model.bound_integrator().step
    step(1e-9)
    force, x = model.state["contact_force"], model.position
    upper = np.arange(len(x)) < model.bodies[0].count
    assert force[upper].any()
    scale = np.abs(force).sum()
    assert np.abs(force.sum(axis=0)).max() < 1e-12 * scale
    assert abs(np.sum(x[:, 0] * force[:, 1] - x[:, 1] * force[:, 0])) < 1e-11 * scale


@pytest.mark.parametrize("algorithm", ["mortar-p0", "mortar-p1"])
def test_deep_disc_agrees_with_bilinear_elements(algorithm: str) -> None:
    """Equal node count, level 1: the reaction within 0.5 % of Q1's, and no saw-tooth in the recovered pressure."""
    half = {"bodies.disc.mesh.cells": [12, 3], "bodies.block.mesh.cells": [18, 3]}
    scene = load_scene("disc-on-block").with_({"contacts.0.algorithm": algorithm, "level": 1, "record.frames": 2})
    quadratic = {"bodies.disc.element": "q2-lagrange", "bodies.block.element": "q2-lagrange", **half}
    bilinear = simulate(scene).summary["reactions"]["disc.top"][1]
    results = simulate(scene.with_(quadratic))
    assert results.status == "finished", results.reason
    assert results.summary["reactions"]["disc.top"][1] == pytest.approx(bilinear, rel=5e-3)
    assert saw_tooth(results.contact["contacts.0"].last) < 0.02


@pytest.mark.parametrize("swap", some([False, True], [False]), ids=["disc slave", "block slave"])
@pytest.mark.parametrize("algorithm", ["mortar-p0", "mortar-p1"])
def test_shear_that_sticks_has_no_saw(algorithm: str, swap: bool) -> None:
    """Shear under friction 0.2 against nine-node elements on the same mesh.

    Both elements have the same traces, so that only the bulk is another one: 2 % in L2 is what that makes of
    pressures and leaves room for. With multipliers at mid nodes what sticks keeps the errors of the moving edge of
    contact: 4 to 14 % apart, and a saw of 6 to 21 % of the largest shear where smooth shear has 2 %.
    """
    scene = load_scene("disc-on-block").with_(
        {
            "contacts.0.algorithm": algorithm, "contacts.0.swap": swap, "contacts.0.friction": COULOMB,
            "integrator": {"use": "newton", "steps": 10}, "record.frames": 1,
        }
    )  # fmt: skip
    curves = []
    for element in ("q2", "q2-lagrange"):
        results = simulate(scene.with_({"bodies.disc.element": element, "bodies.block.element": element}))
        assert results.status == "finished", results.reason
        curves.append(results.contact["contacts.0"].last)
    own, other = (Profile.of_curve(curve, "shear") for curve in curves)
    assert mutual_difference(own, other) < 0.02
    assert saw_tooth(curves[0], "shear") < 0.03


@pytest.mark.parametrize("element", ["q2", "q2-lagrange"])
@pytest.mark.parametrize("swap", [False, True], ids=["upper slave", "lower slave"])
def test_nodes_on_segments_report_an_even_pressure(element: str, swap: bool) -> None:
    """Matching blocks pressed together by 1 %: 10 MPa at every node, not 2/3 of it at the ends of edges, 4/3 between.

    Without lateral strain the exact answer is in the space of the elements; 1e-9 is what Newton leaves.
    """
    changes = {
        "integrator": {"use": "newton", "steps": 1}, "time": {}, "contacts.0.swap": swap,
        "supports.0.uy": -0.01, "materials.m.density": 1.0,
    }  # fmt: skip
    scene = pressed_blocks("node-on-segment", [0.0, 1.0], (3, 3), element).with_(changes)
    results = simulate(scene)
    assert results.status == "finished", results.reason
    curve = results.contact["contacts.0"].last
    assert curve.pressure == pytest.approx(np.full(7, 10.0), rel=1e-9)
    assert curve.nodal_pressure == pytest.approx(np.full(7, 10.0), rel=1e-9)


def saw_tooth(curve, column: str = "pressure") -> float:  # type: ignore[no-untyped-def]
    """Mean alternation between corners and mid nodes over the largest value, inside the contact.

    A sixteenth of the fourth difference is one for (1, -1, 1, -1 ...) and of fourth order for smooth curves;
    with its sign alternated, what is smooth cancels in the mean.
    """
    p = getattr(curve, column)
    p = np.abs(p)  # shear changes its sign in the middle, where the alternation of its size does not
    fourth = (p[:-4] - 4 * p[1:-3] + 6 * p[2:-2] - 4 * p[3:-1] + p[4:]) / 16.0
    inner = np.abs(curve.x[2:-2]) < 0.4
    return float(abs((fourth * (-1.0) ** np.arange(len(fourth)))[inner].mean()) / p.max())
