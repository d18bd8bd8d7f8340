"""Numbers that stand in several places of the results agree: records of steps, curves, counts and integrals.

Every contact algorithm with friction leaves its slips, node by node and step by step, under every integrator.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tiers import some

from contactlab.parts.registry import default_registry
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene

ASIDE = 0.1
IMPLICIT = "newton", "implicit-dynamics"
WAYS = {"newton": {"steps": 4}, "implicit-dynamics": {"steps": 20}, "central-difference": {}}
POTENTIALS = "barrier", "midplane"


def dragged(algorithm: str, integrator: str) -> Scene:
    """A block that lies on a floor and is dragged aside while it is pressed; it is at rest where there is inertia."""
    heavy = 1e-9 if integrator == "newton" else 1e-2  # waves take 0.02 s across: the loading is slow
    return Scene.from_data({
        "time": {"end": 1.0 if integrator != "newton" else "auto"},
        "integrator": {"use": integrator, **WAYS[integrator]},
        "materials": {"m": {"use": "neo-hookean", "young": 100.0, "poisson": 0.3, "density": heavy}},
        "bodies": {"b": {"element": "q1", "material": "m", "mesh": {
            "use": "rectangle", "x": [0.0, 4.0], "y": [0.0, 2.0], "cells": [4, 2]}}},
        "rigid": {"floor": {"line": [[9.0, 0.0], [-5.0, 0.0]]}},
        "supports": [{"on": "b.top", "ux": {"ramp": "linear", "to": ASIDE}, "uy": {"ramp": "linear", "to": -0.1}}],
        "contacts": [{"slave": "b.bottom", "master": "floor", "algorithm": algorithm,
                      "friction": {"use": "coulomb", "mu": 0.05}}],
        "record": {"frames": 4, "recorders": ["vtkhdf"]},
    })  # fmt: skip


def every() -> Iterator[tuple[str, str]]:
    """Names of algorithms and integrators."""
    for name in default_registry().names("contact"):
        for integrator in IMPLICIT if name in POTENTIALS else WAYS:
            yield name, integrator


IN_TIME = [("gauss-point", "implicit-dynamics"), ("node-on-segment", "central-difference")]
ALIKE = "mortar-p0", "mortar-dual"
"""Algorithms whose rows are those of `mortar-p1` with another basis: in the full tier."""


@pytest.mark.parametrize(
    ("algorithm", "integrator"),
    some(every(), [pair for pair in every() if "newton" in pair and pair[0] not in ALIKE] + IN_TIME),
)
def test_slips_of_all_steps_add_up_to_the_drag(algorithm: str, integrator: str, tmp_path: Path) -> None:
    """On a flat floor the slips of a node that never leaves it add up to its motion, to single precision of each."""
    results = simulate(dragged(algorithm, integrator), tmp_path / "run")
    assert results.status == "finished", results.reason
    slips = np.concatenate([rows["slip"] for block in results.contact_step_blocks() for rows in block.values()])
    total = slips.sum(axis=0, dtype=float)[1:-1]
    (contact,) = results.contact.values()
    moved = np.sort(contact.last.x - np.round(contact.last.x))[1:-1]  # nodes were at 0, 1, .. 4 mm
    assert np.all(moved > 0.5 * ASIDE)
    np.testing.assert_allclose(np.sort(np.abs(total)), moved, rtol=1e-4)


SPRINGS = {"use": "linear-pressure", "stiffness": 1e4}


def pressed_arc(algorithm: dict[str, Any], element: str, smooth: bool) -> Scene:
    """A ring in another one that it presses and turns in."""
    steel = {"use": "linear-elastic", "young": 1000.0, "poisson": 0.3, "density": 1e-9}
    radii = {"inner": ([3.0, 5.0], 9), "outer": ([5.1, 7.0], 7)}
    bodies = {name: {"element": element, "material": "m",
                     "mesh": {"use": "ring", "radii": span, "cells": [cells, 2], "angles": [20.0, 160.0]}}
              for name, (span, cells) in radii.items()}  # fmt: skip
    contact = {"slave": "inner.outer", "master": "outer.inner", "friction": {"use": "coulomb", "mu": 0.2}} | algorithm
    turn = {"ux": {"ramp": "linear", "to": 0.02}, "uy": {"ramp": "linear", "to": 0.2}}
    return Scene.from_data({
        "integrator": {"use": "newton", "steps": 3},
        "materials": {"m": steel}, "bodies": bodies, "contacts": [contact | ({"smooth": True} if smooth else {})],
        "supports": [{"on": "outer.outer", "ux": 0.0, "uy": 0.0}, {"on": "inner.inner"} | turn],
        "record": {"recorders": ["vtkhdf"]},
    })  # fmt: skip


def kinds() -> Iterator[tuple[dict[str, Any], str, bool]]:
    """Algorithms, elements, and whether surfaces are smooth."""
    for name in default_registry().names("contact"):
        yield {"algorithm": name}, "q1", False
        yield {"algorithm": name}, "q2", False
    yield {"algorithm": "mortar-p0"}, "q1", True
    yield {"algorithm": "mortar-p1"}, "q1", True
    for element in ("q1", "q2"):
        yield {"algorithm": {"use": "gauss-point", "passes": 2}, "enforcement": SPRINGS}, element, False


def tiers() -> Iterator[Any]:
    """Of each algorithm one element in every tier, by turns, and of what is smooth or has two passes one of both."""
    for number, kind in enumerate(kinds()):
        alike = kind[0]["algorithm"] in ALIKE and not kind[2]
        yield pytest.param(*kind, marks=() if number % 4 in (0, 3) and not alike else pytest.mark.full)


@pytest.mark.parametrize(("algorithm", "element", "smooth"), list(tiers()))
def test_the_record_of_the_last_step_is_the_curve_of_the_end(
    algorithm: dict[str, Any], element: str, smooth: bool, tmp_path: Path
) -> None:
    """To single precision; closed nodes face a segment, and the step counts as many as stick as the record shows."""
    results = simulate(pressed_arc(algorithm, element, smooth), tmp_path / "run")
    assert results.status == "finished", results.reason
    ((name, contact),) = results.contact.items()
    row = [rows[name][-1] for rows in results.contact_step_blocks()][-1]
    curve = contact.last
    closed = curve.state > 0
    assert closed.any()
    np.testing.assert_array_equal(row["state"], curve.state)
    for quantity in ("pressure", "shear", "gap"):
        now = np.asarray(getattr(curve, quantity))
        # gaps are differences of positions in double precision, pressures those of forces that balance to 1e-8
        np.testing.assert_allclose(row[quantity], now, rtol=1e-5, atol=1e-6 * np.nanmax(np.abs(now)) + 1e-9)
    assert np.all(row["segment"][closed] < len(curve.s) * 10)
    if np.size(row["state"]) == results.steps[f"{name}.active"][-1]:  # one condition a node: all are closed
        assert results.steps[f"{name}.sticking"][-1] == np.count_nonzero(row["state"] == 1)


EACH = [(algorithm, element) for algorithm in default_registry().names("contact") for element in ("q1", "q2")]


@pytest.mark.parametrize(
    ("algorithm", "element"),
    some(EACH, [pair for pair in EACH if pair[0] not in ALIKE and (pair[1] == "q1" or pair[0] not in POTENTIALS)]),
)
def test_the_integral_of_an_even_pressure_is_the_force(algorithm: str, element: str) -> None:
    """A block that slides on a wider one: pressures of fully covered slaves add up to the force, within their ends."""
    block = {"use": "rectangle", "x": [0.0, 2.0], "y": [0.0, 1.0], "cells": [6, 2]}
    floor = {"use": "rectangle", "x": [-1.0, 3.0], "y": [-1.0, 0.0], "cells": [9, 2]}
    body = {"element": element, "material": "m"}
    results = simulate(Scene.from_data({
        "integrator": {"use": "newton", "steps": 4},
        "materials": {"m": {"use": "linear-elastic", "young": 1000.0, "poisson": 0.0, "density": 1e-9}},
        "bodies": {"block": {**body, "mesh": block}, "floor": {**body, "mesh": floor}},
        "supports": [{"on": "floor", "uy": 0.0}, {"on": "floor.bottom", "ux": 0.0},
                     {"on": "block.top", "ux": {"ramp": "linear", "to": 0.1}, "uy": {"ramp": "linear", "to": -0.02}}],
        "contacts": [{"slave": "block.bottom", "master": "floor.top", "algorithm": algorithm,
                      "friction": {"use": "coulomb", "mu": 0.3}}],
        "record": {"recorders": []},
    }))  # fmt: skip
    (facts,) = results.summary["contacts"].values()
    np.testing.assert_allclose(facts["pressure_integral"], facts["resultant"], rtol=5e-3)


@pytest.mark.parametrize("element", ["q1", "q2"])
def test_forces_and_moments_by_hand_from_the_curve_of_a_beam_on_knives(element: str) -> None:
    """Sums over pressures of nodes are the reactions, and act where the knives are, also between two nodes."""
    knives, load, length = (1.3, 2.8), 0.1, 4.0
    mesh = {"use": "rectangle", "x": [0.0, length], "y": [0.0, 1.0], "cells": [4, 2]}
    contact = {"slave": "beam.bottom", "algorithm": "node-on-segment"}
    results = simulate(Scene.from_data({
        "integrator": "newton",
        "materials": {"m": {"use": "linear-elastic", "young": 1000.0, "poisson": 0.0, "density": 1e-9}},
        "bodies": {"beam": {"element": element, "material": "m", "mesh": mesh}},
        "rigid": {f"knife{i}": {"line": [[x + 0.5, -0.5], [x, 0.0], [x - 0.5, -0.5]]} for i, x in enumerate(knives)},
        "contacts": [{**contact, "master": f"knife{i}"} for i in range(2)],
        "supports": [{"on": "beam.left", "ux": 0.0}],
        "loads": [{"on": "beam.top", "ty": -load}],
    }))  # fmt: skip
    assert results.status == "finished", results.reason
    reactions = [results.summary["reactions"][f"knife{i}"][1] for i in range(2)]
    assert sum(reactions) == pytest.approx(load * length, rel=1e-6)
    lengths = np.tile([1.0] if element == "q1" else [1.0 / 3.0, 2.0 / 3.0], 4)  # of the first node of each edge
    for curve, knife, force in zip(results.contact.values(), knives, reactions, strict=True):
        order = np.argsort(curve.last.x)[:-1]  # the last node is open
        at_nodes = curve.last.nodal_pressure[order] * lengths
        # the beam bends by 1e-3 of its length
        assert at_nodes.sum() == pytest.approx(force, rel=1e-3)
        assert curve.last.x[order] @ at_nodes / force == pytest.approx(knife, rel=1e-3)
    # the nodes are up to 0.35 mm above the flanks, and the knives touch: nothing is kept open
    assert "kept-gap" not in [warning.code for warning in results.warnings]
