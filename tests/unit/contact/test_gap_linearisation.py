"""Finished gap conditions in implicit runs: derivatives against differences, and the answers of the shipped part."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from contactlab.api import ConditionDerivatives
from contactlab.contact.condition_differences import ConditionDifferences
from contactlab.errors import ContactlabError
from contactlab.model.build import build
from contactlab.model.implicit_model import ImplicitModel
from contactlab.parts.loading import Origin, load
from contactlab.parts.registry import Registry
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene
from contactlab.testing.contact_derivatives import against_differences, answers_of

PACKAGE = Path(__file__).parents[2] / "outside" / "closest-point" / "src"


@pytest.fixture(scope="module")
def registry() -> Iterator[Registry]:
    """The shipped parts and those of the outside package."""
    sys.path.insert(0, str(PACKAGE))
    import closest_point.plugin

    found = Registry()
    found._add(load(Origin("closest-point", "a test"), lambda: closest_point.plugin))
    yield found
    sys.path.remove(str(PACKAGE))


def pressed(algorithm: str, registry: Registry, friction: bool = False, **changes: Any) -> Scene:
    """A block pressed into a wider one by a tenth of its height, and pushed aside with friction."""
    law: dict[str, Any] = {"friction": {"use": "coulomb", "mu": 0.3}} if friction else {}
    across = {"ux": {"ramp": "linear", "to": 0.05}} if friction else {"ux": 0.0}
    return Scene.from_data(
        {
            "name": "pressed",
            "integrator": {"use": "newton", "steps": 4},
            "materials": {"m": {"use": "neo-hookean", "young": 1000.0, "poisson": 0.3, "density": 1e-6}},
            "bodies": {
                "upper": {
                    "element": "q1", "material": "m",
                    "mesh": {"use": "arc-block", "radius": 2.0, "half_width": 1.0, "top": 1.0, "cells": [7, 3]},
                },
                "lower": {
                    "element": "q1", "material": "m",
                    "mesh": {"use": "rectangle", "x": [-1.3, 1.4], "y": [-1.0, 0.0], "cells": [9, 4]},
                },
            },
            "contacts": [{"slave": "upper.arc", "master": "lower.top", "algorithm": algorithm, **law}],
            "supports": [
                {"on": "lower.bottom", "ux": 0.0, "uy": 0.0},
                {"on": "upper.top", "uy": -0.1, **across},
            ],
        } | changes,
        registry=registry,
    )  # fmt: skip


def shaken(scene: Scene, registry: Registry, most: float = 6e-3) -> tuple[ImplicitModel, Any]:
    """The model where a step starts, all nodes shaken so that nothing is symmetric, and positions at its end."""
    model = build(scene, registry)
    assert isinstance(model, ImplicitModel)
    assert model.contact is not None
    draw, upper = np.random.default_rng(1), slice(0, model.bodies[0].count)
    start, end = (model.reference + draw.uniform(-size, size, model.reference.shape) for size in (most, most / 1.5))
    start[upper, 1] -= 0.045
    end[upper, 1] -= 0.05
    model.contact.begin_step(start, 0.0)
    return model, end


@pytest.mark.parametrize("friction", [False, True], ids=["frictionless", "friction"])
@pytest.mark.parametrize("algorithm", ["closest-point", "closest-point-plain"])
@pytest.mark.parametrize("swap", [False, True], ids=["arc", "block"])
def test_derivatives_are_those_of_the_conditions(
    algorithm: str, swap: bool, friction: bool, registry: Registry
) -> None:
    """Gaps, slips and nodal forces at fixed multipliers, moved along a random direction."""
    scene = pressed(algorithm, registry, friction).with_({"contacts.0.swap": swap})
    model, position = shaken(scene, registry)
    contact = model.contact
    assert contact is not None
    contact.evaluate(position)
    c, draw = contact.conditions, np.random.default_rng(2)
    chosen = np.flatnonzero(c.present & (c.gap < 0.02))
    assert len(chosen) >= 3
    c.force[0, chosen] = draw.uniform(1.0, 3.0, len(chosen))
    if friction:
        c.force[1, chosen] = draw.uniform(-1.0, 1.0, len(chosen))
    forces = c.force.copy()
    found = contact.linearise(chosen)
    move = draw.uniform(-1.0, 1.0, position.shape)
    answers = partial(answers_of, contact, forces=forces, chosen=chosen)
    against_differences(found, answers, position, move, (1e-7, 1e-7, 1e-5), algorithm)
    own = found.normal.T @ forces[0, chosen] + (found.tangent.T @ forces[1, chosen] if friction else 0.0)
    np.testing.assert_allclose(own, answers(position)[2], atol=1e-9, rtol=0.0)


def tables_of(pair: Any, memory: Any, position: Any, by_differences: ConditionDerivatives) -> list[Any]:
    """Derivatives (entries, coordinates, 2) of the weights: those the algorithm gives, and by differences."""
    given = pair.method.derivatives(pair.seen(memory), pair.found)
    tables = []
    for one in (given, by_differences):
        table = np.zeros((len(pair.found.node), position.size, 2))
        np.add.at(table, (one.entry, one.moved), one.value)
        tables.append(table)
    return tables


def test_differences_are_the_derivatives_given(registry: Registry) -> None:
    """Weights of each entry by each coordinate, one by one: both roads give the same matrix."""
    model, position = shaken(pressed("closest-point", registry), registry)
    assert model.contact is not None
    model.contact.evaluate(position)
    pair, memory = model.contact.pairs[0], model.contact.linear[0].memory
    by_differences = ConditionDifferences(pair).of(memory)  # type: ignore[arg-type]
    tables = tables_of(pair, memory, position, by_differences)
    assert np.abs(tables[0]).max() > 1.0
    np.testing.assert_allclose(tables[1], tables[0], atol=1e-7)


def test_differences_on_graded_meshes(registry: Registry) -> None:
    """Segments of 1 : 1000, as those of an indenter: each node steps by its own, and the first guess is enough."""
    changes = {
        "bodies.upper.mesh": {"cells": [24, 3], "grading": [1e3, 1.0]},
        "bodies.lower.mesh": {"x": [-1.3, 0.0, 1.4], "cells": [[12, 13], 4], "grading": [[1e-3, 1e3], 1.0]},
    }
    keys = {f"{mesh}.{key}": value for mesh, fields in changes.items() for key, value in fields.items()}
    model, position = shaken(pressed("closest-point", registry).with_(keys), registry, 1e-6)
    assert model.contact is not None
    model.contact.evaluate(position)
    pair, memory = model.contact.pairs[0], model.contact.linear[0].memory
    differences = ConditionDifferences(pair)  # type: ignore[arg-type]
    lengths = differences.size[pair.slave.nodes]
    assert lengths.max() > 100.0 * lengths.min()
    tables = tables_of(pair, memory, position, differences.of(memory))
    assert list(differences.colours) == [0]
    # the position of a node is known to 1e-16, and moves by 1e-5 of a segment of 1e-3
    size = differences.size.repeat(2)[:, None]
    np.testing.assert_allclose(tables[1] * size, tables[0] * size, atol=1e-6)


@pytest.mark.full
@pytest.mark.parametrize("friction", [False, True], ids=["frictionless", "friction"])
def test_newton_reaches_the_answer_of_the_shipped_part(friction: bool, registry: Registry) -> None:
    """The same conditions, so the same positions and reactions; and no more iterations, as derivatives are exact."""
    runs = {
        name: simulate(pressed(name, registry, friction), registry=registry)
        for name in ("node-on-segment", "closest-point", "closest-point-plain")
    }
    for name, results in runs.items():
        assert results.status == "finished", (name, results.reason)
    shipped = runs.pop("node-on-segment")
    force = shipped.summary["reactions"]["lower.bottom"]
    assert abs(force[1]) > 50.0
    for name, results in runs.items():
        # both stop at residuals of 1e-8 of the forces
        assert results.summary["reactions"]["lower.bottom"] == pytest.approx(force, abs=1e-6 * abs(force[1])), name
        assert results.summary["iterations"] <= shipped.summary["iterations"] + 2, name


@pytest.mark.parametrize("algorithm", ["closest-point", "closest-point-plain"])
def test_convergence_is_quadratic(algorithm: str, registry: Registry) -> None:
    """Once statuses stand still, each residual is of the order of the square of the one before."""
    model = build(pressed(algorithm, registry, True), registry)
    trace = model.bound_integrator().step(0.25).trace
    left = [row.force for row in trace if row.changed == 0]
    assert len(left) >= 2
    pairs = [(old, new) for old, new in pairwise(left) if 1e-8 < old < 1e-2]
    assert pairs
    for old, new in pairs:
        assert new <= max(100.0 * old**2, 1e-9), left


@pytest.mark.parametrize(
    ("wrong", "word"),
    [
        ("nothing at all", "needed: ConditionDerivatives"),
        ({"moved": np.zeros(1, np.int32)}, "moved"),
        ({"entry": np.array([999], np.int32)}, "entry outside"),
        ({"value": np.full((1, 2), np.nan)}, "not finite"),
    ],
)
def test_wrong_derivatives_are_named(wrong: Any, word: str, registry: Registry) -> None:
    from closest_point.contact import ClosestPoint

    sound = ConditionDerivatives(np.zeros(1, np.int32), np.zeros(1, np.int32), np.zeros((1, 2)))
    if isinstance(wrong, dict) and "moved" in wrong:
        wrong = {"moved": np.zeros(2, np.int32)}
    given = replace(sound, **wrong) if isinstance(wrong, dict) else wrong
    model, position = shaken(pressed("closest-point", registry), registry)
    assert model.contact is not None
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ClosestPoint, "derivatives", lambda self, view, found: given)
        model.contact.evaluate(position)
        with pytest.raises((ContactlabError, ValueError), match=word):
            model.contact.linearise(np.flatnonzero(model.contact.conditions.present)[:3])
