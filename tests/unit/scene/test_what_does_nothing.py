"""Requests that would be carried out and mean nothing, or count twice: refused with key, number and what to do."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from contactlab.api import Mesh
from contactlab.errors import SceneError
from contactlab.meshing import Rectangle
from contactlab.meshing.checks import check_mesh
from contactlab.model.build import build
from contactlab.parts.registry import default_registry
from contactlab.scene.scene import Scene

ELASTIC = {"use": "neo-hookean", "young": 1000.0, "poisson": 0.25, "density": 1e-6}


def block(y: tuple[float, float]) -> dict[str, Any]:
    mesh = {"use": "rectangle", "x": [0.0, 1.0], "y": list(y), "cells": [4, 2]}
    return {"element": "q1", "material": "m", "mesh": mesh}


def data(**more: Any) -> dict[str, Any]:
    return {
        "time": {"end": 1e-4},
        "integrator": "central-difference",
        "materials": {"m": ELASTIC},
        "bodies": {"upper": block((0.0, 1.0)), "lower": block((-1.0, 0.0))},
        "contacts": [{"slave": "upper.bottom", "master": "lower.top", "algorithm": "mortar-p0"}],
        "supports": [{"on": "lower.bottom", "ux": 0.0, "uy": 0.0}],
        "record": {"frames": 1, "recorders": []},
        **more,
    }


def refused(scene: dict[str, Any]) -> str:
    with pytest.raises(SceneError) as found:
        build(Scene.from_data(scene), default_registry())
    return str(found.value)


HELD = {"on": "lower.bottom", "ux": 0.0, "uy": 0.0}
LATE = {"ramp": "linear", "to": -0.1, "begin": 1e-4}
CASES: dict[str, tuple[dict[str, Any], list[str]]] = {
    "support": (
        data(supports=[HELD, {"on": "upper.top", "uy": LATE}]),
        ["supports.1.uy.begin", "0.0001", "a time before 0.0001 [s]"],
    ),
    "load": (
        data(loads=[{"on": "upper.top", "pressure": LATE | {"begin": 3e-4}}]),
        ["loads.0.pressure.begin", "0.0003", "begins after the end of the run"],
    ),
    "table": (
        data(supports=[HELD, {"on": "upper.top", "uy": {"ramp": "table", "to": 1.0, "points": [[1, 0], [2, 1]]}}]),
        ["supports.1.uy", "1.0", "begins after the end of the run"],
    ),
    "overlap": (
        data(contacts=[{"slave": "upper.bottom", "master": "lower.top", "algorithm": "mortar-p0",
                        "start": {"overlap": "ramp", "duration": 1.0}}]),
        ["contacts.0.start.duration", "at most 0.0001 [s]"],
    ),
    "damper": (
        data(effects=[{"use": "vibration-damping", "rate": 10.0, "until": 0.0}]),
        ["effects.0.until", "0.0", "a time > 0 [s]"],
    ),
    "damping in statics": (
        data(integrator="newton", effects=[{"use": "vibration-damping", "rate": 10.0}]),
        ["effects.0", "nothing vibrates in statics"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_what_would_do_nothing_is_refused(case: str) -> None:
    scene, words = CASES[case]
    try:
        told = refused(scene)
    except Exception as error:  # what fields of a part refuse is a PartError or SceneError of the registry
        told = str(error)
    for word in words:
        assert word in told


def test_a_ramp_that_begins_within_the_run_is_fine() -> None:
    build(Scene.from_data(data(supports=[HELD, {"on": "upper.top", "uy": LATE | {"begin": 9e-5}}])), default_registry())


def test_the_same_stretch_in_two_contacts_is_refused() -> None:
    bodies = {"upper": block((0.0, 1.0)), "lower": block((-1.0, 0.0))}
    bodies["upper"]["sets"] = {"middle": {"of": "bottom", "x": [0.25, 0.75]}}
    contacts = [
        {"slave": "upper.bottom", "master": "lower.top", "algorithm": "mortar-p0"},
        {"slave": "upper.middle", "master": "lower.top", "algorithm": "mortar-p0"},
    ]
    told = refused(data(bodies=bodies, contacts=contacts))
    assert "contacts.0 joins parts of these surfaces already" in told
    assert "contacts.1" in told
    told = refused(data(bodies=bodies, contacts=[contacts[0], contacts[1] | {"swap": True}]))
    assert "counted twice" in told


# --- meshes -----------------------------------------------------------------------------------------


def mesh() -> Mesh:
    return Rectangle((0.0, 2.0), (0.0, 1.0), (4, 2)).mesh(default_registry().make("element", "q1"), 1)


def twice(made: Mesh) -> Mesh:
    return Mesh(made.nodes, np.concatenate([made.cells, made.cells[3:4, [1, 2, 3, 0]]]), made.edges)


def apart(made: Mesh) -> Mesh:
    nodes = np.concatenate([made.nodes, made.nodes + np.array([5.0, 0.0])])
    return Mesh(nodes, np.concatenate([made.cells, made.cells + len(made.nodes)]), made.edges)


def with_node(made: Mesh, node: int, place: tuple[float, float]) -> Mesh:
    nodes = made.nodes.copy()
    nodes[node] = place
    return Mesh(nodes, made.cells, made.edges)


def flat(made: Mesh) -> Mesh:
    return Mesh(made.nodes * np.array([1.0, 0.0]), made.cells, made.edges)


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (twice, ["1 of 9 cells are duplicates", "cell 8 has the nodes of cell 3"]),
        (apart, ["has 2 pieces", "cells 8 and 8", "cell 8 the first"]),
        (
            lambda made: with_node(made, 5, (np.nan, 0.0)),
            ["1 of 15 nodes have no valid position", "node 5 at (nan, 0)"],
        ),
        (lambda made: with_node(made, 5, (1e200, 0.0)), ["node 5 at (1e+200, 0)"]),
        (flat, ["8 of 8 cells have no area"]),
        (lambda made: Mesh(made.nodes, made.cells[:, ::-1].copy(), made.edges), ["8 of 8 cells are inverted"]),
    ],
    ids=["twice", "apart", "nan", "far", "flat", "inverted"],
)
def test_meshes_that_are_none_are_refused(spoil: Callable[[Mesh], Mesh], words: list[str]) -> None:
    element = default_registry().make("element", "q1")
    check_mesh(mesh(), element, "bodies.b.mesh")
    with pytest.raises(SceneError) as found:
        check_mesh(spoil(mesh()), element, "bodies.b.mesh")
    for word in ["bodies.b.mesh", *words]:
        assert word in str(found.value)
