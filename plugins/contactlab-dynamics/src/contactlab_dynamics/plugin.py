"""Explicit dynamics on offer."""

from __future__ import annotations

from contactlab.api.plugin import Part, hookimpl


@hookimpl
def contactlab_parts() -> list[Part]:
    """The explicit integrator and the contact enforcement that belongs to it."""
    return [
        Part(
            "integrator",
            "central-difference",
            "contactlab_dynamics.central_difference:CentralDifference",
            "explicit, second order, velocities at half steps",
            "Carpenter, Taylor & Katona 1991",
        ),
        Part(
            "enforcement",
            "forward-increment",
            "contactlab_dynamics.forward_increment:ForwardIncrement",
            "exact multipliers at the end of each explicit step",
            "Carpenter, Taylor & Katona 1991; Baillet & Sassi 2005",
        ),
    ]
