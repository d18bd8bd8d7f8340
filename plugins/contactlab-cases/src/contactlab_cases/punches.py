"""Mesh of a block under a flat punch: cells shrink geometrically towards the edges, where the pressure is singular."""

from __future__ import annotations

from typing import Any

from contactlab_cases.statics import graded_count

EDGE = 4e-3
"""Length of the cells next to an edge over the half-width of the punch."""
GROWTH = 1.22
"""Length of a cell over its neighbour's, nearer to the edge; 20 cells fill a half-width."""


def block_under_punch(half: float, far: float, depth: float, size: float, middle: float = 0.0) -> dict[str, Any]:
    """Block |x| < `far`, -`depth` < y < 0 [mm] under contact of half-width `half` about x = `middle` [mm].

    size  of the cells over their standard size: 0.5 halves all of them
    """
    growth, edge = GROWTH**size, EDGE * size * half
    inside, outside, rows = (graded_count(length, edge, growth) for length in (half, far - half, depth))
    inner, outer = growth ** (inside - 1), growth ** (outside - 1)
    return {
        "use": "rectangle", "x": [-far, middle - half, middle, middle + half, far], "y": [-depth, 0.0],
        "cells": [[outside, inside, inside, outside], rows],
        "grading": [[1.0 / outer, inner, 1.0 / inner, outer], growth ** (1 - rows)],
    }  # fmt: skip
