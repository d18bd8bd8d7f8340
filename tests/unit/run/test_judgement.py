"""What a finished run says of itself, each with its number beside a closed form, and sound runs that say nothing."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from contactlab.errors import SimulationFailure
from contactlab.model.build import build
from contactlab.parts.registry import default_registry
from contactlab.results.sample import take_sample
from contactlab.run import judgement, resolution
from contactlab.run.contact_guard import ContactGuard
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene, load_scene

ELASTIC = {"use": "neo-hookean", "young": 1000.0, "poisson": 0.25, "density": 1e-6}


def block(y: tuple[float, float], x: tuple[float, float] = (0.0, 1.0)) -> dict[str, Any]:
    return {"element": "q1", "material": "m", "mesh": {"use": "rectangle", "x": list(x), "y": list(y), "cells": [3, 2]}}


def pressed(by: float, integrator: str = "newton") -> Scene:
    """Two blocks 0.1 apart, the upper one moved down by `by`."""
    data = {
        "time": {"end": 1e-3},
        "integrator": integrator,
        "materials": {"m": ELASTIC},
        "bodies": {"upper": block((0.1, 1.1)), "lower": block((-1.0, 0.0))},
        "contacts": [{"slave": "upper.bottom", "master": "lower.top", "algorithm": "mortar-p0"}],
        "supports": [
            {"on": "lower.bottom", "ux": 0.0, "uy": 0.0},
            {"on": "upper.top", "ux": 0.0, "uy": {"ramp": "linear", "to": -by}},
        ],
        "record": {"frames": 2, "recorders": []},
    }
    return Scene.from_data(data)


@pytest.mark.parametrize("integrator", ["newton", "central-difference"])
def test_a_contact_that_never_closes_is_told_with_its_distance(integrator: str) -> None:
    results = simulate(pressed(0.04, integrator))
    assert results.status == "finished"
    (warning,) = results.warnings
    assert (warning.code, warning.key) == ("open-contact", "contacts.0")
    assert warning.value == pytest.approx(0.06, rel=0.05)  # an explicit one still swings
    assert "open-contact" not in [w.code for w in simulate(pressed(0.12, integrator)).warnings]


def test_forces_of_round_off_close_no_contact() -> None:
    """A strain of 1e-12 over the scene is what positions of 16 digits leave."""
    model = build(pressed(0.04), default_registry())
    guard, forces = ContactGuard(model, "shorter steps"), model.state["multipliers"][0]
    for force, closed in ((1e-12, False), (1e-6, True)):
        forces[0] = force
        guard.after_step(0.0)
        assert guard.closed.any() == closed


def test_a_contact_that_closed_and_opened_again_is_not_open() -> None:
    scene = pressed(0.12).with_({"supports.1.uy": {"ramp": "table", "points": [[0.0, 0.0], [5e-4, 1.0], [1e-3, 0.0]],
                                                   "to": -0.12}})  # fmt: skip
    results = simulate(scene)
    assert results.status == "finished"
    assert results.contact["contacts.0"].last.pressure.max() == 0.0
    assert "open-contact" not in [w.code for w in results.warnings]


@pytest.mark.parametrize(("algorithm", "told"), [("mortar-p1", [-0.02, -0.02]), ("node-on-segment", [])])
def test_a_side_within_the_other_without_a_force_is_told(algorithm: str, told: list[float]) -> None:
    """A pin of half width 0.9 to 1.02 in a slot of half width 1: one node of each flank lies within.

    Held there the pin needs 50 N. Over the 0.28 of its segment the gap goes from -0.02 to 0.04: its mean with the hat
    of that node is zero.
    """
    elastic = {"use": "neo-hookean", "poisson": 0.3, "density": 1e-9}
    rubs = {"use": "coulomb", "mu": 0.2}
    corners = [[-0.9, 0.05], [0.9, 0.05], [1.02, 0.6], [-1.02, 0.6]]
    bodies: dict[str, Any] = {
        "pin": {"element": "q1", "material": "pin", "mesh": {"use": "quad-block", "corners": corners, "cells": [6, 2]}}
    }
    for name, x in (("left", [-4.0, -1.0]), ("right", [1.0, 4.0])):
        mesh = {"use": "rectangle", "x": x, "y": [-3.0, 0.0], "cells": [6, 6]}
        bodies[name] = {"element": "q1-fbar", "material": "jaw", "mesh": mesh}
    scene = Scene.from_data({
        "integrator": "newton",
        "materials": {"pin": {**elastic, "young": 2e4}, "jaw": {**elastic, "young": 1e4}},
        "bodies": bodies,
        "supports": [
            {"on": "pin.top", "ux": 0.0, "uy": {"ramp": "linear", "to": -1.9}},
            {"on": "left.left", "ux": 0.0, "uy": 0.0},
            {"on": "right.right", "ux": 0.0, "uy": 0.0},
        ],
        "contacts": [
            {"slave": f"pin.{side}", "master": master, "algorithm": algorithm, "friction": rubs}
            for side, master in (("left", ["left.right", "left.top"]), ("right", ["right.top", "right.left"]))
        ],
        "record": {"frames": 1, "recorders": []},
    })  # fmt: skip
    results = simulate(scene)
    assert results.status == "finished"
    held = abs(results.summary["reactions"]["pin.top"][1])
    assert held == pytest.approx(0.0 if told else 50.3, rel=0.01, abs=1e-6)
    assert [w.value for w in results.warnings if w.code == "open-contact"] == pytest.approx(told, rel=0.01)


@pytest.mark.parametrize(("share", "told"), [(0.97, []), (1.03, [0.15])])
@pytest.mark.parametrize("algorithm", ["mortar-p0", "mortar-p1"])
def test_a_body_that_stands_beside_its_support_is_told(algorithm: str, share: float, told: list[float]) -> None:
    """Its middle is beyond the end of the base by 0.03 x 4, 0.15 of its segments of 0.8."""
    end = share * 4.0
    meshes = {"block": ([end - 8.0, end], [0.0, 1.0]), "base": ([-8.0, 0.0], [-1.0, 0.0])}
    results = simulate(Scene.from_data({
        "integrator": "newton",
        "materials": {"m": {"use": "linear-elastic", "young": 1e5, "poisson": 0.3, "density": 1e-9}},
        "bodies": {
            name: {"element": "q1", "material": "m", "mesh": {"use": "rectangle", "x": x, "y": y, "cells": [10, 2]}}
            for name, (x, y) in meshes.items()
        },
        "supports": [{"on": "base.bottom", "ux": 0.0, "uy": 0.0}],
        "effects": [{"use": "gravity", "acceleration": [0.0, -9810.0], "on": ["block"]}],
        "contacts": [{"slave": "block.bottom", "master": "base.top", "algorithm": algorithm,
                      "friction": {"use": "coulomb", "mu": 0.5}}],
        "record": {"frames": 1, "recorders": []},
    }))  # fmt: skip
    assert results.status == "finished"
    assert [w.value for w in results.warnings if w.code == "outside-cover"] == pytest.approx(told, rel=0.01)


@pytest.mark.parametrize("share", [0.1, 0.3])
def test_a_pressure_of_another_force_stops_a_run(share: float) -> None:
    if share < judgement.WRONG:
        judgement._judge_pressure("contacts.0", share, 7)
        return
    with pytest.raises(
        SimulationFailure, match=r"step 7: contacts.0: integrated contact pressure and contact force differ by 30%"
    ) as stopped:
        judgement._judge_pressure("contacts.0", share, 7)
    assert stopped.value.status == "not-converged"


def test_friction_that_nobody_delivers_is_an_error() -> None:
    model = build(pressed(0.12).with_({"contacts.0.friction": {"use": "coulomb", "mu": 0.2}}), default_registry())
    pair = model.contact.pairs[0]  # type: ignore[union-attr]
    multipliers = model.state["multipliers"]
    multipliers[0] = 1.0
    judgement._judge_friction(model, pair)  # like bodies that are pressed straight: no slip, no force
    model.contact.conditions.slip[0] = 1e-3  # type: ignore[union-attr]
    with pytest.raises(SimulationFailure, match=r"friction is declared, and MortarP0 and \w+ gave no") as found:
        judgement._judge_friction(model, pair)
    assert found.value.status == "failed"
    multipliers[1, 0] = 1e-12
    judgement._judge_friction(model, pair)
    multipliers[0, 2:] = multipliers[1] = 0.0  # two may be the middle of a symmetric pair
    judgement._judge_friction(model, pair)


def loaded(ramp: str) -> Scene:
    data = {
        "time": {"end": 1.0},
        "integrator": {"use": "newton", "steps": 5},
        "materials": {"m": ELASTIC},
        "bodies": {"lower": block((-1.0, 0.0))},
        "supports": [{"on": "lower.bottom", "ux": 0.0, "uy": 0.0}],
        "loads": [{"on": "lower.top", "pressure": {"ramp": ramp, "to": 100.0}}],
        "record": {"frames": 2, "recorders": []},
    }
    return Scene.from_data(data)


@pytest.mark.parametrize("ramp", ["constant", "linear"])
def test_the_ledger_of_a_static_load_closes(ramp: str) -> None:
    """Also of one that is there from the start: on its way into balance it does the work that the body stores."""
    results = simulate(loaded(ramp))
    assert results.summary["balance"]["ledger_error"] < 1e-12  # round-off of sums over five steps
    assert "ledger" not in [warning.code for warning in results.warnings]


def test_work_that_unloading_gives_back_is_no_jump() -> None:
    """A block is pressed on a wider one and let go: works of the stresses cancel to a millionth of the largest."""
    to_and_fro = {"ramp": "table", "to": 20.0, "points": [[0.0, 0.0], [1.0, 1.0], [2.0, 0.0]]}
    data = pressed(0.12).data
    data["bodies"] = {"upper": block((0.0, 1.0)), "lower": block((-1.0, 0.0), (-1.0, 2.0))}
    data["supports"] = data["supports"][:1]
    data["loads"] = [{"on": "upper.top", "pressure": to_and_fro}]
    data |= {"time": {"end": 2.0}, "integrator": {"use": "newton", "steps": 8}}
    results = simulate(Scene.from_data(data))
    assert results.status == "finished", results.reason
    assert abs(results.history["energy.internal"][-1]) > 1e3 * abs(results.history["energy.stored"][-1])
    assert not results.warnings


def press_fit(cells: int, finer: float = 1.25) -> Scene:
    """A quarter of a shaft in a hub, 0.02 too thick: radius 5, as many facets as there are cells along the arc."""

    def quarter(inner: float, outer: float, along: int) -> dict[str, Any]:
        mesh = {"use": "ring", "radii": [inner, outer], "angles": [0.0, 90.0], "cells": [along, 2]}
        return {"element": "q1", "material": "m", "mesh": mesh}

    data = {
        "time": {"end": 1.0},
        "integrator": {"use": "newton", "steps": 2},
        "materials": {"m": ELASTIC},
        "bodies": {"shaft": quarter(2.5, 5.02, cells), "hub": quarter(5.0, 10.0, round(finer * cells))},
        "contacts": [
            {"slave": "shaft.outer", "master": "hub.inner", "algorithm": "mortar-p1", "start": {"overlap": "ramp"}}
        ],
        "supports": [
            {"on": "shaft.start", "uy": 0.0}, {"on": "hub.start", "uy": 0.0},
            {"on": "shaft.end", "ux": 0.0}, {"on": "hub.end", "ux": 0.0},
        ],
        "record": {"frames": 1, "recorders": []},
    }  # fmt: skip
    return Scene.from_data(data)


@pytest.mark.parametrize(("cells", "told"), [(12, True), (30, True), (48, False)])
def test_facets_deeper_than_the_interference_are_told(cells: int, told: bool) -> None:
    results = simulate(press_fit(cells))
    assert results.status == "finished", results.reason
    found = [warning for warning in results.warnings if warning.code == "coarse-facets"]
    assert len(found) == told
    for warning in found:
        assert warning.value == pytest.approx(5.02 * (1.0 - math.cos(math.pi / 4.0 / cells)), rel=0.02)
        assert warning.limit == pytest.approx(0.05 * 0.02, rel=0.5)
        factor = re.search(r"cells that are ([\d.]+) times finer", warning.text)
        assert factor is not None
        assert 1.0 < float(factor[1]) >= math.sqrt(warning.value / warning.limit) * (1.0 - 1e-9)


def test_facets_of_like_meshes_fit_however_deep_they_are() -> None:
    """Their pressure is even to 0.3 %: bilinear rings of two cells."""
    results = simulate(press_fit(12, finer=1.0))
    pressure = results.contact["contacts.0"].last.pressure
    assert np.ptp(pressure) < 0.01 * pressure.mean()
    assert "coarse-facets" not in {warning.code for warning in results.warnings}


def roller(cells: int) -> Scene:
    """A half disc of radius 6 on a block, pressed by 0.03."""
    data = {
        "time": {"end": 1.0},
        "integrator": {"use": "newton", "steps": 2},
        "materials": {"m": ELASTIC},
        "bodies": {
            "roller": {
                "element": "q1", "material": "m",
                "mesh": {"use": "arc-block", "radius": 6.0, "half_width": 3.0, "top": 3.0, "cells": [cells, 6]},
            },
            "race": {
                "element": "q1", "material": "m",
                "mesh": {"use": "rectangle", "x": [-4.0, 4.0], "y": [-3.0, 0.0], "cells": [round(1.25 * cells), 6]},
            },
        },
        "contacts": [{"slave": "roller.arc", "master": "race.top", "algorithm": "mortar-p1"}],
        "supports": [
            {"on": "race.bottom", "ux": 0.0, "uy": 0.0},
            {"on": "roller.top", "ux": 0.0, "uy": {"ramp": "linear", "to": -0.03}},
        ],
        "record": {"frames": 1, "recorders": []},
    }  # fmt: skip
    return Scene.from_data(data)


FEW = [
    (12, "1 node carries", {"few-nodes", "kept-gap"}),  # the force is 10 % too small: its node presses a dent
    (24, "3 nodes carry", {"few-nodes"}),
    (48, "", set()),
]


@pytest.mark.parametrize(("cells", "nodes", "codes"), FEW)
def test_a_peak_that_too_few_nodes_carry_is_told_with_its_place(cells: int, nodes: str, codes: set[str]) -> None:
    """Twice as many cells show what it misses: at least half of the number that is warned of, without a warning 1 %."""
    results = simulate(roller(cells))
    right = 17.577  # of 96 cells; 48 have 17.69
    error = results.contact["contacts.0"].last.pressure.max() / right - 1.0
    found = {warning.code: warning for warning in results.warnings}
    assert found.keys() == codes
    if nodes:
        assert found["few-nodes"].text.startswith(f"contacts.0: {nodes} the pressure around (0, -0.01")
        assert 0.5 * found["few-nodes"].value < error < found["few-nodes"].value
    else:
        assert abs(error) < 0.01


def test_three_nodes_of_which_the_middle_one_carries_least_are_told() -> None:
    """A disc touches a block of segments of other lengths: node by node the pressure is lowest below its centre."""
    touched = {"integrator": "newton", "supports.1.uy.to": -0.01, "contacts.0.algorithm": "node-on-segment"}
    results = simulate(load_scene("disc-on-block").with_({**touched, "record.recorders": []}))
    right = 385.0  # mortar-p1 at levels 4 and 8 with either slave: 384.5 to 387
    (found,) = [warning for warning in results.warnings if warning.code == "few-nodes"]
    assert "3 nodes carry" in found.text
    error = 1.0 - results.contact["contacts.0"].last.pressure.max() / right
    assert 0.5 * found.value < error < 2.0 * found.value


@pytest.mark.parametrize("algorithm", ["mortar-p1", "mortar-dual"])
def test_a_disc_in_a_groove_has_two_peaks_that_too_few_nodes_carry_and_no_fit(algorithm: str) -> None:
    """Its arc is closed, and begins at one of the peaks; facets far apart on it are none of surfaces that fit."""
    young, radius, weight = 2000.0, 2.0, 20.0
    deep = radius * np.sqrt(2.0)
    mass = 1e-9 * np.pi * radius**2
    scene = Scene.from_data({
        "integrator": "newton",
        "materials": {"m": {"use": "linear-elastic", "young": young, "poisson": 0.3, "density": 1e-9}},
        "bodies": {"disc": {"element": "q1", "material": "m",
                            "mesh": {"use": "disc", "radius": radius, "cells": [12, 8], "grading": 0.3}}},
        "rigid": {"groove": {"line": [[6.0, 6.0 - deep], [0.0, -deep], [-6.0, 6.0 - deep]]}},
        "contacts": [{"slave": "disc.arc", "master": "groove", "algorithm": algorithm}],
        "supports": [{"on": "disc.top", "ux": 0.0}],
        "effects": [{"use": "gravity", "acceleration": [0.0, -weight / mass]}],
        "record": {"frames": 1, "recorders": []},
    })  # fmt: skip
    results = simulate(scene)
    flank = weight * np.sqrt(0.5)
    right = np.sqrt(flank * young / (1.0 - 0.3**2) / np.pi / radius)  # Hertz
    error = results.contact["contacts.0"].last.pressure.max() / right - 1.0
    assert {warning.code for warning in results.warnings} == {"few-nodes"}
    assert 0.4 * results.warnings[0].value < abs(error) < 2.0 * results.warnings[0].value  # one node knows no width


@pytest.mark.parametrize("algorithm", ["mortar-p0", "mortar-p1"])
def test_quadratic_edges_that_are_covered_in_part_stop_no_run(algorithm: str) -> None:
    """A block drawn along a wider quadratic plate, the slave: forces are exact, pressures reach beyond its edge."""
    scene = Scene.from_data({
        "integrator": {"use": "newton", "steps": 4},
        "materials": {"m": ELASTIC},
        "bodies": {
            "plate": {"element": "q2", "material": "m",
                      "mesh": {"use": "rectangle", "x": [-3.0, 6.0], "y": [-1.0, 0.0], "cells": [11, 1]}},
            "block": {"element": "q1", "material": "m",
                      "mesh": {"use": "rectangle", "x": [0.3, 2.3], "y": [0.0, 1.0], "cells": [5, 2]}},
        },
        "contacts": [{"slave": "plate.top", "master": "block.bottom", "algorithm": algorithm,
                      "friction": {"use": "coulomb", "mu": 0.2}}],
        "supports": [{"on": "plate.bottom", "ux": 0.0, "uy": 0.0}, {"on": "block.top", "ux": 0.3}],
        "loads": [{"on": "block.top", "ty": -0.5}],
        "record": {"frames": 1, "recorders": []},
    })  # fmt: skip
    results = simulate(scene)
    assert results.status == "finished", results.reason
    assert results.summary["reactions"]["plate.bottom"] == pytest.approx([-0.2, 1.0], rel=1e-3)


def test_facets_that_overlap_where_nothing_closes_are_not_called_apart() -> None:
    model = build(pressed(0.05), default_registry())
    report = take_sample(model, 0, 1.0).contacts["contacts.0"]
    deep = replace(report, max_penetration=0.02, penetrating_side="master")
    warning = judgement._never_closed(model, model.contact.pairs[0], deep)
    assert (warning.code, warning.value) == ("open-contact", -0.02)
    assert "the master lies up to 0.02 within the other side" in warning.text


def clamped_beam(cells: int) -> Scene:
    """A beam between two walls, bent by a roll whose curve falls away by a sixth of the stroke within a segment."""
    data = {
        "integrator": "newton",
        "materials": {"m": {**ELASTIC, "poisson": 0.0}},
        "bodies": {
            "beam": {
                "element": "q1", "material": "m",
                "mesh": {"use": "rectangle", "x": [-2.0, 2.0], "y": [0.0, 1.0], "cells": [cells, 6]},
            },
        },
        "rigid": {"roll": {"arc": {"centre": [0.0, 3.0], "radius": 2.0, "angles": [200.0, 340.0]}, "segment": 0.02,
                           "uy": {"ramp": "linear", "to": -0.02}}},
        "contacts": [{"slave": "beam.top", "master": "roll", "algorithm": "mortar-p1"}],
        "supports": [{"on": f"beam.{side}", "ux": 0.0, "uy": 0.0} for side in ("left", "right")],
        "record": {"frames": 1, "recorders": []},
    }  # fmt: skip
    return Scene.from_data(data)


def test_nodes_that_press_before_they_touch_are_told_with_the_force_that_they_add() -> None:
    """A quarter of the distance with half as long segments; the distance h^2/12R is the share that was added."""
    values, forces = {}, {}
    for cells in (16, 32):
        results = simulate(clamped_beam(cells))
        values[cells] = {w.code: w.value for w in results.warnings}.get("kept-gap", 0.0)
        forces[cells] = results.summary["contacts"]["contacts.0"]["resultant"][1]
    added = forces[16] / forces[32] - 1.0
    assert 0.5 * values[16] < abs(added) < 2.0 * values[16], (values, forces)
    assert values[32] < 0.5 * values[16]


def test_distances_that_all_rolls_keep_alike_are_told_as_a_displacement() -> None:
    """A beam of its own weight on three rolls, the middle one 0.4 of the deflection lower (Timoshenko 1921).

    The beam lies as much too high as each roll keeps it off; what the rolls carry is right.
    """
    young, h, span, over, q, drop = 1000.0, 0.2, 3.4, 0.3, 6e-4, 0.4
    bending, shear = young * h**3 / 12.0, young / 2.0 * 5.0 / 6.0 * h
    free = 5.0 * q * span**4 / 384.0 / bending - q * over**2 * span**2 / 16.0 / bending + q * span**2 / 8.0 / shear
    middle = (1.0 - drop) * free / (span**3 / 48.0 / bending + span / 4.0 / shear)
    rolls = {"left": (over, 0.0), "middle": (2.0, drop * free), "right": (4.0 - over, 0.0)}
    data = {
        "integrator": "newton",
        "materials": {"m": {**ELASTIC, "young": young, "poisson": 0.0}},
        "bodies": {"beam": {"element": "q2", "material": "m",
                            "mesh": {"use": "rectangle", "x": [0.0, 4.0], "y": [0.0, h], "cells": [40, 2]}}},
        "rigid": {name: {"arc": {"centre": [x, -0.05 - low], "radius": 0.05, "angles": [0.0, 180.0]}, "segment": 0.005}
                  for name, (x, low) in rolls.items()},
        "contacts": [{"slave": "beam.bottom", "master": name, "algorithm": "mortar-p1"} for name in rolls],
        "effects": [{"use": "spring", "on": "beam", "stiffness": [1e-3, 0.0]}],
        "loads": [{"on": "beam.top", "ty": -q}],
        "record": {"frames": 1, "recorders": []},
    }  # fmt: skip
    results = simulate(Scene.from_data(data))
    carried = results.summary["reactions"]["middle"][1]
    assert abs(carried) == pytest.approx(middle, rel=1e-3)
    told = [warning for warning in results.warnings if warning.code == "kept-gap"]
    assert len(told) == 1
    assert "force" not in told[0].text
    curve = results.contact["contacts.0"].last
    assert told[0].value == pytest.approx(1.0, abs=0.1)
    assert curve.y[curve.nodal_pressure.argmax()] > 3.0 * free


def test_nodes_beyond_the_end_of_the_other_side_do_not_stand_off_from_it() -> None:
    """A wide plate is slave on a narrow column: its node beside the column presses its part of a segment, no gap kept.

    The column is compressed evenly: E u/h times its width, to the order of its strain of 1 %.
    """
    data = {
        "integrator": "newton",
        "materials": {"m": {**ELASTIC, "poisson": 0.0}, "hard": {**ELASTIC, "poisson": 0.0, "young": 1e10}},
        "bodies": {
            "column": {"element": "q1", "material": "m",
                       "mesh": {"use": "rectangle", "x": [0.0, 1.0], "y": [0.0, 1.0], "cells": [4, 4]}},
            "plate": {"element": "q1", "material": "hard",
                      "mesh": {"use": "rectangle", "x": [-1.0, 2.0], "y": [1.0, 1.5], "cells": [7, 2]}},
        },
        "contacts": [{"slave": "plate.bottom", "master": "column.top", "algorithm": "mortar-p1"}],
        "supports": [{"on": "column.bottom", "uy": 0.0}, {"on": "column.left", "ux": 0.0},
                     {"on": "plate.top", "ux": 0.0, "uy": {"ramp": "linear", "to": -0.01}}],
        "record": {"frames": 1, "recorders": []},
    }  # fmt: skip
    results = simulate(Scene.from_data(data))
    assert results.summary["reactions"]["column.bottom"][1] == pytest.approx(0.01 * ELASTIC["young"], rel=1e-2)
    assert "kept-gap" not in {warning.code for warning in results.warnings}


def test_forces_that_are_round_off_are_not_judged() -> None:
    """A pressure that alternates is warned of, but not if the run had forces that are 1e17 times as large."""
    fine = {"bodies.upper.mesh.cells": [8, 2], "bodies.lower.mesh.cells": [8, 2]}
    model = build(pressed(0.12).with_(fine), default_registry())
    model.state["multipliers"][0, :9] = 1.0 + 0.5 * (-1.0) ** np.arange(9)
    sample = take_sample(model, 0, 1.0)
    judgement.judge(model, sample, np.ones(9, np.bool_), 1e17)
    assert not list(model.warnings)
    judgement.judge(model, sample, np.ones(9, np.bool_), 1.0)
    assert "pressure-saw" in {warning.code for warning in model.warnings}


@pytest.mark.parametrize("cells", [6, 8])
def test_a_fit_without_load_has_forces_of_round_off_alone(cells: int) -> None:
    """Its overlap is taken away without strain: facets, and gaps that are kept, are no error of such forces."""
    edges = {f"bodies.{body}.element": "q2" for body in ("shaft", "hub")}
    results = simulate(press_fit(cells).with_({"contacts.0.start": {"overlap": "adjust"}, **edges}))
    assert results.status == "finished", results.reason
    assert results.contact["contacts.0"].last.pressure.max() < 1e-9
    assert not results.warnings


@pytest.mark.parametrize("most", [0, 10**9])
def test_the_nearest_point_is_found_either_way(most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(resolution, "FEW_PAIRS", most)
    draw = np.random.default_rng(3)
    points, others = draw.random((40, 2)), draw.random((30, 2))
    distance, which = resolution.nearest_points(points, others)
    every = np.hypot(*(points[:, None] - others[None]).transpose(2, 0, 1))
    assert np.array_equal(which, every.argmin(axis=1))
    assert np.allclose(distance, every.min(axis=1), rtol=1e-14)
