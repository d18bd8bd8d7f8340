"""A ring under pressure closes its gap to another one: Lame's two rings, joined where the gap is closed."""

from __future__ import annotations

import numpy as np
import pytest

from contactlab import Results, Scene, simulate

MODULI, NU, (INNER, MIDDLE, OUTER), GAP, INSIDE = (1000.0, 2000.0), 0.3, (1.0, 1.5, 2.0), 1e-3, 3.0


def rings(element: str, cells: tuple[int, int], algorithm: str) -> Results:
    radii = {"i": (INNER, MIDDLE - GAP), "o": (MIDDLE, OUTER)}
    data = {
        "integrator": "newton",
        "materials": {
            name: {"use": "neo-hookean", "young": young, "poisson": NU, "density": 1e-9}
            for name, young in zip(radii, MODULI, strict=True)
        },
        "bodies": {
            name: {"element": element, "material": name,
                   "mesh": {"use": "ring", "radii": radii[name], "cells": [cells[k], 4], "angles": [0.0, 90.0]}}
            for k, name in enumerate(radii)
        },
        "contacts": [{"slave": "i.outer", "master": "o.inner", "algorithm": algorithm}],
        "supports": [
            {"on": f"{name}.{end}", axis: 0.0} for name in radii for end, axis in (("start", "uy"), ("end", "ux"))
        ],
        "loads": [{"on": "i.inner", "pressure": INSIDE, "follower": False}],
        "record": {"frames": 1, "recorders": []},
    }  # fmt: skip
    return simulate(Scene.from_data(data))


def pressure() -> float:
    """The pressure between the rings [MPa] at which the outer one gives way as much as the inner one, less the gap."""

    def expansion(young: float, inner: float, outer: float, pressures: tuple[float, float]) -> float:
        area = outer**2 - inner**2
        even = (pressures[0] * inner**2 - pressures[1] * outer**2) / area
        bore = (pressures[0] - pressures[1]) * (inner * outer) ** 2 / area
        return (1.0 + NU) / young * ((1.0 - 2.0 * NU) * even * MIDDLE + bore / MIDDLE)

    def closed(p: float) -> float:
        return expansion(MODULI[0], INNER, MIDDLE, (INSIDE, p)) - expansion(MODULI[1], MIDDLE, OUTER, (p, 0.0)) - GAP

    return closed(0.0) / (closed(0.0) - closed(1.0))


@pytest.mark.parametrize(("cells", "side"), [((24, 16), "large"), ((16, 24), "small")])
def test_facets_of_unlike_meshes_are_told_with_the_force_that_they_add_or_take(
    cells: tuple[int, int], side: str
) -> None:
    """Coarse facets of the outer ring come nearer than its circle by more than the gap, the inner ones stay away."""
    results = rings("q1", cells, "mortar-p1")
    force = np.hypot(*results.summary["contacts"]["contacts.0"]["resultant"])
    error = force / (pressure() * MIDDLE * np.sqrt(2.0)) - 1.0
    told = next(warning for warning in results.warnings if warning.code == "kept-gap")
    assert f"too {side}" in told.text
    assert (error > 0.0) == (side == "large")
    assert 0.5 * abs(error) < told.value < 2.0 * abs(error)  # the bodies are those of coarse cells, too


def test_nodes_find_rest_in_the_valleys_between_quadratic_edges() -> None:
    """Edges of the outer ring meet in kinks of 1e-3; strains of 5e-3 change Lame's pressure by less than 1 %."""
    results = rings("q2", (8, 8), "node-on-segment")
    assert results.status == "finished"
    assert results.summary["iterations"] <= 6
    np.testing.assert_allclose(results.contact["contacts.0"].last.nodal_pressure, pressure(), rtol=1e-2)
