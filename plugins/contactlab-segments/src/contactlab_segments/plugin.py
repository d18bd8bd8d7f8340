"""Node-on-segment contact on offer."""

from __future__ import annotations

from contactlab.api.plugin import Part, hookimpl


@hookimpl
def contactlab_parts() -> list[Part]:
    """Offer one-pass node-on-segment contact."""
    return [
        Part(
            "contact",
            "node-on-segment",
            "contactlab_segments.node_on_segment:NodeOnSegment",
            "slave nodes against master segments, one pass",
            "Hallquist, Goudreau & Benson 1985",
        ),
    ]
