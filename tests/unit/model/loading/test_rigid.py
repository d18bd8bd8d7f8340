"""Rigid surfaces: chains, orientation, motion, reaction, and no say in the step."""

from __future__ import annotations

import math

import numpy as np
import pytest

from contactlab.errors import SceneError
from contactlab.model.build import build
from contactlab.model.model import Model
from contactlab.parts.registry import default_registry
from contactlab.scene.scene import Scene

FLOOR = {"line": [[4.0, -0.0], [-2.0, 0.0]]}


def on_rigid(make, surface: dict, **more) -> Model:  # type: ignore[no-untyped-def]
    contact = {"slave": "upper.bottom", "master": "tool", "algorithm": "mortar-p1"}
    return make(contacts=[contact], rigid={"tool": surface}, **more)


def tool(model: Model) -> np.ndarray:
    return next(support.nodes for support in model.loading.supports if support.on == "tool")


def test_a_line_is_cut_into_segments_of_the_slave(make) -> None:
    model = on_rigid(make, FLOOR)
    x = model.reference[tool(model)]
    assert x[0] == pytest.approx([4.0, 0.0])
    assert np.hypot(*np.diff(x, axis=0).T) == pytest.approx(np.full(12, 0.5))
    assert np.all(model.mass[tool(model)] == 0.0)


@pytest.mark.parametrize(("angles", "outward"), [([180.0, 360.0], 1.0), ([360.0, 180.0], -1.0)])
def test_angles_that_rise_put_the_solid_inside(make, angles: list[float], outward: float) -> None:
    """A half circle below its centre; normals are on the right of the chain."""
    arc = {"arc": {"centre": [1.0, -2.0], "radius": 2.0, "angles": angles}}
    if outward > 0.0:  # a roll below the block: the upper half faces it
        arc["arc"]["angles"] = [0.0, 180.0]
    else:  # a die round the block: its lower half faces it
        arc = {"arc": {"centre": [1.0, 3.0], "radius": 4.0, "angles": angles}}
    model = on_rigid(make, arc)
    chain, pair = model.reference[tool(model)], model.contact.pairs[0]
    a, b = (pair.master.segments[:, i] for i in range(2))
    along = model.reference[pair.master.nodes[b]] - model.reference[pair.master.nodes[a]]
    middle = 0.5 * (model.reference[pair.master.nodes[b]] + model.reference[pair.master.nodes[a]])
    from_centre = middle - np.array(arc["arc"]["centre"])
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1)
    assert np.all(outward * np.einsum("si,si->s", normal, from_centre) > 0.0)
    radius = np.hypot(*(chain - np.array(arc["arc"]["centre"])).T)
    assert radius == pytest.approx(np.full(len(chain), arc["arc"]["radius"]))


@pytest.mark.parametrize("element", ["q1", "q2"])
def test_a_closed_line_is_a_closed_chain(make, element: str) -> None:
    box = {"line": [[-2.0, -1.0], [-2.0, 3.0], [4.0, 3.0], [4.0, -1.0], [-2.0, -1.0]]}
    model = on_rigid(make, box, changes={"bodies.upper.element": element})
    master = model.contact.pairs[0].master
    assert np.all(master.node_segments >= 0)


@pytest.mark.parametrize(
    "line",
    [
        [[9.0, 4.0], [-9.0, 4.0]],  # a ceiling and a floor; a part of the body looks at them
        [[-9.0, -2.0], [9.0, -2.0]],
        [[-9.0, -3.0], [9.0, -3.0], [9.0, 9.0], [-9.0, 9.0], [-9.0, -3.0]],  # a box whose solid is within
    ],
)
def test_points_that_run_the_wrong_way_are_told(make, line: list) -> None:
    """Its whole outline is the slave, so that some of it always looks at the line. The other way round it has a gap."""
    contact = {
        "slave": ["upper.bottom", "upper.right", "upper.top", "upper.left"],
        "master": "tool",
        "algorithm": "mortar-p1",
    }
    with pytest.raises(SceneError, match="lies in the solid of the rigid surface tool") as caught:
        make(contacts=[contact], rigid={"tool": {"line": line}})
    assert "reverse order" in str(caught.value)
    assert make(contacts=[contact], rigid={"tool": {"line": line[::-1]}}).contact is not None


