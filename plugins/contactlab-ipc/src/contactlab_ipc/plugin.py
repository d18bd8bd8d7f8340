"""Barrier contact on offer."""

from __future__ import annotations

from contactlab.api.plugin import Part, hookimpl


@hookimpl
def contactlab_parts() -> list[Part]:
    """Offer the barrier of incremental potential contact."""
    return [
        Part(
            "contact",
            "barrier",
            "contactlab_ipc.barrier:Barrier",
            "log barrier with continuous collision detection, never an intersection; implicit runs",
            "Li et al. 2020; Li et al. 2023",
        )
    ]
