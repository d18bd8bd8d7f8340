"""Limits of the fields that integrators with iterations share."""

from __future__ import annotations


def refuse_limits(steps: int, tolerance: float, iterations: int) -> None:
    """Raise ValueError for values with which no iteration can work."""
    if steps < 1:
        raise ValueError(f"steps: got {steps}, allowed: at least 1")
    if not 0.0 < tolerance < 1e-2:
        raise ValueError(f"tolerance: got {tolerance}, allowed: 0 < tolerance < 0.01")
    if iterations < 1:
        raise ValueError(f"iterations: got {iterations}, allowed: at least 1")
