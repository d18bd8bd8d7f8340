"""A pair whose algorithm gives finished gap conditions works like one whose algorithm gives operators."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest
from contactlab_mortar.mortar import MortarP0

from contactlab.api import ContactView, GapAlgorithm, GapConditions, Pieces
from contactlab.api.plugin import Part, hookimpl
from contactlab.contact.gap_pair import GapPair, refuse_wrong
from contactlab.errors import PartError
from contactlab.model.build import build
from contactlab.parts.registry import Registry
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene
from contactlab.testing import contact as checks
from contactlab.testing.surfaces import conditions


@dataclass(frozen=True)
class Finished(GapAlgorithm):
    """The conditions that the core itself makes of mortar-p1, handed over as finished ones."""

    passes_patch_test: ClassVar[bool] = True

    def conditions(self, view: ContactView, *, tangent: bool) -> GapConditions:
        from contactlab_mortar.mortar import MortarP1

        from contactlab.testing.surfaces import Chains

        slave, master, at = view.slave, view.master, view.at
        nodes = np.zeros((1 + max(slave.nodes.max(), master.nodes.max()), 2))
        nodes[slave.nodes], nodes[master.nodes] = at.slave, at.master
        return conditions(MortarP1(), Chains(nodes, slave, master), tangent=tangent)


@dataclass(frozen=True)
class Shifted(Finished):
    """It moves a node of the model to where it wants it."""

    def conditions(self, view: ContactView, *, tangent: bool) -> GapConditions:
        view.at.master[:, 1] -= 0.01
        return super().conditions(view, tangent=tangent)


MORTAR = MortarP0()
"""Its kernels are there: those of a class derived from its own would be compiled."""


@dataclass(frozen=True)
class Sorted(MortarP0):
    """It sorts the list of neighbours in place."""

    def pieces(self, view: ContactView, out: Pieces) -> int:
        view.near.master[::-1].sort()
        return MORTAR.pieces(view, out)


@hookimpl
def contactlab_parts() -> list[Part]:
    return [
        Part("contact", "finished", f"{__name__}:Finished", "conditions of mortar-p1"),
        Part("contact", "shifted", f"{__name__}:Shifted", "for tests"),
        Part("contact", "sorted", f"{__name__}:Sorted", "for tests"),
    ]


@pytest.fixture
def registry() -> Registry:
    from contactlab.parts.loading import Origin, load

    found = Registry()
    found._add(load(Origin("finished", "a test"), lambda: sys.modules[__name__]))
    return found


def sliding(algorithm: str, registry: Registry, friction: bool, turn: float = 0.0) -> Scene:
    """A block thrown obliquely onto a base."""
    from math import cos, radians, sin

    c, s = cos(radians(turn)), sin(radians(turn))
    body = {"element": "q1", "material": "m", "rotate": turn}
    contact = {"slave": "upper.bottom", "master": "lower.top", "algorithm": algorithm}
    return Scene.from_data(
        {
            "name": "thrown",
            "time": {"end": 1e-3, "step": 2e-6},
            "integrator": {"use": "central-difference", "forces": "frozen"},  # finished conditions have no others
            "materials": {"m": {"use": "neo-hookean", "young": 1000.0, "poisson": 0.3, "density": 1e-6}},
            "bodies": {
                "upper": {
                    **body,
                    "mesh": {"use": "rectangle", "x": [0.3, 1.7], "y": [0.0, 1.0], "cells": [4, 2]},
                    "velocity": [300.0 * c + 500.0 * s, 300.0 * s - 500.0 * c],
                },
                "lower": {**body, "mesh": {"use": "rectangle", "x": [0.0, 3.0], "y": [-1.0, 0.0], "cells": [7, 2]}},
            },
            "contacts": [{**contact, **({"friction": {"use": "coulomb", "mu": 0.2}} if friction else {})}],
            "supports": [{"on": "lower.bottom", "ux": 0.0, "uy": 0.0}],
        },
        registry=registry,
    )


@pytest.mark.parametrize("friction", [False, True])
def test_both_roads_lead_to_the_same_run(registry: Registry, friction: bool) -> None:
    """Same conditions, so the same motion; finished conditions measure gaps along the same weights."""
    found = []
    for algorithm in ("mortar-p1", "finished"):
        model = build(sliding(algorithm, registry, friction), registry)
        advance = model.bound_integrator().step
        for _ in range(20):
            advance(2e-6)
        multipliers = model.state["multipliers"][:, model.contact.pairs[0].own]
        found.append((model.state["displacement"].copy(), multipliers.copy(), model.state["work"].copy()))
    assert isinstance(model.contact.pairs[0], GapPair)
    assert np.abs(found[0][1][0]).max() > 1.0
    for one, two in zip(*found, strict=True):
        # each solve stops at 1e-10 of a segment; 20 of them add up
        assert two == pytest.approx(one, abs=1e-7 * np.abs(one).max())


def test_slip_of_finished_conditions_is_objective(registry: Registry) -> None:
    """The scene turned by 40 degrees gives the same multipliers, tangential ones included."""
    found = []
    for turn in (0.0, 40.0):
        model = build(sliding("finished", registry, True, turn), registry)
        advance = model.bound_integrator().step
        for _ in range(20):
            advance(2e-6)
        found.append(model.state["multipliers"].copy())
    assert found[1] == pytest.approx(found[0], abs=1e-8 * np.abs(found[0]).max())


OWN = [check for check in checks.CHECKS if check.__name__ != "reach_is_kept"]  # it has no reach


def test_results_of_finished_conditions_are_reported(registry: Registry) -> None:
    from contactlab.run.simulation import simulate

    results = simulate(sliding("finished", registry, True).with_({"time.end": 1e-4}), registry=registry)
    assert results.status == "finished", results.reason
    contact = results.summary["contacts"]["contacts.0"]
    curve = results.contact["contacts.0"].last
    assert contact["active"] == np.count_nonzero(curve.state) > 0
    assert contact["cone_violation"] < 1e-8
    assert curve.pressure == pytest.approx(curve.nodal_pressure)


@pytest.mark.parametrize(
    ("name", "told"),
    [("shifted", "Shifted: conditions wrote to at.master"), ("sorted", "Sorted: pieces wrote to near.master")],
)
def test_an_algorithm_that_writes_to_its_view_is_named(registry: Registry, name: str, told: str) -> None:
    """What it writes to are the arrays of the model: other positions, and nobody would notice."""
    with pytest.raises(PartError, match=told):
        simulate(sliding(name, registry, friction=False), registry=registry)


def sound() -> GapConditions:
    return GapConditions(
        np.array([0, 2, 4], np.int32), np.array([0, 5, 1, 6], np.int32), np.ones((4, 2)), np.zeros((0, 2)),
        np.zeros(2), np.ones(2), np.array([0, 1], np.int32),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("wrong", "word"),
    [
        ({"start": np.array([0, 2], np.int32)}, "start has the shape"),
        ({"start": np.array([0, 0, 4], np.int32)}, "no row empty"),
        ({"node": np.array([0, 5, 1, 99], np.int32)}, "global node numbers"),
        ({"owner": np.array([1, 1], np.int32)}, "at most once"),
        ({"owner": np.array([0, 9], np.int32)}, "positions 0 to 4"),
        ({"measure": np.array([1.0, 0.0])}, "lengths > 0"),
        ({"tangent_weight": np.ones((4, 2))}, "tangent_weight has the shape"),
    ],
)
def test_conditions_that_break_the_contract_are_named(wrong: dict, word: str) -> None:
    refuse_wrong(sound(), 5, 10, False, "MyContact")
    with pytest.raises(ValueError, match=word) as caught:
        refuse_wrong(replace(sound(), **wrong), 5, 10, False, "MyContact")
    assert str(caught.value).startswith("MyContact: ")