BOX = {
    "top": [[4.0, 0.0], [-2.0, 0.0]], "left": [[-2.0, 0.0], [-2.0, -2.0]],
    "under": [[-2.0, -2.0], [4.0, -2.0]], "right": [[4.0, -2.0], [4.0, 0.0]],
}  # fmt: skip
"""A solid below the block, which stands on its top and lies in the solid of each other face by itself."""


@pytest.mark.parametrize("lower", [0.0, 0.2, 3.0])
@pytest.mark.parametrize("reversed_", [(), ("top",), tuple(BOX)])
def test_each_surface_of_a_list_is_told_if_its_points_run_the_wrong_way(make, lower: float, reversed_: tuple) -> None:  # type: ignore[type-arg]
    """Also one that touches or lies less than a segment away; what another face of the solid hides counts for nothing.

    A second surface in the list looks at the block, so that some of the master always does.
    """
    lines = {name: [[x, y - lower] for x, y in line] for name, line in BOX.items()}
    lines = {name: line[::-1] if name in reversed_ else line for name, line in lines.items()}
    rigid = {name: {"line": line} for name, line in lines.items()} | {"ceiling": {"line": [[-9.0, 9.0], [9.0, 9.0]]}}
    contact = {"slave": ["upper.bottom", "upper.top"], "master": list(rigid), "algorithm": "mortar-p1"}
    if not reversed_:
        assert make(contacts=[contact], rigid=rigid).contact is not None
        return
    with pytest.raises(SceneError, match="lies in the solid of the rigid surface top"):
        make(contacts=[contact], rigid=rigid)


@pytest.mark.parametrize("cells", [6, 40])
@pytest.mark.parametrize("inside", [True, False])
def test_an_arc_that_runs_the_wrong_way_is_told_where_a_curve_lies_on_it(cells: int, inside: bool) -> None:
    """A quarter ring in or around it; facets of either stand in front of those of the other."""
    ring = {"use": "ring", "radii": [9.0, 10.0], "angles": [0.0, 90.0], "cells": [cells, 2]}
    angles = [100.0, -10.0] if inside else [-10.0, 100.0]
    data = {
        "time": {"end": 1.0}, "integrator": "newton",
        "materials": {"m": {"use": "linear-elastic", "young": 1.0, "poisson": 0.3, "density": 1.0}},
        "bodies": {"ring": {"element": "q1", "material": "m", "mesh": ring}},
        "rigid": {"drum": {"arc": {"centre": [0.0, 0.0], "radius": 10.0 if inside else 9.0, "angles": angles}}},
        "contacts": [{
            "slave": "ring.outer" if inside else "ring.inner", "master": "drum", "algorithm": "mortar-p1",
            "start": {"overlap": "adjust"},
        }],
        "supports": [{"on": "ring.start", "ux": 0.0, "uy": 0.0}],
    }  # fmt: skip
    assert build(Scene.from_data(data), default_registry()).contact is not None
    data["rigid"]["drum"]["arc"]["angles"] = angles[::-1]
    with pytest.raises(SceneError, match=r"lies in the solid of the rigid surface drum|face away from each other"):
        build(Scene.from_data(data), default_registry())


def test_a_blank_before_the_end_of_an_arc_lies_in_no_solid() -> None:
    """Level with the top of a die radius, before it: the last facet, prolonged, would pass over it."""
    blank = {"use": "rectangle", "x": [-10.0, 4.9], "y": [0.001, 0.1], "cells": [40, 1]}
    data = {
        "time": {"end": 1.0}, "integrator": "implicit-dynamics",
        "materials": {"m": {"use": "linear-elastic", "young": 1.0, "poisson": 0.3, "density": 1.0}},
        "bodies": {"blank": {"element": "q1", "material": "m", "mesh": blank}},
        "rigid": {"die": {"arc": {"centre": [5.0, -1.0], "radius": 1.0, "angles": [0.0, 90.0]}}},
        "contacts": [{"slave": "blank.bottom", "master": "die", "algorithm": "mortar-p1"}],
    }  # fmt: skip
    assert build(Scene.from_data(data), default_registry()).contact is not None


