"""How deep facets may be against the way that surfaces come together: a quarter of a shaft in a hub, Lame's pressure.

`python benchmarks/studies/facet_depth.py` prints a table for docs/decisions.md: depth over approach as the warning
`coarse-facets` measures it, and what it does to the pressure.
"""

from __future__ import annotations

from typing import Any
from unittest.mock import patch

import numpy as np

from contactlab.api import Floats
from contactlab.run import judgement
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene

RADII = (2.5, 5.0, 10.0)  # mm
INTERFERENCE = 0.02  # mm
YOUNG, POISSON = 1000.0, 0.3


def press_fit(cells: int, ratio: float, algorithm: str) -> Scene:
    """As many facets as there are cells along the arc of the shaft, `ratio` times as many along that of the hub."""
    inner, between, outer = RADII

    def quarter(low: float, high: float, along: int) -> dict[str, Any]:
        mesh = {"use": "ring", "radii": [low, high], "angles": [0.0, 90.0], "cells": [along, 8]}
        return {"element": "q1", "material": "m", "mesh": mesh}

    law = {"use": "linear-elastic", "young": YOUNG, "poisson": POISSON, "density": 1e-9}
    data = {
        "integrator": {"use": "newton", "nested": False},
        "materials": {"m": law},
        "bodies": {
            "shaft": quarter(inner, between + INTERFERENCE, cells),
            "hub": quarter(between, outer, round(cells * ratio)),
        },
        "contacts": [
            {"slave": "shaft.outer", "master": "hub.inner", "algorithm": algorithm, "start": {"overlap": "ramp"}}
        ],
        "supports": [
            {"on": f"{body}.{end}", axis: 0.0}
            for body in ("shaft", "hub")
            for end, axis in (("start", "uy"), ("end", "ux"))
        ],
        "record": {"frames": 1, "recorders": []},
    }
    return Scene.from_data(data)


def exact() -> float:
    """Lame's pressure [MPa] in plane strain."""
    a, b, c = RADII
    nu, modulus = POISSON / (1.0 - POISSON), YOUNG / (1.0 - POISSON**2)
    compliance = ((c**2 + b**2) / (c**2 - b**2) + nu) + ((b**2 + a**2) / (b**2 - a**2) - nu)
    return INTERFERENCE / b * modulus / compliance


def measured(scene: Scene) -> tuple[float, float, float]:
    """Depth over approach, error of the mean pressure, largest difference of a node from the mean."""
    with patch.object(judgement, "FACETS", 1e-9):
        results = simulate(scene)
    (told,) = (warning for warning in results.warnings if warning.code == "coarse-facets")
    pressure: Floats = np.asarray(results.contact["contacts.0"].last.pressure)
    mean = float(pressure.mean())
    return told.value / told.limit * 1e-9, mean / exact() - 1.0, float(np.abs(pressure / mean - 1.0).max())


def main() -> None:
    """Print the table."""
    print("| cells | ratio | algorithm | depth / approach | mean pressure | worst node |\n|---|---|---|---|---|---|")
    for algorithm in ("mortar-p0", "mortar-p1", "node-on-segment"):
        for ratio in (1.0, 1.25, 1.5, 2.0):
            for cells in (12, 18, 24, 36, 48):
                depth, mean, node = measured(press_fit(cells, ratio, algorithm))
                print(f"| {cells} | {ratio} | {algorithm} | {depth:.3f} | {mean:+.1%} | {node:.1%} |", flush=True)


if __name__ == "__main__":
    main()
