"""Surfaces that touch before the run, whose weighted gaps the facets make negative, are not pushed apart by a blow."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tiers import some

import contactlab
from contactlab.errors import SceneError
from contactlab.model.build import build
from contactlab.scene.scene import Scene

Q2 = {
    "bodies.disc.element": "q2",
    "bodies.block.element": "q2",
    "bodies.disc.mesh.cells": [8, 2],
    "bodies.block.mesh.cells": [12, 2],
}


FORCES = "frozen", "consistent"


def touching(forces: str = "frozen", **more: Any) -> Scene:
    """The bundled disc with coarse quadratic cells, at the pace of an end that is reached at once."""
    enforcement = {"use": "forward-increment", "forces": forces}
    return contactlab.load_scene("disc-on-block").with_({**Q2, "contacts.0.enforcement": enforcement, **more})


@pytest.mark.parametrize("cells", [8, 16])
@pytest.mark.parametrize("mu", [0.0, 0.2])
def test_the_weak_gap_of_the_start_is_that_of_the_facets_and_counts_as_none(cells: int, mu: float) -> None:
    """The L2 projection of x^2/2R on hats of width h lies h^2/12R below it at their nodes (R = 1).

    Multipliers live on all nodes of quadratic edges, with friction on their ends.
    """
    friction = {"contacts.0.friction": {"use": "coulomb", "mu": mu}} if mu else {}
    model = build(scene := touching(**{"bodies.disc.mesh.cells": [cells, 2]}, **friction), scene.registry)
    pair, h = model.contact.pairs[0], (1.6 if mu else 0.8) / cells
    assert pair.start_gaps is not None
    # quadratic edges with ends on the circle follow it to fourth order: terms of (h/R)^2 are left
    assert -pair.start_gaps.value.min() == pytest.approx(h**2 / 12.0, rel=3.0 * h**2)
    pair.update(model.reference, np.zeros((1, len(pair.slave.nodes))))
    assert abs(pair.gaps[:, 0].min()) < 1e-15


@pytest.mark.parametrize(
    ("forces", "swap"),
    some([(forces, swap) for forces in FORCES for swap in (False, True)], [("frozen", False), ("consistent", True)]),
)
def test_the_end_is_that_of_statics_and_contact_has_made_no_blow(forces: str, swap: bool) -> None:
    """Pressed by 0.02, with an overlap of up to 9e-4: it counts in full at the end, as in statics, which has it too.

    Explicit runs settle to 1e-3 of reactions.
    """
    changes = {"supports.1.uy.to": -0.02, "contacts.0.swap": swap}
    explicit = contactlab.simulate(touching(forces, **changes))
    static = contactlab.simulate(
        contactlab.load_scene("disc-on-block").with_(Q2 | changes | {"integrator": {"use": "newton"}})
    )
    assert explicit.status == "finished", explicit.reason
    force = static.summary["reactions"]["block.bottom"][1]
    assert explicit.summary["reactions"]["block.bottom"][1] == pytest.approx(force, rel=3e-3)
    assert explicit.summary["contacts"]["contacts.0"]["facet_overlap"] > 4e-4
    assert any("facets" in event.text for event in explicit.events)
    assert "facet_overlap" not in static.summary["contacts"]["contacts.0"]


@pytest.mark.full
def test_a_slow_run_with_friction_is_not_stopped() -> None:
    """At the slow pace almost nothing is stored when the overlap is met: pushed out at once, it was 80 % of all."""
    changes = {"supports.1.uy.to": -0.04, "contacts.0.friction": {"use": "coulomb", "mu": 0.2}}
    explicit = contactlab.simulate(touching(**changes))
    assert explicit.status == "finished", explicit.reason
    static = contactlab.simulate(
        contactlab.load_scene("disc-on-block").with_(Q2 | changes | {"integrator": {"use": "newton"}})
    )
    force = static.summary["reactions"]["block.bottom"][1]
    # friction follows another path where the load comes in other steps: 1 % of it
    assert explicit.summary["reactions"]["block.bottom"][1] == pytest.approx(force, rel=2e-3)


def plates(apart: float, start: dict[str, Any]) -> float:
    """Force [N] of two plates of one width and unlike cells that are pressed together by 0.02, with `apart` between."""
    data = {
        "integrator": "newton",
        "materials": {"m": {"use": "linear-elastic", "young": 1000.0, "poisson": 0.0, "density": 1e-9}},
        "bodies": {
            name: {"element": "q1", "material": "m", "shift": [0.0, shift],
                   "mesh": {"use": "rectangle", "x": [0.0, 2.0], "y": y, "cells": cells}}
            for name, shift, y, cells in (("low", 0.0, [-1.0, 0.0], [7, 3]), ("up", apart, [0.0, 1.0], [5, 4]))
        },
        "contacts": [{"slave": "up.bottom", "master": "low.top", "algorithm": "node-on-segment", **start}],
        "supports": [{"on": "low.bottom", "ux": 0.0, "uy": 0.0},
                     {"on": "up.top", "ux": 0.0, "uy": {"ramp": "linear", "to": -0.02}}],
        "record": {"frames": 1, "recorders": []},
    }  # fmt: skip
    results = contactlab.simulate(Scene.from_data(data))
    assert results.status == "finished", results.reason
    return results.summary["reactions"]["low.bottom"][1]


@pytest.mark.parametrize("apart", [0.01, -0.01])
def test_a_gap_of_zero_holds_for_whatever_holds_a_node_at_a_flush_end(apart: float) -> None:
    """A distance that never counts changes nothing, to first order in distance over length of the plates (1 %).

    A node at a flush end is held by a segment of the master, or by the master's corner on its own segment, as one plate
    ends before the other: the distance of the start must not count under the one and be missed under the other.
    """
    assert plates(apart, {"start": {"gap": "zero"}}) == pytest.approx(plates(0.0, {}), rel=5e-3)


def rings(algorithm: str, interference: float, tension: float = 0.0) -> Scene:
    """Half a ring in half another one, with unlike facets; inside a tension where there is one."""
    steel = {"use": "linear-elastic", "young": 2e5, "poisson": 0.3, "density": 7.8e-9}
    parts = {"outer": ([10.0, 14.0], 24), "inner": ([6.0, 10.0 + interference], 32)}
    data: dict[str, Any] = {
        "format": 1, "integrator": {"use": "newton"}, "record": {"recorders": []}, "materials": {"steel": steel},
        "bodies": {
            name: {
                "element": "q1", "material": "steel",
                "mesh": {"use": "ring", "radii": radii, "cells": [cells, 4], "angles": [0.0, 180.0]},
            }
            for name, (radii, cells) in parts.items()
        },
        "contacts": [{"slave": "inner.outer", "master": "outer.inner", "algorithm": algorithm}],
        "supports": [{"on": f"{name}.{end}", "uy": 0.0} for name in parts for end in ("start", "end")],
        "effects": [{"use": "spring", "on": f"{name}.start", "stiffness": [1.0, 0.0]} for name in parts],
        "loads": [{"on": "inner.inner", "pressure": tension}],
    }  # fmt: skip
    return Scene.from_data(data)


@pytest.mark.parametrize("algorithm", ["mortar-p0", "mortar-p1"])
def test_facets_of_curves_that_fit_touch_and_press_nothing(algorithm: str) -> None:
    """Pressed by 10 MPa inside, two rings are one: Lame's pressure between them; without load there is none."""
    assert contactlab.simulate(rings(algorithm, 0.0)).contact["contacts.0"].last.pressure.max() == 0.0
    curve = contactlab.simulate(rings(algorithm, 0.0, tension=10.0)).contact["contacts.0"].last
    exact = 10.0 * (14.0**2 / 10.0**2 - 1.0) / (14.0**2 / 6.0**2 - 1.0)
    # bilinear cells of 7 degrees; those at the ends are held along the cut
    assert np.mean(curve.pressure) == pytest.approx(exact, rel=0.03)


