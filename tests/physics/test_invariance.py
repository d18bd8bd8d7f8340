"""What must not matter: the orientation of a scene, its numbering, the order of its bodies, its units.

Short dynamic runs of disc-on-block with friction. The answers agree to round-off, magnified by some
hundred steps and by contact solves that stop at 1e-10 of a segment; 1e-8 of the largest value leaves
room for both and for nothing else.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from contactlab.results.results import Results
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene, load_scene
from contactlab.testing.scenarios.invariance import Renumbering

SAME = 1e-8
DEPTH = 0.02
CASES = [
    ("node-on-segment", "q1"),
    ("mortar-p0", "q1"),
    ("mortar-p1", "q1"),
    ("node-on-segment", "q2"),
    ("mortar-p0", "q2"),
    ("mortar-p1", "q2-lagrange"),
]
# frozen mortar rows make a fifth of the energy in so fast a push on quadratic sides, which ends the run
CONSISTENT = {"contacts.0.enforcement": {"use": "forward-increment", "forces": "consistent"}}
HALVED = {"bodies.disc.mesh.cells": [12, 3], "bodies.block.mesh.cells": [18, 3]}


def short_scene(algorithm: str, element: str) -> Scene:
    return load_scene("disc-on-block").with_(
        {
            "level": 1,
            "time.end": 8e-7,
            "time.step": 3e-9 if element == "q1" else 2e-9,
            "bodies.disc.element": element,
            "bodies.block.element": element,
            "contacts.0.algorithm": algorithm,
            "contacts.0.friction": {"use": "coulomb", "mu": 0.2},
            # off the centre, so that no symmetry hides anything
            "bodies.disc.shift": [0.0113, 0.0],
            "supports.1.ux": {"ramp": "linear", "to": 0.3 * DEPTH},
            "supports.1.uy": {"ramp": "linear", "to": -DEPTH},
            "record.frames": 1,
            **({} if element == "q1" else HALVED | CONSISTENT),  # as many nodes
        }
    )


def answers(results: Results) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Reaction of the top, pressures and shears of the last frame."""
    assert results.status == "finished", results.reason
    curve = results.contact["contacts.0"].last
    return np.array(results.summary["reactions"]["disc.top"]), curve.pressure, curve.shear


@cache
def unchanged(algorithm: str, element: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Answers of the scene as it is."""
    return answers(simulate(short_scene(algorithm, element)))


def assert_same(found: np.ndarray, wanted: np.ndarray) -> None:
    assert np.abs(found - wanted).max() <= SAME * np.abs(wanted).max()


@pytest.mark.parametrize(("algorithm", "element"), CASES)
def test_a_turned_scene_gives_turned_answers(algorithm: str, element: str) -> None:
    """The whole scene turned by 30 degrees: reactions turn, pressures and shears stay."""
    scene = short_scene(algorithm, element)
    cos, sin = math.cos(math.radians(30.0)), math.sin(math.radians(30.0))
    turn = np.array([[cos, -sin], [sin, cos]])
    moved, shift = turn @ [0.3 * DEPTH, -DEPTH], turn @ [0.0113, 0.0]
    turned = scene.with_(
        {
            "bodies.disc.rotate": 30.0,
            "bodies.block.rotate": 30.0,
            "bodies.disc.shift": shift.tolist(),
            "supports.1.ux": {"ramp": "linear", "to": float(moved[0])},
            "supports.1.uy": {"ramp": "linear", "to": float(moved[1])},
        }
    )
    first, second = unchanged(algorithm, element), answers(simulate(turned))
    assert_same(second[0], turn @ first[0])
    assert_same(second[1], first[1])
    assert_same(second[2], first[2])


@pytest.mark.parametrize(("algorithm", "element"), CASES)
def test_other_units_give_the_same_numbers(algorithm: str, element: str) -> None:
    """mm, N, t to m, kN, t: lengths by 1e-3, stresses by 1e3 (kPa), densities by 1e9; N/mm is kN/m."""
    data = short_scene(algorithm, element).data
    for law in data["materials"].values():
        law["young"] *= 1e3
        law["density"] *= 1e9
    disc, block = data["bodies"]["disc"]["mesh"], data["bodies"]["block"]["mesh"]
    for key in ("radius", "half_width", "top"):
        disc[key] *= 1e-3
    for key in ("x", "y"):
        block[key] = [1e-3 * value for value in block[key]]
    data["bodies"]["disc"]["shift"] = [1e-3 * value for value in data["bodies"]["disc"]["shift"]]
    for motion in ("ux", "uy"):
        data["supports"][1][motion]["to"] *= 1e-3
    first, second = unchanged(algorithm, element), answers(simulate(Scene.from_data(data)))
    assert_same(second[0], first[0])
    assert_same(second[1] / 1e3, first[1])
    assert_same(second[2] / 1e3, first[2])


@pytest.mark.parametrize(("algorithm", "element"), CASES)
def test_the_order_of_the_bodies_does_not_matter(algorithm: str, element: str) -> None:
    data = short_scene(algorithm, element).data
    data["bodies"] = dict(reversed(data["bodies"].items()))
    for found, wanted in zip(answers(simulate(Scene.from_data(data))), unchanged(algorithm, element), strict=True):
        assert_same(found, wanted)


@pytest.mark.parametrize(("algorithm", "element"), CASES)
def test_numbering_does_not_matter(algorithm: str, element: str) -> None:
    """Nodes, cells and the edges of sets in random order."""
    scene = short_scene(algorithm, element)
    found = answers(simulate(scene, registry=Renumbering(scene.registry)))
    # the chain starts where its edges do, whatever their order: curves are comparable node by node
    for one, other in zip(found, unchanged(algorithm, element), strict=True):
        assert_same(one, other)
