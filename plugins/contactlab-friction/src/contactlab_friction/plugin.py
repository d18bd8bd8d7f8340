"""Friction and pressure laws on offer."""

from __future__ import annotations

from contactlab.api.plugin import Part, hookimpl


@hookimpl
def contactlab_parts() -> list[Part]:
    """Offer the friction laws of Coulomb and Tresca, and pressure laws."""
    return [
        Part(
            "friction",
            "coulomb",
            "contactlab_friction.coulomb:Coulomb",
            "tangential force bounded by mu times the normal force",
            "Baillet & Sassi 2005, [7] and [29]",
        ),
        Part(
            "friction",
            "tresca",
            "contactlab_friction.tresca:Tresca",
            "tangential stress bounded by a constant, on closed surfaces or everywhere",
            "Baillet & Sassi 2005, [17]-[18] and 5.2",
        ),
        Part(
            "enforcement",
            "linear-pressure",
            "contactlab_friction.pressure:LinearPressure",
            "pressure proportional to the overlap",
            "Wriggers 2006, ch. 10.3",
        ),
        Part(
            "enforcement",
            "exponential-pressure",
            "contactlab_friction.pressure:ExponentialPressure",
            "softened contact: an exponential that begins before surfaces touch",
        ),
        Part(
            "enforcement",
            "tabular-pressure",
            "contactlab_friction.pressure:TabularPressure",
            "pressure by a table of gaps",
        ),
        Part(
            "enforcement",
            "nitsche",
            "contactlab_friction.nitsche:Nitsche",
            "pressure by the stress of the slave's cells, in statics",
            "Chouly, Hild & Renard 2015",
        ),
    ]
