"""Block on a rigid plane with a given friction bound: edge of contact, lift-off, bounds, and convergence in energy."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import contactlab
from contactlab.api import ContactCurve, Floats
from contactlab.results.results import Results
from contactlab.scene.scene import Scene
from contactlab.studies.energy_norm import energy_distance, energy_norm

MORTAR = pytest.mark.parametrize("algorithm", ["mortar-p0", "mortar-p1"])
WHERE = pytest.mark.parametrize("where", ["everywhere", "closed"])
NEIGHBOURS = {"mortar-p0": (1 / 8, 3 / 8), "mortar-p1": (1 / 6, 1 / 3)}  # int hat_j psi_k, int of half a hat_k psi_k


def scene(algorithm: str, where: str, level: int) -> Scene:
    changes = {"contacts.0.algorithm": algorithm, "contacts.0.friction.where": where, "level": level}
    return contactlab.load_scene("tresca-block").with_(changes | {"integrator.tolerance": 1e-10})


@cache
def run(algorithm: str, where: str, level: int) -> Results:
    results = contactlab.simulate(scene(algorithm, where, level))
    assert results.status == "finished", results.reason
    assert not any("rejected after" in event.text for event in results.events)
    return results


def curve(results: Results) -> ContactCurve:
    return results.contact["contacts.0"].last


def edge_forces(curve: ContactCurve, multiplier: Floats, algorithm: str) -> tuple[Floats, Floats]:
    """Nodal forces T Lambda [N] and covered lengths [mm] from the multipliers of a chain of Q1 edges."""
    h = np.hypot(np.diff(curve.x), np.diff(curve.y))
    beside, own = NEIGHBOURS[algorithm]
    matrix = np.zeros((len(h) + 1, len(h) + 1))
    for i, length in enumerate(h):
        matrix[i : i + 2, i : i + 2] += length * np.array([[own, beside], [beside, own]])
    return matrix @ multiplier, matrix.sum(axis=1)


@MORTAR
@WHERE
def test_edge_of_contact_and_lift(algorithm: str, where: str) -> None:
    """Contact ends at 0.717 (everywhere) and 0.715-0.727 (closed) in an independent active-set code, within a segment;
    what is lifted differs four times between the two readings, 2.25e-3 and 4.9e-4 mm on a twice finer mesh."""
    results, h = run(algorithm, where, 4), 0.0125
    last = curve(results)
    start = np.linspace(0.0, 1.3, len(last.x))
    closed = start[np.asarray(last.nodal_pressure) > 0.0]
    lower, upper, lift = {"everywhere": (0.717, 0.717, 2.25e-3), "closed": (0.715, 0.727, 4.9e-4)}[where]
    assert lower - h <= closed.max() <= upper + h
    assert np.max(last.gap) == pytest.approx(lift, rel=0.015)
    held = [np.asarray(force) for force in results.summary["reactions"].values()]
    assert np.abs(sum(held)).max() < 1e-7 * np.abs(held).max()  # the residual that ends an iteration


@MORTAR
@WHERE
def test_shear_forces_keep_to_their_bound(algorithm: str, where: str) -> None:
    """Forces of the nodes stay within s times the length they stand for; multipliers of the weak cone need not.

    The support of the right edge takes what would fall on the last node, whose multiplier is of no use here.
    """
    last = curve(run(algorithm, where, 2))
    y_t, length = edge_forces(last, np.asarray(last.shear), algorithm)
    assert np.abs(y_t / length)[:-2].max() <= 200.0 * (1.0 + 1e-8)
    assert np.abs(y_t / length)[:-2].max() == pytest.approx(200.0, rel=1e-8)  # it does slip
    y_n, length = edge_forces(last, np.asarray(last.pressure), algorithm)
    assert y_n[:-2].min() >= -1e-10 * y_n.max()  # no tension in forces ...
    assert np.min(last.pressure) < 0.0  # ... though multipliers dip below zero at the edge of contact


@WHERE
def test_both_mortars_move_alike_on_a_plane(where: str) -> None:
    """On a flat rigid surface the rows of both are those of the slave's nodes; only their multipliers differ."""
    p0, p1 = run("mortar-p0", where, 2), run("mortar-p1", where, 2)
    size = np.abs(p0.displacement).max()
    assert np.abs(p0.displacement - p1.displacement).max() < 1e-8 * size
    assert np.abs(np.asarray(curve(p0).pressure) - np.asarray(curve(p1).pressure)).max() > 1.0


def test_energy_norm_falls_as_its_corners_allow() -> None:
    """Rate 1/2 where fixed and free edges meet on a straight line; at least 0.45 of distances of meshes 2 apart."""
    apart = []
    for level in (1, 2):
        fine, better = scene("mortar-p0", "everywhere", 2 * level), run("mortar-p0", "everywhere", 2 * level)
        distance = energy_distance(run("mortar-p0", "everywhere", level), better, fine, "block")
        apart.append(distance / energy_norm(better, fine, "block"))
    assert np.log2(apart[0] / apart[1]) >= 0.45
    assert apart[0] < 0.2