@pytest.mark.parametrize("algorithm", ["mortar-p0", "mortar-p1", "mortar-dual", "gauss-point"])
def test_a_clearance_below_the_depth_of_the_facets_counts(algorithm: str) -> None:
    """Facets are 0.02 deep, the clearance is 0.002: Lame's pressure once the inner ring has grown by that.

    It was lost, and the pressure 64 % too high. Per pressure on it a face at r moves by

        (1 + nu)/E ((1 - 2 nu) r A + B/r),   with A = p a^2/(b^2 - a^2) and B = A b^2, or -p b^2/(b^2 - a^2) and A a^2.
    """
    clearance, inside, (a, b, c), nu, young = 0.002, 100.0, (6.0, 10.0, 14.0), 0.3, 2e5

    def grows(first: float, second: float) -> float:
        return (1.0 + nu) / young * ((1.0 - 2.0 * nu) * b * first + second / b)

    inner = a**2 / (b**2 - a**2)
    by_load, by_contact = grows(inner, inner * b**2), grows(-(b**2) / (b**2 - a**2), -inner * b**2)
    outer = b**2 / (c**2 - b**2)
    exact = (inside * by_load - clearance) / (grows(outer, outer * c**2) - by_contact)
    curve = contactlab.simulate(rings(algorithm, -clearance, tension=inside)).contact["contacts.0"].last
    assert np.mean(curve.pressure) == pytest.approx(exact, rel=0.03)  # cells of 7 degrees, as above


def test_facets_of_a_fit_that_single_nodes_press_are_told() -> None:
    """Nodes press where they stand opposite to others, every fourth; the open ones between them do not fit."""
    scene = rings("node-on-segment", -0.002, tension=100.0).with_({"contacts.0.swap": True})
    results = contactlab.simulate(scene)
    curve = results.contact["contacts.0"].last
    assert np.mean(curve.pressure > 0.0) < 0.5  # the fit is evenly pressed in truth
    assert "coarse-facets" in {warning.code for warning in results.warnings}


@pytest.mark.parametrize("algorithm", ["mortar-p0", "mortar-p1"])
def test_an_interference_below_the_depth_of_the_facets_is_no_fit(algorithm: str) -> None:
    """Facets are 0.02 deep; an interference of 0.005 that nothing declares would come to nothing in silence."""
    with pytest.raises(SceneError, match="overlap before the run"):
        contactlab.simulate(rings(algorithm, 0.005))
