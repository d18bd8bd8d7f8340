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


def with_registry(scene: Scene) -> tuple[Scene, Any]:
    return scene, scene.registry