def test_a_body_on_one_of_two_faces_of_a_corner_lies_in_no_solid(make) -> None:
    """It may reach round the corner later; the face beside the corner has it behind itself."""
    rigid = {"top": {"line": [[9.0, 0.0], [-1.0, 0.0]]}, "side": {"line": [[-1.0, 0.0], [-1.0, -9.0]]}}
    contact = {"slave": "upper.bottom", "master": ["top", "side"], "algorithm": "mortar-p1"}
    assert make(contacts=[contact], rigid=rigid).contact is not None


def test_motion_is_that_of_the_table(make) -> None:
    """A quarter turn about (1, -1) while the centre moves up by 0.5: positions are exact at any time."""
    turn = {"to": 90.0, "about": [1.0, -1.0], "duration": 2e-4}
    model = on_rigid(make, {"line": [[4.0, -2.0], [-2.0, -2.0]], "turn": turn, "uy": {"ramp": "linear", "to": 0.5}})
    prescribed = model.prescribed
    for time in (0.0, 1e-4, 2e-4, 1e-3):
        angle = math.radians(90.0) * min(1.0, time / 2e-4)
        arm = model.reference[tool(model)] - [1.0, -1.0]
        turned = arm @ np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
        moved = np.zeros_like(model.reference)
        moved.reshape(-1)[prescribed.dof] = prescribed.scale * prescribed.values(time)[prescribed.ramp]
        expected = turned - arm + [0.0, 0.5 * time / 1e-3]
        assert moved[tool(model)] == pytest.approx(expected, abs=1e-14)


def test_a_small_turn_keeps_its_digits(make) -> None:
    """The displacement of a turn by 1e-9 rad is that of the first order; the second is below 4e-18."""
    surface = {"line": [[4.0, -2.0], [-2.0, -2.0]], "turn": {"to": math.degrees(1e-9), "ramp": "constant"}}
    model = on_rigid(make, surface)
    moved = model.prescribed.values(1e-3)[2:].reshape(-1, 2)  # behind the two values of the lower block's support
    x = model.reference[tool(model)]
    assert moved == pytest.approx(1e-9 * np.stack([-x[:, 1], x[:, 0]], axis=1), rel=1e-8, abs=4e-18)


def test_it_sets_no_step_limit_and_its_reaction_balances_the_contact(make) -> None:
    """A tool ten times finer than the block leaves the stable step; its reaction is minus the force on it."""
    coarse = on_rigid(make, FLOOR)
    model = on_rigid(make, {**FLOOR, "segment": 0.05, "uy": {"ramp": "linear", "to": 0.02}})
    assert model.stable_step() == coarse.stable_step()
    advance = model.bound_integrator().step
    for _ in range(4):
        advance(0.5 * model.stable_step())
    pushed = model.state["contact_force"][model.bodies[0].first : model.bodies[0].count].sum(axis=0)
    assert pushed[1] > 0.0
    assert model.reactions()["tool"] == pytest.approx(pushed, rel=1e-12, abs=1e-12 * pushed[1])


def test_a_rigid_slave_is_refused(make) -> None:
    contact = {"slave": "tool", "master": "upper.bottom", "algorithm": "mortar-p1"}
    with pytest.raises(SceneError, match="cannot be the slave") as caught:
        make(contacts=[contact], rigid={"tool": FLOOR})
    assert "contacts.0.slave" in str(caught.value)
    with pytest.raises(SceneError, match="cannot be the slave"):
        make(
            {"contacts.0.swap": True},
            contacts=[{**contact, "slave": "upper.bottom", "master": "tool"}],
            rigid={"tool": FLOOR},
        )


@pytest.mark.parametrize(
    ("surface", "word"),
    [
        ({}, "either a line or an arc"),
        ({"line": [[0.0, 0.0]]}, "at least two points"),
        ({"line": [[4.0, 0.0], [1.0, 0.0], [3.0, 0.0], [-2.0, 0.0]]}, "a reversal of direction"),
        ({"line": [[4.0, 0.0], [-2.0, 0.0], [-2.0, -2.0], [1.0, 1.0]]}, "through itself"),
        ({"arc": {"centre": [0.0, 0.0], "radius": 1.0, "angles": [0.0, 400.0]}}, "360"),
    ],
)
def test_shapes_that_are_none_are_refused(make, surface: dict, word: str) -> None:
    with pytest.raises(SceneError) as caught:
        on_rigid(make, surface)
    assert word in str(caught.value)
