"""Mortar contact on offer."""

from __future__ import annotations

from contactlab.api.plugin import Part, hookimpl


@hookimpl
def contactlab_parts() -> list[Part]:
    """Offer mortar contact with constant, linear and dual multipliers."""
    return [
        Part(
            "contact",
            "mortar-p0",
            "contactlab_mortar.mortar:MortarP0",
            "multipliers constant around each slave node",
            "Baillet & Sassi 2005",
        ),
        Part(
            "contact",
            "mortar-p1",
            "contactlab_mortar.mortar:MortarP1",
            "multipliers linear between slave nodes",
            "Baillet & Sassi 2005",
        ),
        Part(
            "contact",
            "mortar-dual",
            "contactlab_mortar.mortar:MortarDual",
            "multipliers biorthogonal to the slave's hats: diagonal coupling",
            "Wohlmuth 2000",
        ),
    ]
