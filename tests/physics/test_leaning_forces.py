"""Mortar contact of a slave that slides over a corner of the master: it is held there, and else told."""

from __future__ import annotations

import numpy as np
import pytest
from tiers import some

import contactlab
from contactlab.model.contact import plan
from contactlab.results.results import Results
from contactlab.scene.scene import Scene


def slid(**changes: object) -> Results:
    """A slider that leaves its base over the edge."""
    shown = {"record.frames": 100, "record.recorders": []}
    results = contactlab.simulate(contactlab.load_scene("corner-slide").with_({**changes, **shown}))
    assert results.status == "finished", results.reason
    return results


@pytest.mark.parametrize("swap", some([False, True], [False]))
def test_a_mortar_is_held_at_a_corner(swap: bool) -> None:
    """The slider presses with 4 N and tips, with either side as slave."""
    held = slid(**{"contacts.0.swap": swap, "bodies.slider.mesh.cells": [8, 2], "bodies.base.mesh.cells": [18, 4]})
    assert held.warnings == []
    # 8 %: vibrations of the block when it is put down, 5 %, and as it tips
    largest = np.abs(held.history["contacts.0.fy"]).max()
    assert largest == pytest.approx(4.0, rel=0.08)
    # what a corner gives a node stands on no less than half of the length of an end node, half a segment of 0.5 mm
    if not swap:
        assert held.summary["peaks"]["contacts"]["contacts.0"]["pressure"]["value"] < largest / (0.5 * 0.25)


@pytest.mark.parametrize(("element", "mu"), [("q1", 0.0), ("q2", 0.3)])
@pytest.mark.parametrize("share", [0.1, 0.9])
def test_a_corner_within_a_segment_holds_it_alone_however_its_flanks_are_turned(
    element: str, mu: float, share: float
) -> None:
    """A square turned by 30, 45 and 60 degrees is pressed on a hard corner, a share of a segment beyond a node.

    It sees both flanks at all angles, and touches none: only the corner's own elasticity turns with it, and all
    mortars have the same forces, without friction those of a node on a segment.
    """

    def force(degrees: float, algorithm: str) -> float:
        along = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
        inward = np.array([-along[1], along[0]])
        rows = [0.0, 0.5, 1.0]
        places = [(u - 0.5 - 0.5 * share) * along + v * inward for v in rows for u in rows]
        edges = {"low": np.array([[0, 1], [1, 2]]), "top": np.array([[8, 7], [7, 6]])}
        cells = np.array([[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]])
        square = contactlab.mesh(np.array(places), cells, {name: ends.T for name, ends in edges.items()})
        hard = {"use": "rectangle", "x": [0.0, 2.0], "y": [-2.0, 0.0], "cells": [1, 1]}
        law = {"use": "linear-elastic", "young": 1e3, "poisson": 0.3, "density": 1e-9}
        contact = {"slave": "square.low", "master": ["corner.left", "corner.top"], "algorithm": algorithm}
        push = -0.02 * inward
        scene = Scene.from_data({
            "integrator": "newton",
            "materials": {"soft": law, "hard": {**law, "young": 1e6}},
            "bodies": {"square": {"element": element, "material": "soft", "mesh": square},
                       "corner": {"element": "q1", "material": "hard", "mesh": hard}},
            "contacts": [contact | ({"friction": {"use": "coulomb", "mu": mu}} if mu else {})],
            "supports": [{"on": "corner.bottom", "ux": 0.0, "uy": 0.0},
                         {"on": "square.top", "ux": float(push[0]), "uy": float(push[1])}],
        })  # fmt: skip
        results = contactlab.simulate(scene)
        assert results.status == "finished", results.reason
        return float(np.array(results.summary["reactions"]["square.top"]) @ -inward)

    forces = [force(degrees, "mortar-p1") for degrees in (30.0, 45.0, 60.0)]
    # 2e-3: the corner is a thousand times as stiff
    assert forces == pytest.approx(forces[1:2] * 3, rel=2e-3)
    others = ["mortar-p0", "mortar-dual", *["node-on-segment"] * (not mu)]
    assert [force(60.0, other) for other in others] == pytest.approx(forces[2:] * len(others), rel=1e-6)


