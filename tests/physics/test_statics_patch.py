"""Patch tests of whole static runs: flat, inclined, with traction and partial cover."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import contactlab
from contactlab.api import Floats
from contactlab.results.results import Results
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene

YOUNG, DEPTH, PRESSURE = 1e6, 0.01, 1e4
MORTAR = pytest.mark.parametrize("algorithm", ["mortar-p0", "mortar-p1", "mortar-dual"])
SWAP = pytest.mark.parametrize("swap", [False, True], ids=["upper-slave", "lower-slave"])


def blocks(
    upper: dict[str, Any],
    lower: dict[str, Any],
    *,
    algorithm: str,
    swap: bool = False,
    depth: float = DEPTH,
    **extra: Any,
) -> Scene:
    """Two blocks of nu = 0 on top of each other, the upper one pushed down by `depth`."""
    body = {"element": extra.pop("element", "q1"), "material": "m"}
    return Scene.from_data(
        {
            "name": "patch",
            "integrator": {"use": "newton", "steps": 1},
            "materials": {"m": {"use": "linear-elastic", "young": YOUNG, "poisson": 0.0, "density": 1.0}},
            "bodies": {"upper": body | upper, "lower": body | lower},
            "contacts": [{"slave": "upper.bottom", "master": "lower.top", "algorithm": algorithm, "swap": swap}],
            "supports": [
                {"on": "lower.bottom", "uy": 0.0},
                {"on": "upper.top", "uy": -depth},
                {"on": "lower.pin", "ux": 0.0},
                {"on": "upper.pin", "ux": 0.0},
            ],
            "record": {"recorders": []},
        }
        | extra
    )


def flat(top: int, bottom: int, **options: Any) -> Scene:
    """`top` segments over `bottom` ones, three layers of cells each, held sideways at one cell's height."""
    mesh, sixth = {"use": "rectangle", "x": [0.0, 1.0]}, 1.0 / 6.0
    return blocks(
        {
            "mesh": mesh | {"y": [0.5, 1.0], "cells": [top, 3]},
            "sets": {"pin": {"of": "left", "y": [1.0 - sixth, 1.0]}},
        },
        {"mesh": mesh | {"y": [0.0, 0.5], "cells": [bottom, 3]}, "sets": {"pin": {"of": "left", "y": [0.0, sixth]}}},
        **options,
    )


def errors(results: Results, exact: Floats, scale: float) -> Floats:
    """Largest displacement error of each node over `scale`."""
    return np.asarray(np.abs(results.displacement - exact).max(axis=1) / scale)


def squeezed(results: Results, depth: float) -> Floats:
    """The exact displacement of blocks of total height 1."""
    return np.stack([np.zeros(len(results.nodes)), -depth * results.nodes[:, 1]], axis=1)


FURTHER = (4, 5), (3, 10)
"""Numbers of segments of both sides in the full tier."""


def stress_error(results: Results, exact: Floats) -> float:
    stress = np.concatenate([values.reshape(-1, 4) for values in results.stress.values()])
    return float(np.abs(stress - exact).max() / np.abs(exact).max())


@MORTAR
@SWAP
@pytest.mark.parametrize("element", ["q1", "q2", "q2-lagrange"])
@pytest.mark.parametrize(
    "cells", [(4, 7), (1, 10), *(pytest.param(n, marks=pytest.mark.full) for n in FURTHER)], ids=str
)
def test_flat_patch(algorithm: str, swap: bool, element: str, cells: tuple[int, int]) -> None:
    results = simulate(flat(*cells, algorithm=algorithm, swap=swap, element=element))
    assert results.status == "finished"
    assert errors(results, squeezed(results, DEPTH), DEPTH).max() < 1e-11
    assert stress_error(results, np.array([0.0, -PRESSURE, 0.0, 0.0])) < 1e-11
    assert results.summary["iterations"] <= 3


@SWAP
@pytest.mark.parametrize("element", ["q1", "q2"])
def test_gauss_points_pass_an_even_pressure_where_no_kink_is_within_a_segment(element: str, swap: bool) -> None:
    """Nodes of the coarser side lie on those of the finer one, which is the slave: sums are the integrals."""
    cells = (3, 6) if swap else (6, 3)
    results = simulate(flat(*cells, algorithm="gauss-point", swap=swap, element=element))
    assert errors(results, squeezed(results, DEPTH), DEPTH).max() < 1e-11


