"""Helpers of the cases of rings within rings: the scene of a quarter, and the error of a curve around it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from contactlab.api import Floats, Job, Record, Setup
from contactlab_cases.statics import static_job

STEEL = (70000.0, 0.3)
"""E [MPa] and nu."""


def nested_rings(
    setup: Setup, radii: Sequence[tuple[float, float]], cells: Sequence[int], moduli: Sequence[tuple[float, float]],
    contact: Mapping[str, Any], name: str = "pressed", **more: Any,
) -> Job:  # fmt: skip
    """A quarter of rings that lie within each other, ring0 the innermost, each `cells` around; symmetric ends."""
    names = [f"ring{k}" for k in range(len(radii))]
    bodies = {
        body: {
            "material": body,
            "element": setup.element,
            "mesh": {"use": "ring", "radii": list(r), "angles": [0.0, 90.0], "cells": [n, max(2, n // 3)]},
        }
        for body, r, n in zip(names, radii, cells, strict=True)
    }
    ends = [{"on": f"{body}.{end}", axis: 0.0} for body in names for end, axis in (("start", "uy"), ("end", "ux"))]
    sides = {"algorithm": setup.algorithm, "swap": setup.swap} | dict(contact)
    contacts = [{"slave": f"{inner}.outer", "master": f"{outer}.inner"} | sides for inner, outer in pairwise(names)]
    materials = {body: {"young": e, "poisson": nu} for body, (e, nu) in zip(names, moduli, strict=True)}
    return static_job(name, setup, materials, bodies, contact, contacts=contacts, supports=ends, **more)


def squeeze(on: str, mean: float, wave: float) -> dict[str, Any]:
    """A load: the pressure mean (1 + wave cos 2t) [MPa]."""
    return {
        "on": on, "pressure": {"ramp": "linear", "to": mean}, "profile": {"by": "angle", "cosine": [1.0, wave, 180.0]},
    }  # fmt: skip


def around(record: Record, column: str = "pressure", contact: str = "contacts.0") -> Callable[[Floats], Floats]:
    """A traction of the last frame as a function of the angle [rad], linear between nodes."""
    curve = record.curve(contact)
    angle, values = np.arctan2(curve.y, curve.x), getattr(curve, column)
    return lambda at: np.asarray(np.interp(at, angle, values, period=2.0 * np.pi))


def relative(found: Floats, exact: Floats) -> float:
    """Relative L2 difference of values at equal distances."""
    return float(np.sqrt(np.mean((found - exact) ** 2) / np.mean(exact**2)))