def test_what_is_not_held_at_a_corner_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """With mean gaps alone, as over corners that are none by the rule, forces are twice as large."""
    monkeypatch.setattr(plan, "corners_of", lambda *_: np.zeros(0, np.int32))
    leaning = slid(**{"bodies.slider.mesh.x": [5.0, 9.0], "time.end": 5.2e-4})  # 1 mm from the edge, not 4
    (warning,) = leaning.warnings
    assert (warning.code, warning.key) == ("leaning-forces", "contacts.0.swap")
    assert "near (10" in warning.text  # the edge of the base
    assert np.abs(leaning.history["contacts.0.fy"]).max() > 1.5 * 4.0 * 1.08


def test_a_master_of_two_bodies_is_no_corner() -> None:
    """Each bears half of a block that falls on both; no body's force is told by a chain that it shares."""

    def block(x: list[float], y: list[float]) -> dict[str, object]:
        mesh = {"use": "rectangle", "x": x, "y": y, "cells": [4, 2]}
        return {"element": "q1", "material": "m", "mesh": mesh}

    low = {"left": block([-1.0, 0.0], [-1.0, 0.0]), "right": block([0.5, 1.5], [-1.0, 0.0])}
    high = block([-0.75, 1.25], [0.01, 1.0]) | {"velocity": [0.0, -1e4]}
    scene = Scene.from_data({
        "time": {"end": 4e-6},
        "integrator": "central-difference",
        "materials": {"m": {"use": "linear-elastic", "young": 1000.0, "poisson": 0.3, "density": 1e-9}},
        "bodies": {**low, "high": high},
        "contacts": [{"slave": "high.bottom", "master": ["left.top", "right.top"], "algorithm": "mortar-p0"}],
        "supports": [{"on": f"{name}.bottom", "ux": 0.0, "uy": 0.0} for name in low],
        "record": {"frames": 20, "recorders": []},
    })  # fmt: skip
    results = contactlab.simulate(scene)
    assert results.status == "finished", results.reason
    assert np.abs(results.history["contacts.0.fy"]).max() > 0.0
    assert "leaning-forces" not in {warning.code for warning in results.warnings}


def test_a_block_between_two_walls_has_forces_that_add_up_to_none() -> None:
    """It is shortened until it fills a channel: forces of both walls cancel, and lean by nothing."""
    young, poisson, wide, gap, push = 100.0, 0.3, 2.0, 0.001, 0.008
    scene = Scene.from_data({
        "integrator": "central-difference",
        "materials": {"m": {"use": "linear-elastic", "young": young, "poisson": poisson, "density": 1e-9}},
        "bodies": {"block": {"element": "q1", "material": "m",
                             "mesh": {"use": "rectangle", "x": [-1.0, 1.0], "y": [0.0, 1.0], "cells": [4, 3]}}},
        "rigid": {"left": {"line": [[-1.0 - gap, -1.0], [-1.0 - gap, 2.0]]},
                  "right": {"line": [[1.0 + gap, 2.0], [1.0 + gap, -1.0]]}},
        "contacts": [{"slave": f"block.{to}", "master": to, "algorithm": "mortar-p1"} for to in ("left", "right")],
        "supports": [{"on": "block.bottom", "uy": 0.0}, {"on": "block.top", "uy": {"ramp": "parabola", "to": -push}}],
        "record": {"frames": 20, "recorders": []},
    })  # fmt: skip
    results = contactlab.simulate(scene)
    assert results.status == "finished", results.reason
    stiffness = young / (1.0 + poisson) / (1.0 - 2.0 * poisson)
    side = stiffness * (poisson * push - (1.0 - poisson) * 2.0 * gap / wide)  # plane strain, uniform
    # 1e-3: what is left of vibrations when a quasi-static run counts as settled
    assert abs(results.summary["reactions"]["left"][0]) == pytest.approx(side, rel=1e-3)
    assert results.warnings == []