@SWAP
def test_what_gauss_points_miss_of_an_even_pressure_falls_with_the_segments(swap: bool) -> None:
    """Below 1 % of the load at 4 over 5 cells (one-pass nodes: 3 to 5 %), and at least by 1.8 where cells halve."""
    found = []
    for factor in (1, 2, 4):
        depth = 1e-6  # surfaces stay straight
        results = simulate(flat(4 * factor, 5 * factor, algorithm="gauss-point", swap=swap, depth=depth))
        found.append(errors(results, squeezed(results, depth), depth).max())
    assert found[0] < 0.01
    assert found[0] > 1.8 * found[1] > 1.8**2 * found[2]


# largest errors of slave and of all nodes [%], lowest and highest nodal pressure over the exact one, of an independent
# static code with the same one-pass conditions on undeformed blocks
NODE_ON_SEGMENT = [
    (4, 5, False, 4.9, None, 0.898, 1.032),
    (4, 7, False, 7.8, 9.75, 0.840, 1.037),
    (3, 10, False, 14.2, 16.80, 0.742, 0.941),
    (4, 5, True, 3.1, None, None, None),
    (4, 7, True, 1.5, None, None, None),
    (3, 10, True, 0.63, None, None, None),
]


@pytest.mark.parametrize(("top", "bottom", "swap", "slave", "every", "lowest", "highest"), NODE_ON_SEGMENT)
def test_node_on_segment_fails_as_published(
    top: int, bottom: int, swap: bool, slave: float, every: float | None, lowest: float | None, highest: float | None
) -> None:
    """Within 0.1 point. So little pressure that the surfaces stay straight, as the reference takes them."""
    depth = 1e-6
    results = simulate(flat(top, bottom, algorithm="node-on-segment", swap=swap, depth=depth))
    found = 100.0 * errors(results, squeezed(results, depth), depth)
    count = 4 * (top + 1)
    interface = np.isclose(results.nodes[:, 1], 0.5) & ((np.arange(len(found)) < count) != swap)
    assert found[interface].max() == pytest.approx(slave, abs=0.1)
    pressure = results.contact["contacts.0"].last.nodal_pressure / (YOUNG * depth)
    if every is not None:
        assert found.max() == pytest.approx(every, abs=0.1)
    if lowest is not None and highest is not None:
        assert pressure.min() == pytest.approx(lowest, abs=1e-3)
        assert pressure.max() == pytest.approx(highest, abs=1e-3)


