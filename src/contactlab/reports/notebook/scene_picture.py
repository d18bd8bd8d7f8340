"""The meshes of a scene before the run, with contact sides, rigid surfaces, supports and loads."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from contactlab.api.drawing.colours import STYLES
from contactlab.reports.figures import INK, MUTED, house_style
from contactlab.reports.notebook.canvas import label_places
from contactlab.reports.notebook.conditions import draw_conditions
from contactlab.reports.notebook.pictures import frame_of
from contactlab.results.nodal import corners_of
from contactlab.scene.scene import Scene
from contactlab.studies.shape import outline

BODIES = ("#dfe6ee", "#efe5d8", "#e2ecdf", "#ece0ea", "#f0e9c9", "#d9ebec")
"""Pale colours of bodies."""
SIDES = (("master", STYLES[1].colour, 4.0), ("slave", STYLES[0].colour, 1.8))
"""Lines of a contact in drawing order: sides that touch lie on each other, and both must be visible."""


def scene_figure(scene: Scene, ax: Axes | None = None) -> Figure:
    """Draw the scene."""
    from contactlab.model.bodies.build_bodies import build_bodies
    from contactlab.model.loading.rigid import build_rigid

    bodies = build_bodies(scene, scene.registry)
    rigid = build_rigid(scene, bodies) if scene.rigid else ()
    with house_style():
        nodes = np.concatenate([body.mesh.nodes for body in bodies])
        low, high = nodes.min(axis=0), nodes.max(axis=0)
        around = float(np.max(high - low))  # a floor may be far longer than what lies on it
        near = [np.clip(surface.points, low - around, high + around) for surface in rigid]
        figure, axes = frame_of([nodes, *near], ax)
        for number, body in enumerate(bodies):
            corners = body.mesh.nodes[corners_of(body.mesh.cells)]
            colour = BODIES[number % len(BODIES)]
            axes.add_collection(PolyCollection(list(corners), facecolor=colour, edgecolor="#b9c0c8", linewidths=0.4))
            axes.add_collection(LineCollection(list(outline(corners)), colors=INK, linewidths=1.0))
            middle = corners.reshape(-1, 2)
            x, y = (0.5 * (middle.min(axis=0) + middle.max(axis=0))).tolist()
            axes.text(x, y, body.name, ha="center", va="center")
        limits = axes.get_xlim(), axes.get_ylim()
        for number, surface in enumerate(rigid):
            lines = list(surface.points[surface.edges[:, :2] - surface.first])
            named = None if number else "rigid"
            axes.add_collection(LineCollection(lines, colors=MUTED, linewidths=2.0, label=named))
        _contacts(axes, scene, {body.name: body.mesh for body in bodies})
        draw_conditions(axes, scene, bodies, nodes)
        axes.set_xlim(*limits[0])
        axes.set_ylim(*limits[1])
        label_places(axes, scene.units, scene.name)
    return figure


def _contacts(axes: Axes, scene: Scene, meshes: Mapping[str, Any]) -> None:
    """Master sides as wide lines, slave sides as narrow ones above them."""
    drawn: set[str] = set()
    for label, colour, width in SIDES:
        for contact in scene.contacts:
            slaves, masters = contact.targets
            for target in masters if label == "master" else slaves:
                body, _, edges = target.partition(".")
                if body not in meshes or edges not in meshes[body].edges:
                    continue
                mesh = meshes[body]
                lines = list(mesh.nodes[mesh.edges[edges][:, :2]])
                named = None if label in drawn else label
                axes.add_collection(LineCollection(lines, colors=colour, linewidths=width, label=named))
                drawn.add(label)
    if drawn:
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=8.5)
