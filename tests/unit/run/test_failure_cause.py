"""A failed load step says how far it went, where, why, and what to try; no cause is named where there is none."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from contactlab.api import Iteration, StepStatus
from contactlab.model.build import build
from contactlab.model.model import Model
from contactlab.parts.registry import default_registry
from contactlab.run.failure_cause import cause_of_failure, friction_share
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene, load_scene

SOFT = {"use": "linear-elastic", "young": 1000.0, "poisson": 0.25, "density": 1e-9}


def pushed(mu: float, push: float) -> Scene:
    """A block on a floor, pressed by 8 N/mm and then pushed along it, evenly over its top."""
    data = {
        "time": {"end": 1.0},
        "integrator": {"use": "newton", "steps": 4},
        "materials": {"soft": SOFT},
        "bodies": {
            "block": {
                "element": "q1", "material": "soft",
                "mesh": {"use": "rectangle", "x": [0.0, 2.0], "y": [0.0, 0.25], "cells": [4, 1]},
            },
        },
        "rigid": {"floor": {"line": [[4.0, 0.0], [-2.0, 0.0]]}},
        "contacts": [
            {
                "slave": "block.bottom", "master": "floor", "algorithm": "mortar-p1",
                "enforcement": {"use": "active-set", "start": "stick"}, "friction": {"use": "coulomb", "mu": mu},
            }
        ],
        "loads": [
            {"on": "block.top", "ty": {"ramp": "linear", "to": -4.0, "duration": 0.5}},
            {"on": "block.top", "tx": {"ramp": "linear", "to": push, "begin": 0.5, "duration": 0.5}},
        ],
        "record": {"frames": 1, "recorders": []},
    }  # fmt: skip
    return Scene.from_data(data)


def test_used_up_friction_is_a_limit_load() -> None:
    """Friction carries 0.5 * 8 of the 5 that are pushed with: the load is all of 4.0 MPa down and 80 % of 2.5 aside."""
    results = simulate(pushed(0.5, 2.5))
    assert results.status == "not-converged"
    share = 100.0 * results.summary["reached"]["share"]
    assert share == pytest.approx(100.0 * (4.0 + 0.8 * 2.5) / 6.5, abs=0.1)
    assert results.reason.startswith(f"stopped at {share:.4g} % of the load, after step ")
    # where values end at times of their own, the share of the loading is none of theirs
    assert ", with loads.0.ty at 100 % and loads.1.tx at " in results.reason
    assert float(results.reason.partition("loads.1.tx at ")[2].split()[0]) == pytest.approx(80.0, abs=0.1)
    told = re.search(r"block\.bottom on floor: friction of contacts\.0 carries ([0-9.]+)% of its limit", results.reason)
    assert told, results.reason
    assert float(told[1]) > 99.0
    assert "nothing else holds block against sliding along x: this is a limit load" in results.reason
    # the advice: less load, or more friction
    assert simulate(pushed(0.5, 1.9)).status == simulate(pushed(0.8, 2.5)).status == "finished"


@pytest.mark.full
def test_a_belt_that_slides_round_its_drum_is_a_limit_load() -> None:
    """No rigid motion of it is free: the drum has facets, and the pulls at its ends turn with them."""
    radius, thick, mu, most = 10.0, 0.1, 0.2, 1.6
    arc = {"centre": [0.0, 0.0], "radius": radius, "angles": [-30.0, 210.0]}
    pulls = {"start": [[0.0, 0.0], [0.4, -10.0], [1.0, -10.0]], "end": [[0.0, 0.0], [0.4, -10.0], [1.0, -10.0 * most]]}
    results = simulate(Scene.from_data({
        "time": {"end": 1.0},
        "integrator": {"use": "newton", "steps": 5},
        "materials": {"soft": {**SOFT, "use": "neo-hookean", "young": 2e4, "poisson": 0.0}},
        "bodies": {"belt": {"element": "q2", "material": "soft", "mesh": {
            "use": "ring", "radii": [radius, radius + thick], "cells": [6, 1], "angles": [45.0, 135.0]}}},
        "rigid": {"drum": {"arc": arc, "segment": 0.9}},
        "contacts": [{"slave": "belt.inner", "master": "drum", "algorithm": "mortar-p1",
                      "friction": {"use": "coulomb", "mu": mu}}],
        "loads": [{"on": f"belt.{end}", "pressure": {"ramp": "table", "to": 1.0, "points": points}}
                  for end, points in pulls.items()],
        "record": {"frames": 1, "recorders": []},
    }))  # fmt: skip
    assert results.status == "not-converged"
    assert "nothing else holds belt against sliding along its contacts: this is a limit load" in results.reason
    # Euler and Eytelwein: the pull on the belt's middle; 0.5 %: facets, and the last step that fails
    limit = np.exp(mu * np.radians(90.0) * radius / (radius + 0.5 * thick))
    pull = 1.0 + (results.summary["reached"]["time"] - 0.4) / 0.6 * (most - 1.0)
    assert pull == pytest.approx(limit, rel=5e-3)


@pytest.mark.parametrize("push", [0.0, 0.0399])
def test_friction_that_pulls_both_ways_is_no_limit_load(push: float) -> None:
    """Pressed by 4 MPa, a block widens: at mu = 0.01 all of it slides outwards, until it is pushed to one side."""
    scene = pushed(0.01, push).with_({
        "bodies.block.mesh.cells": [40, 2], "contacts.0.enforcement": {"use": "active-set", "start": "slip"},
    })  # fmt: skip
    model = build(scene, default_registry())
    advance = model.bound_integrator().step
    for _ in range(4):
        assert advance(0.25).status is StepStatus.accepted
    assert model.contact is not None
    (pair,) = model.contact.pairs
    share = friction_share(model.contact.conditions, pair.first_slot, pair.slots)
    assert share > 0.9  # all nodes but those in the middle, which do not move
    assert ("limit load" in cause_of_failure(model, scene, (), 0.1)) is (push > 0.0)


@pytest.mark.full
def test_a_body_that_tips_is_a_limit_load() -> None:
    """A block 1 wide and 3 high under 2 N/mm, pushed at its head: it tips at F = 2 * 0.5 / 3, in 4 of 5 of the push."""
    scene = pushed(1.5, 1.25 / 3.0).with_({
        "bodies.block.mesh.x": [0.0, 1.0], "bodies.block.mesh.y": [0.0, 3.0], "bodies.block.mesh.cells": [4, 6],
        "loads.0.ty.to": -2.0, "materials.soft.young": 1e6,
    })  # fmt: skip
    results = simulate(scene)
    assert results.status == "not-converged"
    assert results.summary["reached"]["share"] == pytest.approx((2.0 + 1.0 / 3.0) / (2.0 + 1.25 / 3.0), abs=2e-3)
    assert "near (1, 0), block.bottom on floor: body block tips" in results.reason
    assert "this is a limit load" in results.reason


def test_friction_that_is_none_is_not_to_be_less() -> None:
    reason = simulate(pushed(0.0, 2.5)).reason
    assert "no support holds block against sliding along x; hold it: " in reason
    assert "less friction" not in reason


@pytest.mark.parametrize("algorithm", ["mortar-p1", "midplane", pytest.param("barrier", marks=pytest.mark.full)])
def test_friction_that_is_too_little_from_the_start_is_named(algorithm: str) -> None:
    """Pressed and pushed at once by more than mu: no increment has an equilibrium, and a law of friction is there.

    Potentials have no multipliers, and a barrier opens surfaces that touch: they hold as others do.
    """
    scene = pushed(0.3, 2.0).with_({
        "contacts.0.algorithm": algorithm,
        "contacts.0.enforcement": "active-set" if algorithm.startswith("mortar") else None,
        "loads.0.ty.duration": 1.0, "loads.1.tx.begin": 0.0, "loads.1.tx.duration": 1.0,
    })  # fmt: skip
    reason = simulate(scene).reason
    assert "only friction holds block against sliding along x, and it is too weak from the start" in reason


@pytest.mark.full
def test_friction_is_not_blamed_for_a_body_that_tips_from_the_start() -> None:
    """Pressed straight down with its middle 0.1 beyond the end of the floor: nothing pushes it along."""
    scene = pushed(0.5, 0.0).with_({
        "contacts.0.algorithm": "node-on-segment", "rigid.floor.line": [[0.9, 0.0], [-2.0, 0.0]],
    })  # fmt: skip
    reason = simulate(scene).reason
    assert "no pressures of the nodes that touch, with their friction, balance the loads of block" in reason
    assert "too weak" not in reason


def built(changes: dict[str, Any] | None = None) -> tuple[Model, Scene]:
    scene = load_scene("disc-on-block").with_({"integrator": "newton", "level": 1} | (changes or {}))
    return build(scene, default_registry()), scene


def restless(model: Model, *slots: int, states: Sequence[int] = (0, 1)) -> list[Iteration]:
    """Iterations in which conditions change their state again and again."""
    assert model.contact is not None
    still = np.zeros(sum(pair.slots for pair in model.contact.pairs), int)
    found = []
    for k in range(6):
        seen = still.copy()
        seen[list(slots)] = states[k % 2]
        found.append(Iteration(1.0, 1.0, 1, 0, 1, 1.0, statuses="".join(map(str, seen))))
    return found


def test_nodes_that_change_their_states_are_named_with_their_place_and_accepted_advice() -> None:
    model, scene = built()
    told = cause_of_failure(model, scene, restless(model, 3, 5), 0.1)
    x, y = model.position[model.contact.pairs[0].slave.nodes[3]]  # type: ignore[union-attr]
    assert told.startswith(f"near ({float(f'{x:.4g}'):g}, {float(f'{y:.4g}'):g}), disc.")
    count = len(model.contact.pairs[0].slave.nodes)  # type: ignore[union-attr]
    assert f": nodes switch between open and closed in the last iterations, 2 of {count}; try" in told
    assert "contacts.0.swap = true, finer cells (level = 2)" in told
    scene.with_({"contacts.0.swap": True, "level": 2})
    assert "between stick and slip" in cause_of_failure(model, scene, restless(model, 3, states=(1, 2)), 0.1)


def test_without_changes_no_cause_is_invented() -> None:
    model, scene = built()
    assert cause_of_failure(model, scene, (), 0.1).startswith("no equilibrium found")


def test_a_restless_node_at_a_corner_of_the_master_names_the_corner() -> None:
    """A step in the floor, below the middle of the slave."""
    scene = pushed(0.3, 1.0).with_({"rigid.floor.line": [[1.0, -1.0], [1.0, 0.0], [-1.0, 0.0]]})
    model = build(scene, default_registry())
    told = cause_of_failure(model, scene, restless(model, 2), 0.1)
    assert told.startswith("near (1, 0), block.bottom on floor: floor has a sharp corner there (90 degrees)")
    assert told.endswith("try a fillet of about 1.5 (3 segments)")
    # three segments of a floor that is 1 wide and high have no room on it
    scene = scene.with_({"rigid.floor.line": [[1.0, -1.0], [1.0, 0.0], [0.0, 0.0]]})
    model = build(scene, default_registry())
    told = cause_of_failure(model, scene, restless(model, 2), 0.1)
    assert told.endswith("try cells there of at most 0.33 (0.5 now), and a fillet (3 segments)")
    assert "corner" not in cause_of_failure(model, scene, restless(model, 0), 0.1)


@pytest.mark.parametrize(("algorithm", "told"), [("node-on-segment", True), ("mortar-p1", False)])
def test_a_pressed_node_over_a_vertex_of_a_round_master_is_told(algorithm: str, told: bool) -> None:
    """A node of the block is moved below one of the disc, where its force jumps; mortars average over segments."""
    model, scene = built({"contacts.0.algorithm": algorithm, "contacts.0.swap": True})
    assert model.contact is not None
    pair = model.contact.pairs[0]
    vertex = model.position[pair.master.nodes[len(pair.master.nodes) // 2]]
    node = int(np.argmin(np.hypot(*(model.position[pair.slave.nodes] - vertex).T)))
    model.position[pair.slave.nodes[node]] = vertex - np.array([0.0, 1e-4])
    model.state["multipliers"][0, pair.first_slot + node] = 1.0
    reason = cause_of_failure(model, scene, (), 0.1)
    assert ("a node of the slave lies over a vertex of the master" in reason) is told
    if told:
        assert reason.startswith(f"near ({float(f'{vertex[0]:.4g}'):g}, ")
        assert "try contacts.0.swap = false, or a mortar" in reason
    # more steps do not help a node that switches there, and do elsewhere
    for restless_node, there in ((node, told), (node + 5, False)):
        trace = restless(model, pair.first_slot + restless_node, states=(1, 2))
        reason = cause_of_failure(model, scene, trace, 0.1)
        assert ("over a vertex" in reason) is there
        assert ("more integrator.steps" in reason) is not there


@pytest.mark.parametrize(("share", "buckles"), [(0.9, False), (1.1, True)])
def test_a_column_beyond_its_buckling_load_is_told(share: float, buckles: bool) -> None:
    """Euler's load of a slender column between clamped ends: strains of 4 pi^2 I / (A L^2), with cells that bend."""
    length, height = 20.0, 0.5
    scene = Scene.from_data({
        "integrator": "newton",
        "time": {"end": 1.0},
        "materials": {"soft": {**SOFT, "use": "neo-hookean", "poisson": 0.0}},
        "bodies": {
            "column": {
                "element": "q2", "material": "soft",
                "mesh": {"use": "rectangle", "x": [0.0, length], "y": [0.0, height], "cells": [20, 1]},
            }
        },
        "supports": [
            {"on": "column.left", "ux": 0.0, "uy": 0.0},
            {"on": "column.right", "ux": {"ramp": "linear", "to": -0.1}, "uy": 0.0},
        ],
    })  # fmt: skip
    model = build(scene, default_registry())
    strain = share * np.pi**2 / 3.0 * (height / length) ** 2
    model.state["displacement"][:, 0] = -strain * model.reference[:, 0]
    told = cause_of_failure(model, scene, (), 0.1)
    assert told.startswith("body column, around (9.9") is buckles
    assert (
        "its stiffness is no longer positive definite: it buckles or snaps through; try implicit-dynamics" in told
    ) is buckles