def turned(vectors: Floats, degrees: float) -> Floats:
    """Vectors (N, 2) turned counter-clockwise."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return vectors @ np.array([[c, s], [-s, c]])


def inclined(top: int, bottom: int, turn: float, **options: Any) -> Scene:
    """The flat patch turned as a whole; top and bottom are moved as in the exact solution, the sides are free."""
    mesh = {"use": "rectangle", "x": [0.0, 1.0]}
    ux, uy = (float(value) for value in turned(np.array([[0.0, -DEPTH]]), turn)[0])
    return blocks(
        {"rotate": turn, "mesh": mesh | {"y": [0.5, 1.0], "cells": [top, 3]}},
        {"rotate": turn, "mesh": mesh | {"y": [0.0, 0.5], "cells": [bottom, 3]}},
        supports=[{"on": "lower.bottom", "ux": 0.0, "uy": 0.0}, {"on": "upper.top", "ux": ux, "uy": uy}],
        **options,
    )


@MORTAR
@SWAP
@pytest.mark.parametrize("element", ["q1", "q2-lagrange"])
def test_inclined_patch(algorithm: str, swap: bool, element: str) -> None:
    """Uniform stress at 30 degrees, and the result of the flat patch turned (both to 1e-10)."""
    options = {"algorithm": algorithm, "swap": swap, "element": element}
    flat_one, results = (simulate(inclined(4, 7, turn, **options)) for turn in (0.0, 30.0))
    exact = turned(squeezed(flat_one, DEPTH), 30.0)
    assert errors(results, exact, DEPTH).max() < 1e-10
    assert errors(results, turned(flat_one.displacement, 30.0), DEPTH).max() < 1e-10


def test_inclined_node_on_segment_is_the_flat_one_turned() -> None:
    """It fails the patch test, but alike in every direction."""
    flat_one, results = (simulate(inclined(4, 7, turn, algorithm="node-on-segment")) for turn in (0.0, 30.0))
    assert errors(results, turned(flat_one.displacement, 30.0), DEPTH).max() < 1e-10
    assert errors(results, turned(squeezed(flat_one, DEPTH), 30.0), DEPTH).max() > 0.01


@MORTAR
@SWAP
@pytest.mark.parametrize("element", ["q1", "q2", "q2-lagrange"])
def test_partial_cover(algorithm: str, swap: bool, element: str) -> None:
    """A block of 0.6 on one of 1, the same pressure on all that looks upwards: uniform stress (Taylor-Papadopoulos)."""
    exposed = {"left_of_it": {"of": "top", "x": [0.0, 0.2]}, "right_of_it": {"of": "top", "x": [0.8, 1.0]}}
    scene = blocks(
        {
            "mesh": {"use": "rectangle", "x": [0.2, 0.8], "y": [0.5, 1.0], "cells": [4, 3]},
            "sets": {"pin": {"of": "left", "y": [0.5 + 1.0 / 3.0, 1.0]}},
        },
        {
            "mesh": {"use": "rectangle", "x": [0.0, 1.0], "y": [0.0, 0.5], "cells": [15, 3]},
            "sets": exposed | {"pin": {"of": "left", "y": [0.0, 1.0 / 6.0]}},
        },
        algorithm=algorithm,
        swap=swap,
        element=element,
        supports=[
            {"on": "lower.bottom", "uy": 0.0},
            {"on": "lower.pin", "ux": 0.0},
            {"on": "upper.pin", "ux": 0.0},
        ],
        loads=[{"on": on, "pressure": PRESSURE} for on in ("upper.top", "lower.left_of_it", "lower.right_of_it")],
    )
    results = simulate(scene)
    assert results.status == "finished"
    assert errors(results, squeezed(results, DEPTH), DEPTH).max() < 1e-10
    assert stress_error(results, np.array([0.0, -PRESSURE, 0.0, 0.0])) < 1e-10


def kinked(turn: float, left: int, right: int, far: float) -> Any:
    """Cells between a roof that turns by `turn` degrees at x = 0 and the line y = `far`."""
    x = np.concatenate([np.linspace(-1.0, 0.0, left + 1), np.linspace(0.0, 1.0, right + 1)[1:]])
    roof = -np.tan(np.radians(0.5 * turn)) * np.abs(x)
    share = np.linspace(0.0, 1.0, 4)[:, None]
    y = (1.0 - share) * roof + share * far
    number = np.arange(y.size).reshape(y.shape)
    cells = np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], axis=-1).reshape(-1, 4)
    joint = number < number[1, 0]
    outer = ~joint | np.isclose(np.abs(x), 1.0)
    sets = {"joint": joint.ravel(), "outer": outer.ravel()}
    return contactlab.mesh(np.stack([np.broadcast_to(x, y.shape), y], axis=-1).reshape(-1, 2), cells, sets)


@MORTAR
@pytest.mark.parametrize("turn", [25.0, 53.0, -40.0])
def test_a_kink_keeps_a_uniform_pressure(algorithm: str, turn: float) -> None:
    """Two bodies of one material that meet in a kink, under 5 MPa from all sides: so is the pressure at every node.

    Strains are 1e-5, and pressures follow the turned surface to that. With one normal for both flanks the pressure at
    the kink is low by 1 - cos(turn / 2) at least.
    """
    scene = Scene.from_data({
        "name": "kink", "integrator": {"use": "newton"}, "record": {"recorders": []},
        "materials": {"m": {"use": "neo-hookean", "young": 5e5, "poisson": 0.25, "density": 1.0}},
        "bodies": {
            "up": {"element": "q1", "material": "m", "mesh": kinked(turn, 4, 5, 1.0)},
            "low": {"element": "q1", "material": "m", "mesh": kinked(turn, 5, 3, -1.5)},
        },
        "contacts": [{"slave": "up.joint", "master": "low.joint", "algorithm": algorithm}],
        "loads": [{"on": f"{body}.outer", "pressure": 5.0} for body in ("up", "low")],
        "effects": [{"use": "spring", "on": "low.outer", "stiffness": [1.0, 1.0]}],
    })  # fmt: skip
    found = simulate(scene).contact["contacts.0"].last.nodal_pressure
    assert found == pytest.approx(5.0, rel=1e-4)
    whole = simulate(scene.with_({"contacts.0.corner": 170.0})).contact["contacts.0"].last.nodal_pressure
    assert whole.min() < 5.0 * (1.0 - 0.5 * (1.0 - np.cos(np.radians(0.5 * turn))))
