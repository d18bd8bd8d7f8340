"""Motion that no body can follow is refused before the first step, and only such motion."""

from __future__ import annotations

from typing import Any

import pytest

from contactlab.errors import SceneError
from contactlab.model.build import build
from contactlab.scene.scene import Scene, load_scene


def pressed(depth: float, **changes: Any) -> Scene:
    """The disc's flat top, at 0.6, goes down by `depth`; the block's bottom is held at -0.3."""
    down = {"ramp": "parabola", "to": -depth}
    return load_scene("disc-on-block").with_({"integrator": "newton", "level": 1, "supports.1.uy": down} | changes)


@pytest.mark.parametrize("integrator", ["newton", "central-difference"])
def test_an_indentation_deeper_than_the_bodies_is_refused(integrator: str) -> None:
    with pytest.raises(SceneError, match="disc and what holds block would pass through each other along y") as told:
        build(*with_registry(pressed(1.0, integrator=integrator)))
    assert "0.9 mm between them" in str(told.value)
    assert "supports" in str(told.value)
    build(*with_registry(pressed(0.89, integrator=integrator)))


def test_the_deepest_place_on_the_way_counts() -> None:
    way = {"ramp": "table", "points": [[0.0, 0.0], [0.5, 1.0], [1.0, 0.0]], "to": -1.0}
    with pytest.raises(SceneError, match="pass through each other"):
        build(*with_registry(pressed(0.0, **{"supports.1.uy": way})))


def test_what_passes_beside_is_let_through() -> None:
    """A disc that has moved aside by more than the block's width may go as deep as it likes."""
    aside = {"ramp": "table", "points": [[0.0, 0.0], [0.4, 1.0]], "to": 3.0}
    down = {"ramp": "linear", "begin": 0.5, "duration": 0.5, "to": -2.0}
    build(*with_registry(pressed(0.0, **{"supports.1.ux": aside, "supports.1.uy": down})))


def test_bodies_between_two_tools_count_together() -> None:
    """The forging's tools are held on the far sides of the billet between them."""
    scene = load_scene("three-body-forging")
    moved = next(i for i, support in enumerate(scene.supports) if hasattr(support.uy, "to"))
    with pytest.raises(SceneError, match="pass through each other along y"):
        build(*with_registry(scene.with_({f"supports.{moved}.uy.to": -100.0})))
    build(*with_registry(scene))


def bent(punch: float, held: dict[str, Any], depth: float, level: int = 1) -> Scene:
    """A sheet from -3 to 3, held at places of its outline, under a punch whose top of half-width `punch` goes down."""
    material = {"use": "neo-hookean", "young": 1.0, "poisson": 0.25, "density": 1e-9}
    die = {"use": "rectangle", "x": [-punch, punch], "y": [0.05, 0.65], "cells": [4, 2]}
    sheet = {"use": "rectangle", "x": [-3.0, 3.0], "y": [-0.2, 0.0], "cells": [12, 1]}
    supports = [{"on": f"sheet.{name}", "ux": 0.0, "uy": 0.0} for name in held or ("left", "right")]
    down = {"on": "punch.top", "ux": 0.0, "uy": {"ramp": "linear", "to": -depth}}
    return Scene.from_data(
        {
            "format": 1,
            "level": level,
            "integrator": "newton",
            "materials": {"soft": material},
            "bodies": {
                "punch": {"element": "q1", "material": "soft", "mesh": die},
                "sheet": {"element": "q1", "material": "soft", "mesh": sheet, "sets": held},
            },
            "contacts": [{"slave": "sheet.top", "master": "punch.bottom", "algorithm": "mortar-p0"}],
            "supports": [*supports, down],
        }
    )


ENDS = {"one": {"of": "bottom", "x": [-3.0, -2.5]}, "other": {"of": "bottom", "x": [2.5, 3.0]}}


@pytest.mark.parametrize("held", [{}, ENDS], ids=["clamped", "lies on its ends"])
@pytest.mark.parametrize("level", [1, 2, 4])
def test_a_punch_passes_between_what_holds_a_sheet_at_both_ends(held: dict[str, Any], level: int) -> None:
    """Only a punch that reaches over the ends themselves is in their way, however wide the space between them is."""
    build(*with_registry(bent(0.4, held, 1.5, level)))
    build(*with_registry(bent(2.4, held, 1.5, level)))
    with pytest.raises(SceneError, match="0.85 mm between them" if held else "0.65 mm between them"):
        build(*with_registry(bent(3.2, held, 1.5, level)))


def test_what_holds_a_beam_that_bends_over_a_roller_passes_beside_it() -> None:
    """Both ends go down by far more than the room that facets leave over the roller between them."""
    for segment in (0.5, 0.05, 0.01):
        roller = {"arc": {"centre": [0.0, -1.201], "radius": 1.0, "angles": [0.0, 180.0]}, "segment": segment}
        data = bent(0.4, ENDS, 0.0).data
        ends = [{"on": f"sheet.{end}", "uy": {"ramp": "linear", "to": -5.0}} for end in ENDS]
        contact = {"slave": "sheet.bottom", "master": "roller", "algorithm": "mortar-p0"}
        bodies, rigid = {"sheet": data["bodies"]["sheet"]}, {"roller": roller}
        build(
            *with_registry(
                Scene.from_data({**data, "bodies": bodies, "rigid": rigid, "contacts": [contact], "supports": ends})
            )
        )


def with_registry(scene: Scene) -> tuple[Scene, Any]:
    return scene, scene.registry
