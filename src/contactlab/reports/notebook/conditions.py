"""Supports and loads as engineers draw them: triangles where nodes are held, arrows where something moves or pushes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from contactlab.api.arrays import Floats
from contactlab.api.drawing.colours import STYLES
from contactlab.errors import Location
from contactlab.model.bodies.body import Body
from contactlab.parts.registry import default_registry
from contactlab.reports.figures import INK, MUTED, PAPER
from contactlab.results.results import Results
from contactlab.scene.scene import Scene
from contactlab.scene.toml_text import parse_toml

MARKS = 13  # of one support at most
ARROWS = 9  # of one load at most
LOAD = STYLES[4].colour


def scene_of(results: Results) -> tuple[Scene, tuple[Body, ...]]:
    """The scene of a run and its bodies, from what the run kept. Raises what reading them raises."""
    from contactlab.model.bodies.build_bodies import build_bodies

    registry = default_registry()
    where = Location("scene.toml", folder=str(results.folder.resolve()) if results.folder else "")
    scene = Scene.from_data(parse_toml(results.layout.scene, "scene.toml"), where, registry)
    return scene, build_bodies(scene, registry)


def draw_conditions(axes: Axes, scene: Scene, bodies: tuple[Body, ...], position: Floats) -> None:
    """Draw all supports and loads of the scene at nodes (N, 2)."""
    from contactlab.model.loading.edge_sets import edge_set, nodes_of

    size = max(np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim()))
    for number, support in enumerate(scene.supports):
        nodes = nodes_of(bodies, support.on, scene.where(f"supports.{number}"))
        body = next(body for body in reversed(bodies) if body.first <= nodes[0])
        middle = position[body.first : body.first + body.count].mean(axis=0)
        # at most so many nodes, evenly along the longer side of where they lie
        axis = int(np.argmax(np.ptp(position[nodes], axis=0)))
        ordered = nodes[np.argsort(position[nodes, axis], kind="stable")]
        chosen = np.asarray(
            ordered[np.unique(np.linspace(0, len(ordered) - 1, min(MARKS, len(ordered))).round().astype(int))]
        )
        _draw_support(axes, support, position[chosen], middle, 0.09 * size)
    for number, load in enumerate(scene.loads):
        _, edges = edge_set(bodies, load.on, scene.where(f"loads.{number}"))
        _draw_load(axes, load, position[edges[:, :2]], 0.07 * size)


def _draw_support(axes: Axes, support: Any, places: Floats, middle: Floats, length: float) -> None:
    """Triangles outside the body whose tips are at its nodes: full ones hold both directions, open ones their own."""
    held = [axis for axis, value in enumerate((support.ux, support.uy)) if value is not None]
    if not held:
        return
    axis = held[0] if len(held) == 1 else int(np.argmin(np.ptp(places, axis=0)))
    outward = 1.0 if places[:, axis].mean() > middle[axis] else -1.0
    triangle = np.array([[0.0, 0.0], [outward, -0.6], [outward, 0.6], [0.0, 0.0]])
    axes.plot(
        *places.T, linestyle="", marker=triangle if axis == 0 else triangle[:, ::-1], markersize=14.0,
        markerfacecolor=MUTED if len(held) == 2 else PAPER, markeredgecolor=MUTED, zorder=4, clip_on=False,
    )  # fmt: skip
    direction = np.array([_motion(support.ux), _motion(support.uy)])
    if direction.any():
        _arrow(axes, places.mean(axis=0), length * direction / np.hypot(*direction), INK)


def _motion(value: Any) -> float:
    """Final value of a prescribed displacement, 0 if it is held."""
    return 0.0 if value is None else float(value) if isinstance(value, int | float) else float(value.to)


def _draw_load(axes: Axes, load: Any, ends: Floats, length: float) -> None:
    """Arrows against the surface for a pressure, along a traction, and along the edge for a shear."""
    chosen = ends[np.unique(np.linspace(0, len(ends) - 1, min(ARROWS, len(ends))).round().astype(int))]
    tangent = chosen[:, 1] - chosen[:, 0]
    tangent = tangent / np.hypot(*tangent.T)[:, None]
    inward = np.column_stack([-tangent[:, 1], tangent[:, 0]])
    for value, direction in (
        (load.pressure, inward), (load.shear, tangent),
        (load.tx, np.broadcast_to([1.0, 0.0], inward.shape)), (load.ty, np.broadcast_to([0.0, 1.0], inward.shape)),
    ):  # fmt: skip
        sign = np.sign(_motion(value))
        for middle, along in zip(chosen.mean(axis=1), sign * direction, strict=True):
            if sign:
                _arrow(axes, middle - length * along, length * along, LOAD)


def _arrow(axes: Axes, start: Floats, along: Floats, colour: str) -> None:
    properties: Mapping[str, Any] = {"arrowstyle": "-|>", "color": colour, "linewidth": 1.2, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", xy=tuple(start + along), xytext=tuple(start), arrowprops=dict(properties), zorder=5,
                  annotation_clip=False)  # fmt: skip
