"""Soft discs: the scene of thrown and of colliding ones."""

from __future__ import annotations

from typing import Any

RADIUS, DENSITY = 10.0, 7.8e-9  # mm, t/mm3
MASS = DENSITY * 3.141592653589793 * RADIUS**2  # t per mm
INERTIA = 0.5 * MASS * RADIUS**2


def soft_disc(cells: int, **more: Any) -> dict[str, Any]:
    """A disc with `cells` along each quarter and half as many out from its core."""
    mesh = {"use": "disc", "radius": RADIUS, "cells": [cells, max(1, cells // 2)]}
    return {"material": "soft", "mesh": mesh} | more


def soft(young: float) -> dict[str, Any]:
    """The law of the discs."""
    return {"use": "neo-hookean", "young": young, "poisson": 0.3, "density": DENSITY}
