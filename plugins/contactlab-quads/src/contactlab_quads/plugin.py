"""Quadrilaterals on offer."""

from __future__ import annotations

from contactlab.api.plugin import Part, hookimpl


@hookimpl
def contactlab_parts() -> list[Part]:
    """Offer quadrilaterals of first and second degree."""
    return [
        Part("element", "q1", "contactlab_quads.q1:Q1", "bilinear quadrilateral, 2x2 points", "Hughes 2000, ch. 3"),
        Part(
            "element",
            "q1-fbar",
            "contactlab_quads.q1_fbar:Q1Fbar",
            "bilinear quadrilateral, one dilatation per cell: does not lock",
            "de Souza Neto, Peric, Dutko & Owen 1996",
        ),
        Part(
            "element",
            "q1-reduced",
            "contactlab_quads.q1_reduced:Q1Reduced",
            "bilinear quadrilateral, one point and hourglass stiffness",
            "Flanagan & Belytschko 1981",
        ),
        Part(
            "element",
            "q2",
            "contactlab_quads.q2:Q2",
            "8-node serendipity quadrilateral, 3x3 points",
            "Hinton, Rock & Zienkiewicz 1976",
        ),
        Part(
            "element",
            "q2-lagrange",
            "contactlab_quads.q2_lagrange:Q2Lagrange",
            "9-node quadrilateral, 3x3 points, Lobatto mass",
            "Hughes 2000, ch. 3",
        ),
    ]
