"""Mortars over corners of the master: derivatives of what holds there, and balance of bodies that lie on a corner."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pytest
from tiers import some

import contactlab
from contactlab.contact.implicit_system import ImplicitContactSystem
from contactlab.model.build import build
from contactlab.results.results import Results
from contactlab.scene.scene import Scene
from contactlab.testing.contact_derivatives import against_differences, answers_of

ALGORITHMS = ("mortar-p0", "mortar-p1", "mortar-dual")


@pytest.mark.parametrize("moved", [5.05, 5.15, -3.05, -3.15])
@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_derivatives_over_the_end_of_the_master(algorithm: str, moved: float) -> None:
    """A slider beyond an end of its base by 0.8 or 0.4 of a segment, all nodes shaken.

    The condition of the node beyond is taken at the end, or merged, and the end is a point.
    """
    at_rest = {"integrator": "newton", "time.end": 1.0, "bodies.slider.velocity": [0.0, 0.0], "effects": []}
    scene = contactlab.load_scene("corner-slide").with_({**at_rest, "contacts.0.algorithm": algorithm})
    model = build(scene, scene.registry)
    contact, draw = model.contact, np.random.default_rng(1)
    assert isinstance(contact, ImplicitContactSystem)
    slider = np.unique(next(body.cells for body in model.bodies if body.name == "slider"))
    start, end = (model.reference + draw.uniform(-size, size, model.reference.shape) for size in (3e-3, 2e-3))
    for at in (start, end):
        at[slider] += moved, -0.01
    contact.begin_step(start, 0.0)
    contact.evaluate(end)
    (pair,) = contact.pairs
    corners: Any = pair.corners  # type: ignore[attr-defined]
    assert len(corners.moved) + len(corners.points) == 1
    c = contact.conditions
    chosen = np.flatnonzero(c.present & (c.gap < 0.0)).astype(np.int32)
    assert corners.moved[0].slot in chosen if corners.moved else chosen.max() >= pair.slots
    c.force[0, chosen] = draw.uniform(1.0, 3.0, len(chosen))
    c.force[1, chosen] = draw.uniform(-1.0, 1.0, len(chosen))
    answers = partial(answers_of, contact, forces=c.force.copy(), chosen=chosen)
    derivatives, move = contact.linearise(chosen), draw.uniform(-1.0, 1.0, end.shape)
    # truncation of the differences, see `against_differences`
    against_differences(derivatives, answers, end, move, (1e-7, 1e-7, 1e-5), algorithm)


def pressed(algorithm: str, *, friction: bool, wedge: bool, swap: bool = False, element: str = "q1") -> Results:
    """A soft block pressed onto the edge of a plate, which it overhangs, or onto a wedge."""
    size = 1 if element == "q1" else 2
    if wedge:
        corners = [[0.0, -2.4], [3.0, -1.2], [0.0, 0.0], [-3.0, -1.2]]
        mesh = {"use": "quad-block", "corners": corners, "cells": [10 // size, 10 // size]}
    else:
        mesh = {"use": "rectangle", "x": [-6.0, 0.0], "y": [-2.0, 0.0], "cells": [20 // size, 7 // size]}
    soft = {"use": "rectangle", "x": [-0.93, 1.57], "y": [0.0, 1.5], "cells": [10 // size, 6 // size]}
    law = {"use": "neo-hookean", "poisson": 0.3, "density": 1e-9}
    contact: dict[str, Any] = {"slave": "block.bottom", "master": ["master.right", "master.top"], "swap": swap}
    if friction:
        contact["friction"] = {"use": "coulomb", "mu": 0.2}
    held = ["master.bottom", "master.left"] if wedge else ["master.bottom"]
    scene = Scene.from_data({
        "integrator": {"use": "newton", "steps": 5},
        "materials": {"soft": {**law, "young": 4000.0}, "stiff": {**law, "young": 40000.0}},
        "bodies": {
            "block": {"element": element, "material": "soft", "mesh": soft},
            "master": {"element": element, "material": "stiff", "mesh": mesh},
        },
        "contacts": [{**contact, "algorithm": algorithm}],
        "supports": [
            *({"on": side, "ux": 0.0, "uy": 0.0} for side in held),
            {"on": "block.top", "ux": 0.0, "uy": {"ramp": "linear", "to": -0.05}},
        ],
        "record": {"frames": 5, "recorders": []},
    })  # fmt: skip
    results = contactlab.simulate(scene)
    assert results.status == "finished", results.reason
    return results


EDGES = [(False, False, "q1"), (False, True, "q1"), (True, False, "q1"), (True, True, "q1"), (True, True, "q2")]


@pytest.mark.parametrize(
    ("wedge", "friction", "element"),
    some(EDGES, [(False, True, "q1"), (True, True, "q2")]),
)
def test_a_block_on_an_edge_is_pressed_as_the_corner_alone_demands(wedge: bool, friction: bool, element: str) -> None:
    """With sides exchanged, nodes of the edge on segments of the block hold exactly what the corners do."""
    right = pressed("node-on-segment", friction=friction, wedge=wedge, swap=True, element=element)
    expected = right.history["block.top.fy"][-1]
    for algorithm in ALGORITHMS:
        results = pressed(algorithm, friction=friction, wedge=wedge, element=element)
        # 2 %: flat flanks are held by mean gaps there, and by nodes here
        assert results.history["block.top.fy"][-1] == pytest.approx(expected, rel=0.02)
        told = results.summary["contacts"]["contacts.0"]["resultant"]
        assert told == pytest.approx([-results.history[f"block.top.f{x}"][-1] for x in "xy"], rel=1e-6, abs=1e-6)
        assert np.isfinite(results.contact["contacts.0"].last.pressure).all()
