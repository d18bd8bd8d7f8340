"""The timeline on offer."""

from __future__ import annotations

from contactlab.api.plugin import Part, hookimpl


@hookimpl
def contactlab_parts() -> list[Part]:
    """Offer the recorder that writes timelines."""
    return [
        Part("recorder", "rerun", "contactlab_rerun.recorder:Rerun", "every step on a timeline, for the rerun viewer"),
    ]
