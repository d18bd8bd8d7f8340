"""What a run says of the patch test that its algorithm fails, against the error that it has."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from contactlab.parts.registry import default_registry
from contactlab.results.results import Results
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene

DEPTH = 0.01


def simulated(law: dict[str, Any], bodies: dict[str, Any], **rest: Any) -> Results:
    """Statics of bodies of one material, q1 unless they say otherwise."""
    data = {
        "format": 1,
        "name": "patch",
        "integrator": {"use": "newton", "steps": 1},
        "materials": {"m": law | {"density": 1.0}},
        "bodies": {name: {"element": "q1", "material": "m"} | body for name, body in bodies.items()},
    }
    return simulate(Scene.from_data(data | rest, registry=default_registry()))


def pressed(
    cells: tuple[int, int],
    contact: str = "node-on-segment",
    element: str = "q1",
    width: tuple[float, float] = (0.0, 1.0),
    **more: Any,
) -> Results:
    """Two blocks of nu = 0 on top of each other, `cells` of the upper and of the lower one along the contact.

    width  of the lower block
    """
    upper, lower = cells
    mesh = {"use": "rectangle", "x": [0.0, 1.0]}
    return simulated(
        {"use": "linear-elastic", "young": 1e6, "poisson": 0.0},
        {
            "upper": {"element": element, "mesh": mesh | {"y": [0.5, 1.0], "cells": [upper, 3]}},
            "lower": {"element": element, "mesh": mesh | {"x": list(width), "y": [0.0, 0.5], "cells": [lower, 3]}},
        },
        contacts=[{"slave": "upper.bottom", "master": "lower.top", "algorithm": contact, **more}],
        supports=[{"on": "lower.bottom", "ux": 0.0, "uy": 0.0}, {"on": "upper.top", "ux": 0.0, "uy": -DEPTH}],
    )


def told(results: Results) -> float:
    """The value of the warning; 0 without it."""
    return next((w.value for w in results.warnings if w.code == "patch-test"), 0.0)


def error(results: Results) -> float:
    """Largest distance of a node from where it should be, over the largest displacement."""
    exact = np.stack([np.zeros(len(results.nodes)), -DEPTH * results.nodes[:, 1]], axis=1)
    return float(np.hypot(*(results.displacement - exact).T).max()) / DEPTH


@pytest.mark.parametrize("cells", [(3, 7), (4, 7), (4, 5), (4, 10), (7, 4), (10, 7)])
def test_the_error_is_what_is_told(cells: tuple[int, int]) -> None:
    """The estimate is linear, and pressures of the run itself are uneven: within a quarter."""
    results = pressed(cells)
    assert told(results) == pytest.approx(error(results), rel=0.25)


@pytest.mark.parametrize("cells", [(4, 5), (4, 7)])
def test_quadratic_edges_have_their_own_functions(cells: tuple[int, int]) -> None:
    results = pressed(cells, element="q2-lagrange")
    assert told(results) == pytest.approx(error(results), rel=0.5)


@pytest.mark.parametrize("cells", [(1, 4), (3, 5), (4, 10)])
def test_a_barrier_on_quadratic_edges_is_told_with_its_error(cells: tuple[int, int]) -> None:
    """Its edges are two straight segments: their middle node has a half of the force, where a pressure gives 2/3.

    Within 0.3: of the errors, 0.03 to 0.2, up to 0.01 is the clearance (`error` of q1, of which less is told).
    """
    results = pressed(cells, "barrier", "q2-lagrange")
    assert told(results) == pytest.approx(error(results), rel=0.3)
    assert told(pressed(cells, "barrier")) < 0.02


@pytest.mark.parametrize("element", ["q1", "q2-lagrange"])
def test_a_barrier_between_nodes_opposite_each_other_moves_none(element: str) -> None:
    """Forces of both sides are off alike, and what is left is the clearance."""
    results = pressed((4, 4), "barrier", element)
    assert told(results) == 0.0
    assert error(results) < 0.01


@pytest.mark.parametrize(
    ("cells", "contact"), [((4, 4), "node-on-segment"), ((4, 8), "mortar-p1"), ((4, 7), "mortar-p0")]
)
@pytest.mark.parametrize("element", ["q1", "q2"])
def test_nothing_is_told_of_forces_at_the_right_nodes(cells: tuple[int, int], contact: str, element: str) -> None:
    """Nodes opposite each other, or an algorithm that passes the test."""
    results = pressed(cells, contact, element)
    assert told(results) == 0.0
    assert error(results) < 1e-6


@pytest.mark.parametrize(("width", "cells"), [((-0.5, 1.5), (4, 8)), ((0.25, 0.75), (4, 2))])
@pytest.mark.parametrize("swap", [False, True])
def test_a_rim_is_no_wrong_node(width: tuple[float, float], cells: tuple[int, int], swap: bool) -> None:
    """Nodes opposite each other, and a side that reaches beyond the other: what stands for more than is covered."""
    assert told(pressed(cells, width=width, swap=swap)) == 0.0


@pytest.mark.parametrize("swap", [False, True])
def test_a_ring_that_only_friction_turns_is_not_turned(swap: bool) -> None:
    """Facets stand off each other: forces at other nodes have another torque, which nothing but sticking holds."""
    ring = {"use": "ring", "angles": [0.0, 360.0]}
    results = simulated(
        {"use": "neo-hookean", "young": 1e4, "poisson": 0.3},
        {
            "inner": {"mesh": ring | {"radii": [1.0, 2.004], "cells": [24, 3]}},
            "outer": {"mesh": ring | {"radii": [2.0, 3.0], "cells": [36, 3]}},
        },
        integrator={"use": "newton", "steps": 2},
        contacts=[
            {
                "slave": "inner.outer", "master": "outer.inner", "algorithm": "node-on-segment", "swap": swap,
                "friction": {"use": "coulomb", "mu": 0.5}, "start": {"overlap": "ramp"},
            }
        ],
        supports=[{"on": "outer.outer", "ux": 0.0, "uy": 0.0}],
        effects=[{"use": "spring", "on": "inner", "stiffness": [1e-3, 1e-3]}],
    )  # fmt: skip
    assert told(results) < 0.2


def test_a_coarse_slave_is_told_with_the_place_and_what_to_do() -> None:
    (warning,) = [w for w in pressed((4, 7)).warnings if w.code == "patch-test"]
    assert warning.key == "contacts.0.algorithm"
    assert "at (" in warning.text
    assert "mortar" in warning.text


def test_gauss_points_reach_the_right_nodes_more_nearly() -> None:
    """The same scene: more points are a finer rule for the same integral."""
    points, nodes = (pressed((3, 7), contact) for contact in ("gauss-point", "node-on-segment"))
    assert error(points) < 0.2 * error(nodes)
    assert told(points) < 0.2 * told(nodes)
