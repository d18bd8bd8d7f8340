"""Quadrilaterals on offer."""

from __future__ import annotations

from contactlab.api.plugin import Part, hookimpl


@hookimpl
def contactlab_parts() -> list[Part]:
    """The bilinear quadrilateral."""
    return [
        Part("element", "q1", "contactlab_quads.q1:Q1", "bilinear quadrilateral, 2x2 points", "Hughes 2000, ch. 3"),
    ]
