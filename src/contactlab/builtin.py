"""The core's own parts: they come in by an entry point, like anyone's."""

from __future__ import annotations

from contactlab.api.plugin import Part, hookimpl


@hookimpl
def contactlab_parts() -> list[Part]:
    """Structured mesh generators."""
    return [
        Part("mesh", "rectangle", "contactlab.meshing:Rectangle", "rectangle of equal cells"),
        Part("mesh", "arc-block", "contactlab.meshing:ArcBlock", "block whose lower side is a circular arc"),
    ]
