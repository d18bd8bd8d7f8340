"""Every reaction counts once, whatever supports share: in summaries, histories and the scalars of every step."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene, load_scene
from contactlab.studies.measure_run import reaction_against_pressure

STIFFNESS, SHORTER = 1000.0, 1e-3


def held(integrator: Any, **more: Any) -> Scene:
    """A block of nu = 0.3, confined by a support of the whole body and pressed between two of its edges.

    Two tables hold the bottom, one along each axis.
    """
    return Scene.from_data(
        {
            "name": "held",
            "time": {"end": 0.01, "damping": 3000.0},
            "integrator": integrator,
            "materials": {"m": {"use": "linear-elastic", "young": STIFFNESS, "poisson": 0.3, "density": 1e-6}},
            "bodies": {
                "block": {
                    "element": "q1",
                    "material": "m",
                    "mesh": {"use": "rectangle", "x": [0.0, 2.0], "y": [0.0, 1.0], "cells": [4, 2]},
                }
            },
            "supports": [
                {"on": "block.bottom", "uy": 0.0},
                {"on": "block", "ux": 0.0},
                {"on": "block.bottom", "ux": 0.0},
                {"on": "block.top", "ux": 0.0, "uy": {"ramp": "smooth", "to": -SHORTER, "duration": 0.008}},
            ],
            **more,
        }
    )


@pytest.mark.parametrize("integrator", ["newton", "central-difference"])
def test_shared_degrees_of_freedom_count_for_the_first_support(integrator: str, tmp_path: Path) -> None:
    """Confined compression: E (1 - nu)/((1 + nu)(1 - 2 nu)) times the strain and the width, up and down."""
    results = simulate(held(integrator), tmp_path / "run")
    assert results.status == "finished"
    force = 2.0 * STIFFNESS * 0.7 / (1.3 * 0.4) * SHORTER
    expected = {"block.bottom": (0.0, force), "block": (0.0, 0.0), "block.top": (0.0, -force)}
    # the explicit run has a little time to come to rest
    within = {"newton": 1e-8, "central-difference": 1e-3}[integrator] * force
    told = {on: np.array(value) for on, value in results.summary["reactions"].items()}
    assert set(told) == set(expected)
    for on, value in expected.items():
        assert told[on] == pytest.approx(value, abs=within)
    for name, column in (("history", results.history), ("steps", results.steps)):
        last = {on: [column[f"{on}.{c}"][-1] for c in ("fx", "fy")] for on in expected}
        for on, value in last.items():
            assert value == pytest.approx(told[on].tolist(), abs=1e-12 * force), name
    assert results.summary["reaction_mismatch"] < within / force


def test_reactions_are_the_pressure_where_a_whole_body_is_guided() -> None:
    """Both blocks are guided along x by supports of all their nodes, which are also held below and above."""
    scene = load_scene("initial-overlap").with_({"integrator": "newton", "supports.3.uy.to": 0.0})
    results = simulate(scene)
    reactions = {on: np.array(force) for on, force in results.summary["reactions"].items()}
    assert reactions["lower"] == pytest.approx([0.0, 0.0], abs=1e-9)
    integral = np.array(results.summary["contacts"]["contacts.0"]["pressure_integral"])
    assert reaction_against_pressure(scene.data, reactions, 0, integral) < 1e-7


@pytest.mark.parametrize(("contrast", "codes"), [(1e9, set()), (3e12, {"unbalanced-reactions"})])
def test_reactions_that_round_off_leaves_uncertain_are_told_from_one_per_cent_on(
    contrast: float, codes: set[str]
) -> None:
    """Steps cannot balance what a stiff body carries any better: right to 0.01 %, and off by some per cent."""
    soft = {"use": "neo-hookean", "young": 1.0, "poisson": 0.3, "density": 1e-9}

    def block(material: str, x: list[float], y: list[float], cells: list[int]) -> dict[str, Any]:
        mesh = {"use": "rectangle", "x": x, "y": y, "cells": cells}
        return {"element": "q1", "material": material, "mesh": mesh}

    results = simulate(
        Scene.from_data(
            {
                "name": "contrast",
                "integrator": "newton",
                "materials": {"soft": soft, "stiff": soft | {"young": contrast}},
                "bodies": {
                    "upper": block("soft", [-1.0, 1.0], [0.0, 1.0], [6, 3]),
                    "lower": block("stiff", [-3.0, 3.0], [-2.0, 0.0], [11, 4]),
                },
                "contacts": [{"slave": "upper.bottom", "master": "lower.top", "algorithm": "mortar-p0"}],
                "supports": [{"on": "lower.bottom", "ux": 0.0, "uy": 0.0}, {"on": "upper.top", "ux": 0.0}],
                "loads": [{"on": "upper.top", "pressure": {"ramp": "linear", "to": 0.01}}],
            }
        )
    )
    assert results.status == "finished", results.reason
    assert {warning.code for warning in results.warnings} == codes
    assert {warning.key for warning in results.warnings} <= {"materials"}
    error = abs(results.summary["reactions"]["lower.bottom"][1] / 0.02 - 1.0)
    assert error > 0.01 if codes else error < 1e-3
