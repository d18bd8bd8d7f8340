"""Contact at points of the slave, and without a slave, on offer."""

from __future__ import annotations

from contactlab.api.plugin import Part, hookimpl


@hookimpl
def contactlab_parts() -> list[Part]:
    """Offer one-pass contact of nodes and of Gauss points with segments, and contact without a slave."""
    return [
        Part(
            "contact",
            "node-on-segment",
            "contactlab_segments.node_on_segment:NodeOnSegment",
            "slave nodes against master segments, one pass",
            "Hallquist, Goudreau & Benson 1985",
        ),
        Part(
            "contact",
            "gauss-point",
            "contactlab_segments.gauss_point:GaussPoint",
            "Gauss points of the slave against master segments; passes = 2: of both sides, neither is the slave",
            "Fischer & Wriggers 2005; Sauer & De Lorenzis 2013; Sauer & De Lorenzis 2015",
        ),
        Part(
            "contact",
            "midplane",
            "contactlab_segments.midplane:Midplane",
            "overlaps of both sides on their common line, a penalty without slave and master; implicit runs",
            "McDevitt & Laursen 2000; Sauer & De Lorenzis 2013",
        ),
    ]
